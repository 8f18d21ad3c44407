#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "cache/picture_rows.h"
#include "cache/raster_source.h"
#include "codec/error.h"
#include "codec/grid_frame.h"

namespace tintree::cache {

/// The smallest squares with textures of their own are leaves halved so often.
inline constexpr int kMostTextureDepth = 5;

/// What a tree is: stored as JSON in its file (docs/format.md, Manifest).
struct Manifest {
  std::string method = "tin";
  std::string effort = "fast";  ///< How hard the maker of the tiles tried.
  std::string quantizer;        ///< Of method scalar, codec::quantizer_named(); empty with others.
  std::string criterion;        ///< Of method wavelet, codec::criterion_named(); empty with others.
  codec::TreeLayout layout;
  std::string crs_wkt;
  std::array<double, 6> geotransform{};
  bool geographic = false;
  double height_unit_m = 1;
  NodataPolicy nodata = NodataPolicy::kHole;
  std::vector<InputFile> inputs;  ///< In the order given: where they overlap, the later one counts.
  std::string samples_digest;     ///< XXH3-128 over the DEM's heights; equal heights give equal digests.
  int texture_size = 0;           ///< Texels along a tile's side less the one that it shares; 0: no textures.
  int texture_depth = 0;          ///< How often leaves are halved for finer textures, at most kMostTextureDepth.
  std::string texture_codec;      ///< codec::find_texture_codec(); empty without textures.
  std::vector<InputFile> orthos;  ///< What the textures were made from; the later one lies on top.
  bool normal_maps = false;       ///< Tiles have normal maps, of tile_cells + 1 texels a side.
  bool complete = false;          ///< Every tile is there and measured.
  std::string digest;             ///< XXH3-128 over all tiles in key order; set when complete.

  /// Texels along the side of a tile's picture of this kind; 0 when the tree has none.
  int picture_size(PictureKind kind) const {
    if (kind == PictureKind::kTexture) return texture_size > 0 ? texture_size + 1 : 0;
    return normal_maps ? layout.tile_cells + 1 : 0;
  }

  /// The squares that pictures of this kind lie on: those of the tiles, and of textures smaller ones in leaves.
  codec::TreeLayout picture_layout(PictureKind kind) const {
    return layout.deepened(kind == PictureKind::kTexture ? texture_depth : 0);
  }

  std::string to_json() const;
  /// Fails with kBadData on anything missing, of the wrong type or out of range.
  static Expected<Manifest> from_json(const std::string& text);

  /// The option or input in which a build of `other` would differ, with both values; empty when a build of `other` may
  /// resume this one. Equal samples make equal inputs, wherever the files lie and whatever their time; where the
  /// samples differ, number, names, size and time of the files help to say how.
  std::string difference(const Manifest& other) const;
};

}  // namespace tintree::cache
