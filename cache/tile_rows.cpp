#include "cache/tile_rows.h"

#include <filesystem>

#include <fmt/format.h>
#include <xxhash.h>

#include "cache/tile_digest.h"

namespace tintree::cache {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kApplicationId = 0x54494e54;  // "TINT"
/// The newest; version 1 has one level a doubling of the error, so it is written where that is so.
constexpr std::int64_t kFormatVersion = 2;

constexpr const char* kSchema =
    "PRAGMA page_size = 4096;"
    "PRAGMA journal_mode = WAL;"
    "PRAGMA application_id = 1414090324;"
    "CREATE TABLE metadata (name TEXT PRIMARY KEY, value BLOB NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE tile (key INTEGER PRIMARY KEY, vertices INTEGER NOT NULL, triangles INTEGER NOT NULL,"
    " z_min_m REAL NOT NULL, z_max_m REAL NOT NULL, error_m REAL NOT NULL, rms_m REAL NOT NULL,"
    " border_error_m REAL NOT NULL, checksum INTEGER NOT NULL, payload BLOB NOT NULL);";

constexpr const char* kSelectTile =
    "SELECT key, vertices, triangles, z_min_m, z_max_m, error_m, rms_m, border_error_m, checksum, payload"
    " FROM tile WHERE key = ?";

constexpr const char* kSelectAllTiles =
    "SELECT key, vertices, triangles, z_min_m, z_max_m, error_m, rms_m, border_error_m, checksum, payload"
    " FROM tile ORDER BY key";

std::int64_t checksum_of(std::span<const std::byte> bytes) {
  return static_cast<std::int64_t>(XXH3_64bits(bytes.data(), bytes.size()));
}

/// The tile in the statement's current row.
Expected<StoredTile> tile_in_row(const SqliteDb::Statement& row, const std::string& path) {
  StoredTile tile;
  tile.info.id = codec::TileId::from_key(row.integer(0));
  tile.info.vertices = static_cast<std::uint32_t>(row.integer(1));
  tile.info.triangles = static_cast<std::uint32_t>(row.integer(2));
  tile.info.z_min_m = row.real(3);
  tile.info.z_max_m = row.real(4);
  tile.info.error_m = row.real(5);
  tile.info.rms_m = row.real(6);
  tile.info.border_error_m = row.real(7);
  const auto payload = row.blob(9);
  tile.payload.assign(payload.begin(), payload.end());
  if (checksum_of(tile) != row.integer(8)) {
    return fail(ErrorCode::kBadData,
                fmt::format("tile {} is damaged (its checksum does not hold); build the file again or restore a copy",
                            tile.info.id.text()),
                path);
  }
  return tile;
}

}  // namespace

Expected<void> create_tables(SqliteDb& db, const Manifest& manifest) {
  auto done = db.exec(kSchema);
  if (done)
    done = db.exec(manifest.layout.levels_per_doubling == 1 ? "PRAGMA user_version = 1" : "PRAGMA user_version = 2");
  for (const PictureKind kind : kPictureKinds) {
    if (done && manifest.picture_size(kind) > 0) done = create_picture_table(db, kind);
  }
  return done;
}

void bind_tile(SqliteDb::Statement& insert, const StoredTile& tile) {
  insert.bind(1, tile.info.id.key());
  insert.bind(2, std::int64_t{tile.info.vertices});
  insert.bind(3, std::int64_t{tile.info.triangles});
  insert.bind(4, tile.info.z_min_m);
  insert.bind(5, tile.info.z_max_m);
  insert.bind(6, tile.info.error_m);
  insert.bind(7, tile.info.rms_m);
  insert.bind(8, tile.info.border_error_m);
  insert.bind(9, checksum_of(tile));
  insert.bind(10, std::span<const std::byte>(tile.payload));
}

Expected<StoredTile> read_tile(const SqliteDb& db, const codec::TileId& id) {
  auto statement = db.prepare(kSelectTile);
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, id.key());
  auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return fail(ErrorCode::kBadData, fmt::format("tile {} is missing", id.text()), db.path());
  return tile_in_row(*statement, db.path());
}

Expected<void> for_each_tile(const SqliteDb& db, const std::function<void(const StoredTile&)>& visit) {
  auto statement = db.prepare(kSelectAllTiles);
  if (!statement) return tl::unexpected(statement.error());
  while (true) {
    auto row = statement->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
    auto tile = tile_in_row(*statement, db.path());
    if (!tile) return tl::unexpected(tile.error());
    visit(*tile);
  }
}

Expected<void> add_pictures(const SqliteDb& db, const Manifest& manifest, TreeDigest& digest) {
  Expected<void> done;
  for (const PictureKind kind : kPictureKinds) {
    if (!done || manifest.picture_size(kind) == 0) continue;
    done = for_each_picture(db, kind, [&digest, kind](const codec::TileId& id, std::span<const std::byte> payload) {
      digest.add(kind, id, payload);
    });
  }
  return done;
}

Expected<PackedSize> packed_size(const SqliteDb& db, const Manifest& manifest) {
  PackedSize all;
  const auto add = [&all](const Expected<std::vector<std::int64_t>>& payloads) -> Expected<void> {
    if (!payloads) return tl::unexpected(payloads.error());
    PackedSize table;
    for (const std::int64_t bytes : *payloads) table.add(static_cast<std::uint64_t>(bytes));
    all += table;
    return {};
  };
  auto done = add(db.query_integers("SELECT length(payload) FROM tile ORDER BY key"));
  for (const PictureKind kind : kPictureKinds) {
    if (done && manifest.picture_size(kind) > 0) done = add(picture_sizes(db, kind));
  }
  if (!done) return tl::unexpected(done.error());
  return all;
}

Expected<std::vector<std::int64_t>> read_keys(const SqliteDb& db) {
  return db.query_integers("SELECT key FROM tile ORDER BY key");
}

Expected<std::vector<std::byte>> read_metadata(const SqliteDb& db, const std::string& name) {
  auto statement = db.prepare("SELECT value, checksum FROM metadata WHERE name = ?");
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, name);
  auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  if (!*row) return fail(ErrorCode::kBadData, "holds no " + name + "; the file is incomplete", db.path());
  const auto value = statement->blob(0);
  if (checksum_of(value) != statement->integer(1)) {
    return fail(ErrorCode::kBadData, "its " + name + " is damaged; build the file again or restore a copy", db.path());
  }
  return std::vector<std::byte>(value.begin(), value.end());
}

Expected<void> write_metadata(const SqliteDb& db, const std::string& name, std::span<const std::byte> value) {
  auto statement = db.prepare("INSERT OR REPLACE INTO metadata VALUES (?, ?, ?)");
  if (!statement) return tl::unexpected(statement.error());
  statement->bind(1, name);
  statement->bind(2, value);
  statement->bind(3, checksum_of(value));
  if (auto done = statement->step(); !done) return tl::unexpected(done.error());
  return {};
}

Expected<Manifest> read_manifest(const SqliteDb& db) {
  auto bytes = read_metadata(db, "manifest");
  if (!bytes) return tl::unexpected(bytes.error());
  auto manifest = Manifest::from_json(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  if (!manifest) manifest.error().where = db.path();
  return manifest;
}

Expected<void> write_manifest(const SqliteDb& db, const Manifest& manifest) {
  const std::string json = manifest.to_json();
  return write_metadata(db, "manifest", std::as_bytes(std::span(json)));
}

Expected<SqliteDb> open_existing(const std::string& path, SqliteDb::Access access) {
  std::error_code ec;
  if (!fs::exists(path, ec)) return fail(ErrorCode::kIo, "no such file", path);
  if (fs::is_directory(path, ec)) return fail(ErrorCode::kIo, "is a directory, not a tintree file", path);
  auto db = SqliteDb::open(path, access);
  if (!db) return db;
  const auto application = db->query_integer("PRAGMA application_id");
  if (!application && !db->is_no_database()) return tl::unexpected(application.error());
  if (!application || *application != kApplicationId)
    return fail(ErrorCode::kBadData, "is no tintree file; tintree-build makes one of a DEM", path);
  const auto version = db->query_integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*version > kFormatVersion) {
    return fail(ErrorCode::kBadData,
                fmt::format("has format version {}, newer than the {} this program reads; update tintree", *version,
                            kFormatVersion),
                path);
  }
  if (*version < 1) return fail(ErrorCode::kBadData, "is damaged (no format version)", path);
  const auto page_size = db->query_integer("PRAGMA page_size");
  if (!page_size) return tl::unexpected(page_size.error());
  const auto size = fs::file_size(path, ec);
  if (size % static_cast<std::uint64_t>(*page_size) != 0) {
    return fail(ErrorCode::kBadData, "is cut short; build the file again or restore a copy", path);
  }
  return db;
}

}  // namespace tintree::cache
