#include "apps/view/shortfalls.h"

#include <cstdio>
#include <utility>

#include <fmt/core.h>

namespace tintree::view {

std::string too_little_memory(const ViewOptions& options) {
  return fmt::format("{} MiB are too few for this view; parts of it are drawn coarser, more memory draws them finer",
                     options.gpu_bytes >> 20);
}

void Shortfalls::note(render::TerrainScene& scene, const ViewOptions& options) {
  for (Error& e : scene.take_errors()) failures_.push_back(std::move(e));
  lost_tiles_ = scene.cache().stats().lost;
  if (!scene.frame_stats().gpu_memory_full || std::exchange(told_of_memory_, true)) return;
  fmt::print(stderr, "tintree-view: --gpu-memory: {}\n", too_little_memory(options));
}

Expected<void> Shortfalls::outcome() const {
  if (failures_.empty()) return {};
  Error error = failures_.front();
  error.message += fmt::format("; {} could not be loaded, coarser ones stand in where they can",
                               lost_tiles_ == 1 ? "this tile" : fmt::format("{} tiles", lost_tiles_));
  return tl::unexpected(std::move(error));
}

}  // namespace tintree::view
