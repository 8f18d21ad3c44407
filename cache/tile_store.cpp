#include "cache/tile_store.h"

#include <mutex>
#include <utility>

#include "cache/tile_digest.h"
#include "cache/tile_rows.h"
#include "codec/mesh_codec.h"

namespace tintree::cache {

TileDecoder::TileDecoder(const Manifest& manifest, std::function<Expected<StoredTile>(const codec::TileId&)> read)
    : manifest_(&manifest),
      decoder_(codec::make_tile_decoder(
          manifest.method, manifest.layout,
          [read = std::move(read)](const codec::TileId& id) -> Expected<std::vector<std::byte>> {
            auto tile = read(id);
            if (!tile) return tl::unexpected(tile.error());
            return std::move(tile->payload);
          })) {}

Expected<codec::TileMesh> TileDecoder::decode(const StoredTile& tile) const {
  if (decoder_ == nullptr) {
    return fail(ErrorCode::kBadData, "method '" + manifest_->method + "' is unknown; update tintree");
  }
  auto mesh = decoder_->decode(tile.info.id, tile.payload);
  if (mesh) {
    auto valid = codec::validate(*mesh, manifest_->layout.cells_across(tile.info.id.level));
    if (!valid) mesh = tl::unexpected(valid.error());
  }
  if (!mesh) mesh.error().where = "tile " + tile.info.id.text();
  return mesh;
}

struct TileStore::Impl {
  Impl(SqliteDb d, Manifest m, TileBounds b)
      : db(std::move(d)),
        manifest(std::move(m)),
        bounds(std::move(b)),
        decoder(manifest, [this](const codec::TileId& id) {
          const std::scoped_lock lock(turn);
          return read_tile(db, id);
        }) {}

  SqliteDb db;
  Manifest manifest;
  TileBounds bounds;
  mutable std::mutex turn;
  TileDecoder decoder;
};

TileStore::TileStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TileStore::TileStore(TileStore&&) noexcept = default;
TileStore& TileStore::operator=(TileStore&&) noexcept = default;
TileStore::~TileStore() = default;

const std::string& TileStore::path() const { return impl_->db.path(); }
const Manifest& TileStore::manifest() const { return impl_->manifest; }
const TileBounds& TileStore::bounds() const { return impl_->bounds; }

Expected<TileStore> TileStore::open(const std::string& path) {
  auto db = open_existing(path, SqliteDb::Access::kRead);
  if (!db) return tl::unexpected(db.error());
  auto manifest = read_manifest(*db);
  if (!manifest) return tl::unexpected(manifest.error());
  if (!manifest->complete) {
    return fail(ErrorCode::kBadData, "is an unfinished build; finish it with tintree-build --resume", path);
  }
  auto bytes = read_metadata(*db, "bounds");
  if (!bytes) return tl::unexpected(bytes.error());
  auto bounds = TileBounds::from_bytes(manifest->layout, *bytes);
  if (!bounds) {
    bounds.error().where = path;
    return tl::unexpected(bounds.error());
  }
  if (manifest->texture_size > 0) bounds->set_textures(manifest->texture_size, manifest->texture_depth);
  auto impl = std::make_unique<Impl>(std::move(*db), std::move(*manifest), std::move(*bounds));
  return TileStore(std::move(impl));
}

Expected<StoredTile> TileStore::read(const codec::TileId& id) const {
  const std::scoped_lock lock(impl_->turn);
  return read_tile(impl_->db, id);
}

Expected<std::optional<std::vector<std::byte>>> TileStore::read_picture(PictureKind kind,
                                                                        const codec::TileId& id) const {
  if (impl_->manifest.picture_size(kind) == 0) return std::nullopt;
  const std::scoped_lock lock(impl_->turn);
  return read_picture_row(impl_->db, kind, id);
}

Expected<std::vector<std::int64_t>> TileStore::picture_keys(PictureKind kind) const {
  if (impl_->manifest.picture_size(kind) == 0) return std::vector<std::int64_t>();
  const std::scoped_lock lock(impl_->turn);
  return read_picture_keys(impl_->db, kind);
}

Expected<std::uint64_t> TileStore::picture_bytes(PictureKind kind) const {
  if (impl_->manifest.picture_size(kind) == 0) return 0;
  const std::scoped_lock lock(impl_->turn);
  return sum_picture_bytes(impl_->db, kind);
}

Expected<std::vector<std::int64_t>> TileStore::keys() const {
  const std::scoped_lock lock(impl_->turn);
  return read_keys(impl_->db);
}

Expected<std::string> TileStore::digest() const {
  const std::scoped_lock lock(impl_->turn);
  TreeDigest digest;
  auto digested = for_each_tile(impl_->db, [&digest](const StoredTile& tile) { digest.add(tile); });
  if (digested) digested = add_pictures(impl_->db, impl_->manifest, digest);
  if (!digested) return tl::unexpected(digested.error());
  return digest.text();
}

Expected<codec::TileMesh> TileStore::read_mesh(const codec::TileId& id) const {
  auto tile = read(id);
  if (!tile) return tl::unexpected(tile.error());
  auto mesh = decode(*tile);
  if (!mesh) mesh.error().where = path() + ": " + mesh.error().where;
  return mesh;
}

Expected<codec::TileMesh> TileStore::decode(const StoredTile& tile) const { return impl_->decoder.decode(tile); }

Expected<std::optional<codec::PatchResidual>> TileStore::patch_residual(const codec::TileId& id) const {
  return impl_->decoder.patch_residual(id);
}

}  // namespace tintree::cache
