#include "tests/support/picture_change.h"

#include <stdexcept>
#include <string>

#include "cache/tile_digest.h"
#include "cache/tile_rows.h"

namespace tintree::test {
namespace {

template <typename T>
void require(const Expected<T>& result) {
  if (!result) throw std::runtime_error(result.error().text());
}

template <typename T>
T& checked(Expected<T>& result) {
  require(result);
  return *result;
}

/// Gives a changed tree the digest that belongs to it.
void settle_digest(const cache::SqliteDb& db) {
  auto manifest = cache::read_manifest(db);
  cache::TreeDigest digest;
  require(cache::for_each_tile(db, [&digest](const cache::StoredTile& tile) { digest.add(tile); }));
  require(cache::add_pictures(db, checked(manifest), digest));
  manifest->digest = digest.text();
  require(cache::write_manifest(db, *manifest));
}

}  // namespace

void replace_picture(const std::string& tree, cache::PictureKind kind, const codec::TileId& id,
                     std::span<const std::byte> bytes) {
  auto opened = cache::SqliteDb::open(tree, cache::SqliteDb::Access::kOwn);
  const cache::SqliteDb& db = checked(opened);
  auto prepared = cache::prepare_picture_insert(db, kind);
  cache::SqliteDb::Statement& insert = checked(prepared);
  cache::bind_picture(insert, id, bytes);
  require(insert.step());
  settle_digest(db);
}

void remove_texture(const std::string& tree, const codec::TileId& id) {
  auto opened = cache::SqliteDb::open(tree, cache::SqliteDb::Access::kOwn);
  cache::SqliteDb& db = checked(opened);
  require(db.exec(("DELETE FROM texture WHERE key = " + std::to_string(id.key())).c_str()));
  settle_digest(db);
}

}  // namespace tintree::test
