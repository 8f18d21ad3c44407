#include "tests/bench/scene/scene_counts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "render/lod_cut.h"
#include "render/screen_error.h"

namespace tintree::bench {
namespace {

/// A place as the camera sees it.
struct Sight {
  double depth_m = 0;
  double u = 0;  ///< right / depth
  double v = 0;  ///< up / depth

  bool visible(const render::Camera& camera) const {
    return depth_m > 0 && std::abs(u) <= camera.tan_half_x() && std::abs(v) <= camera.tan_half_y();
  }
  /// g of render/screen_error.h, and no less than a viewer may take it for.
  double gain(const render::CameraAxes& axes) const {
    return std::max(render::ScreenError::kLeastGain, std::hypot(u * axes.forward.z, axes.up.z - v * axes.forward.z));
  }
};

Sight see(const render::Camera& camera, const render::CameraAxes& axes, const glm::dvec3& place) {
  const glm::dvec3 way = place - camera.eye;
  const double depth_m = glm::dot(way, axes.forward);
  return {depth_m, glm::dot(way, axes.right) / depth_m, glm::dot(way, axes.up) / depth_m};
}

}  // namespace

Expected<SceneCounter> SceneCounter::open(const cache::TileStore& store, const ErrorLadder& ladder) {
  SceneCounter out(store, ladder);
  for (int level = 0; level <= store.bounds().layout().leaf_level; ++level) {
    auto blocks = ground_blocks(store, level);
    if (!blocks) return tl::unexpected(blocks.error());
    out.levels_.push_back(std::move(*blocks));
  }
  for (const cache::TileNode& node : store.bounds().nodes()) {
    const auto tile = store.read(node.id);
    if (!tile) return tl::unexpected(tile.error());
    out.triangles_.push_back(tile->info.triangles);
  }
  return out;
}

Expected<SceneCounts> SceneCounter::count(const render::Camera& camera) const {
  const cache::TileBounds& bounds = store_.bounds();
  const codec::TreeLayout& layout = bounds.layout();
  const render::LodCut cut = render::lod_cut(bounds, camera, {}, [](std::uint32_t) { return true; });
  const render::CameraAxes axes = camera.axes();
  const render::ScreenError screen_error(camera);
  const double most_gain = std::max(render::ScreenError::kLeastGain, camera.vertical_gain());
  const GroundBlocks& ground = ladder_.ground();
  SceneCounts out;
  out.tiles = cut.draws.size();
  out.max_error_px = cut.max_error_px;
  for (const render::DrawTile& draw : cut.draws) {
    const codec::TileId& id = bounds.nodes()[draw.node].id;
    out.drawn += triangles_[draw.node];
    const auto allowed_m = [&](double error_m) { return std::max(error_m, layout.leaf_error_m); };
    // Metres a pixel, as the cut has it.
    const cache::TileNode& node = bounds.nodes()[draw.node];
    const double error_m = std::max(static_cast<double>(node.lod_error_m), layout.leaf_error_m);
    const double in_box_m = error_m / screen_error.bound_px(bounds.box(node), error_m).value_or(1);
    const codec::CellRect cells = layout.cells(id);
    for (std::int64_t row = cells.row0 / kBlockCells; row * kBlockCells < cells.row1; ++row) {
      for (std::int64_t column = cells.column0 / kBlockCells; column * kBlockCells < cells.column1; ++column) {
        const auto block = static_cast<std::size_t>(row * ground.columns + column);
        if (ground.cells[block] <= 0) continue;
        const Sight sight = see(camera, axes, ground.centres[block]);
        if (!sight.visible(camera)) continue;
        const double footprint_m = sight.depth_m / camera.focal_px();
        const double here_m = allowed_m(footprint_m / sight.gain(axes));
        const double fewest = ladder_.triangles(block, here_m);
        out.full += 2 * ground.cells[block];
        out.in_picture += levels_[static_cast<std::size_t>(id.level)].triangles[block];
        out.one_tile += ladder_.triangles(block, layout.bound_m(id.level));
        out.any_error += ladder_.triangles(block, allowed_m(in_box_m));
        out.fewest += fewest;
        out.fewest_level += ladder_.triangles(block, allowed_m(footprint_m / most_gain));
        if (here_m > ladder_.coarsest_m()) out.beyond_ladder += fewest;
      }
    }
  }
  if (out.fewest > 0) out.beyond_ladder /= out.fewest;
  return out;
}

std::vector<render::Camera> flight(const cache::TileBounds& bounds, int views) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kShallow = 20 * kDegree;
  constexpr double kSteep = 70 * kDegree;
  constexpr double kHighest = 2;
  constexpr double kMostGain = 1.2;  // of Camera::vertical_gain() for pictures of this shape
  const codec::TreeLayout& layout = bounds.layout();
  const render::Camera blank;
  const double corner = std::hypot(1.0, blank.tan_half_x(), blank.tan_half_y());
  const double lowest_m = kMostGain * corner * layout.leaf_error_m * blank.focal_px();
  const cache::Box box = bounds.box(bounds.nodes()[0]);
  const glm::dvec3 start(box.min[0], box.max[1], box.max[2]);
  const glm::dvec3 end(box.max[0], box.min[1], box.max[2]);
  const glm::dvec3 ahead = glm::normalize(end - start);
  std::vector<render::Camera> out;
  for (int i = 0; i < views; ++i) {
    const double share = (i + 0.5) / views;
    const double pitch = kShallow + (kSteep - kShallow) * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * 3 * share));
    const double height_m = lowest_m * std::pow(kHighest, 0.5 + 0.5 * std::cos(2 * std::numbers::pi * 2 * share));
    render::Camera camera = blank;
    camera.target = start + (end - start) * (0.2 + 0.6 * share);
    camera.eye = camera.target - ahead * (height_m / std::tan(pitch)) + glm::dvec3(0, 0, height_m);
    out.push_back(camera);
  }
  return out;
}

}  // namespace tintree::bench
