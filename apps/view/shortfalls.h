#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/view/view_options.h"
#include "codec/error.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// What to say where the graphics memory is too small for a view.
std::string too_little_memory(const ViewOptions& options);

/// What kept the pictures of a run from being whole.
class Shortfalls {
 public:
  /// Remembers what kept tiles from being loaded; says on standard error, once, when the graphics memory is too small.
  void note(render::TerrainScene& scene, const ViewOptions& options);
  /// Fails, once tiles were lost, with what happened to the first and their number.
  Expected<void> outcome() const;

 private:
  std::vector<Error> failures_;
  std::uint64_t lost_tiles_ = 0;
  bool told_of_memory_ = false;
};

}  // namespace tintree::view
