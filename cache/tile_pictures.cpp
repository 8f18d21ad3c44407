#include "cache/tile_pictures.h"

#include <utility>

#include <fmt/format.h>

#include "codec/bc1_texture.h"
#include "codec/normal_codec.h"

namespace tintree::cache {
namespace {

Error named(Error error, const TileStore& store, PictureKind kind, const codec::TileId& id) {
  error.message = fmt::format("the {} of tile {} {}", picture_name(kind), id.text(), error.message);
  error.where = store.path();
  return error;
}

Expected<codec::PixelArray> load_colors(const TileStore& store, const codec::TileId& id, bool blocks) {
  const auto payload = store.read_picture(PictureKind::kTexture, id);
  if (!payload) return tl::unexpected(payload.error());
  if (!*payload) return codec::PixelArray{};
  const codec::TextureCodec* codec = codec::find_texture_codec(store.manifest().texture_codec);
  if (codec == nullptr) {
    return fail(ErrorCode::kBadData, "has textures coded as '" + store.manifest().texture_codec + "'; update tintree",
                store.path());
  }
  auto pixels = codec->pixels(**payload, store.manifest().picture_size(PictureKind::kTexture));
  if (!pixels) return tl::unexpected(named(pixels.error(), store, PictureKind::kTexture, id));
  return blocks || pixels->format != codec::PixelFormat::kBc1 ? std::move(*pixels) : codec::unpacked(*pixels);
}

Expected<codec::NormalPixels> load_normals(const TileStore& store, const codec::TileId& id) {
  const auto payload = store.read_picture(PictureKind::kNormal, id);
  if (!payload) return tl::unexpected(payload.error());
  if (!*payload) return codec::NormalPixels{};
  auto pixels = codec::normal_pixels(**payload, store.manifest().picture_size(PictureKind::kNormal));
  if (!pixels) return tl::unexpected(named(pixels.error(), store, PictureKind::kNormal, id));
  return pixels;
}

}  // namespace

Expected<TilePictures> load_pictures(const TileStore& store, const codec::TileId& id, bool blocks) {
  const bool in_leaf = id.level > store.manifest().layout.leaf_level;
  const codec::TileId holder = in_leaf ? id : store.manifest().layout.picture_tile(id);
  auto colors = load_colors(store, holder, blocks);
  if (!colors) return tl::unexpected(colors.error());
  if (in_leaf) return TilePictures{std::move(*colors), {}, {}};
  auto normals = load_normals(store, holder);
  if (!normals) return tl::unexpected(normals.error());
  return TilePictures{std::move(*colors), std::move(normals->directions), std::move(normals->lengths)};
}

}  // namespace tintree::cache
