#include "cache/picture_rows.h"

#include <fmt/format.h>
#include <xxhash.h>

namespace tintree::cache {
namespace {

const char* table_of(PictureKind kind) { return kind == PictureKind::kTexture ? "texture" : "normal"; }

std::int64_t checksum_of(std::int64_t key, std::span<const std::byte> payload) {
  const std::uint64_t seed = XXH3_64bits(payload.data(), payload.size());
  return static_cast<std::int64_t>(XXH3_64bits_withSeed(&key, sizeof key, seed));
}

/// The payload in the row `key, checksum, payload` that the statement is at.
Expected<std::span<const std::byte>> payload_in(const SqliteDb::Statement& row, PictureKind kind,
                                                const std::string& path) {
  const auto payload = row.blob(2);
  if (checksum_of(row.integer(0), payload) == row.integer(1)) return payload;
  return fail(ErrorCode::kBadData,
              fmt::format("the {} of tile {} is damaged (its checksum does not hold); build the file again or restore "
                          "a copy",
                          picture_name(kind), codec::TileId::from_key(row.integer(0)).text()),
              path);
}

}  // namespace

const char* picture_name(PictureKind kind) { return kind == PictureKind::kTexture ? "texture" : "normal map"; }

Expected<void> create_picture_table(SqliteDb& db, PictureKind kind) {
  return db.exec(
      fmt::format("CREATE TABLE {} (key INTEGER PRIMARY KEY, checksum INTEGER NOT NULL, payload BLOB NOT NULL)",
                  table_of(kind))
          .c_str());
}

Expected<SqliteDb::Statement> prepare_picture_insert(const SqliteDb& db, PictureKind kind) {
  return db.prepare(fmt::format("INSERT OR REPLACE INTO {} VALUES (?, ?, ?)", table_of(kind)).c_str());
}

void bind_picture(SqliteDb::Statement& insert, const codec::TileId& id, std::span<const std::byte> payload) {
  insert.bind(1, id.key());
  insert.bind(2, checksum_of(id.key(), payload));
  insert.bind(3, payload);
}

Expected<std::optional<std::vector<std::byte>>> read_picture_row(const SqliteDb& db, PictureKind kind,
                                                                 const codec::TileId& id) {
  auto statement =
      db.prepare(fmt::format("SELECT key, checksum, payload FROM {} WHERE key = ?", table_of(kind)).c_str());
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, id.key());
  const auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return std::nullopt;
  const auto payload = payload_in(*statement, kind, db.path());
  if (!payload) return tl::unexpected(payload.error());
  return std::vector<std::byte>(payload->begin(), payload->end());
}

Expected<void> for_each_picture(const SqliteDb& db, PictureKind kind,
                                const std::function<void(const codec::TileId&, std::span<const std::byte>)>& visit) {
  auto statement =
      db.prepare(fmt::format("SELECT key, checksum, payload FROM {} ORDER BY key", table_of(kind)).c_str());
  if (!statement) return tl::unexpected(statement.error());
  while (true) {
    const auto row = statement->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
    const auto payload = payload_in(*statement, kind, db.path());
    if (!payload) return tl::unexpected(payload.error());
    visit(codec::TileId::from_key(statement->integer(0)), *payload);
  }
}

Expected<std::vector<std::int64_t>> picture_sizes(const SqliteDb& db, PictureKind kind) {
  return db.query_integers(fmt::format("SELECT length(payload) FROM {} ORDER BY key", table_of(kind)).c_str());
}

Expected<std::uint64_t> sum_picture_bytes(const SqliteDb& db, PictureKind kind) {
  const auto sum = db.query_integer(fmt::format("SELECT SUM(LENGTH(payload)) FROM {}", table_of(kind)).c_str());
  if (!sum) return tl::unexpected(sum.error());
  return static_cast<std::uint64_t>(*sum);
}

Expected<std::vector<std::int64_t>> read_picture_keys(const SqliteDb& db, PictureKind kind) {
  return db.query_integers(fmt::format("SELECT key FROM {} ORDER BY key", table_of(kind)).c_str());
}

}  // namespace tintree::cache
