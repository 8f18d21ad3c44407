#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "cache/height_blocks.h"
#include "cache/manifest.h"
#include "cache/ortho_source.h"
#include "cache/packed_size.h"
#include "codec/error.h"
#include "codec/stop_flag.h"

namespace tintree::app {

/// What textures or normal maps are expected to come to.
struct PicturePlan {
  std::uint64_t pictures = 0;
  std::uint64_t bytes = 0;  ///< Payloads.
  cache::PackedSize size;   ///< What they come to in the file.
  double make_seconds = 0;  ///< Of all threads together.
};

/// Judges the textures by a few leaves', made in memory; nothing without photos.
Expected<PicturePlan> plan_textures(const cache::Manifest& manifest, const std::optional<cache::OrthoSource>& photos);
/// The same of the normal maps, if the manifest asks for them. Their bytes are known but for those that turn out to
/// hold unit vectors only.
Expected<PicturePlan> plan_normals(const cache::Manifest& manifest, const std::shared_ptr<cache::HeightBlocks>& blocks,
                                   const StopFlag* stop);

}  // namespace tintree::app
