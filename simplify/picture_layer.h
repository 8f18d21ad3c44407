#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "cache/manifest.h"
#include "cache/ortho_source.h"
#include "codec/error.h"
#include "codec/stop_flag.h"
#include "codec/tile_id.h"
#include "simplify/node_values.h"
#include "simplify/reference_surface.h"

namespace tintree::simplify {

/// One kind of picture that tiles have, as picture_pyramid needs it. One object serves one thread.
class PictureLayer {
 public:
  virtual ~PictureLayer() = default;

  /// Whether a picture is filtered from those of its square's quadrants; else it is made by itself.
  virtual bool has_finer(const codec::TileId& id) const = 0;
  /// The values of a picture without finer ones from what they are made of: a pure function of the place, so that
  /// neighbours agree on the nodes that they share. kStopped soon after a stop was asked for.
  virtual Expected<NodeValues> make_leaf(const codec::TileId& id) = 0;
  /// The filter from a level to the next coarser one.
  virtual const HalvingFilter& filter() const = 0;
  /// Values as a payload; empty where there is nothing to store.
  virtual Expected<std::vector<std::byte>> encode(const NodeValues& values) const = 0;
  virtual Expected<NodeValues> decode(std::span<const std::byte> payload) const = 0;
};

/// Whether photos with pixels of this side show more than texels of that one do.
inline bool is_finer(double pixel_samples, double texel_samples) { return texel_samples > 1.25 * pixel_samples; }

/// The layer of textures, from photos, and that of normal maps, from the DEM. What is passed must outlive them.
std::unique_ptr<PictureLayer> make_texture_layer(const cache::Manifest& manifest, const cache::OrthoSource& photos);
std::unique_ptr<PictureLayer> make_normal_layer(const cache::Manifest& manifest, const ReferenceSurface& surface,
                                                const StopFlag* stop);

}  // namespace tintree::simplify
