#include "tests/bench/view/static_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace tintree::bench {
namespace {

constexpr std::size_t kPoolBytes = std::size_t{2} << 30;

/// A lattice over the whole of a box, as fine as a vertex can hold.
class Lattice {
 public:
  explicit Lattice(const cache::Box& box) {
    frame_.dx_m = (box.max[0] - box.min[0]) / cache::DrawVertex::kMostXy;
    frame_.dy_m = (box.max[1] - box.min[1]) / cache::DrawVertex::kMostXy;
    frame_.z_step_m = std::max(box.max[2] - box.min[2], 1.0) / (cache::DrawVertex::kMostZ - 2);
    frame_.z_offset = static_cast<std::int64_t>(std::floor(box.min[2] / frame_.z_step_m));
    frame_.origin_m = {box.min[0], box.max[1]};
  }

  cache::DrawVertex vertex(const codec::GridFrame& from, const cache::DrawVertex& v) const {
    const auto p = from.world({v.x(), v.y(), v.z()});
    const auto steps = [](double metres, double step, std::int32_t most) {
      return std::clamp(static_cast<std::int32_t>(std::lround(metres / step)), 0, most);
    };
    auto out = cache::DrawVertex::pack(steps(p[0] - frame_.origin_m[0], frame_.dx_m, cache::DrawVertex::kMostXy),
                                       steps(frame_.origin_m[1] - p[1], frame_.dy_m, cache::DrawVertex::kMostXy),
                                       steps(p[2] - static_cast<double>(frame_.z_offset) * frame_.z_step_m,
                                             frame_.z_step_m, cache::DrawVertex::kMostZ));
    out.high = static_cast<std::uint16_t>(out.high | v.skirt());
    out.normal_x = v.normal_x;
    out.normal_y = v.normal_y;
    return out;
  }

  const codec::GridFrame& frame() const { return frame_; }

 private:
  codec::GridFrame frame_;
};

cache::Box box_of(render::TerrainScene& scene, const render::LodCut& cut) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  cache::Box whole{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const render::DrawTile& d : cut.draws) {
    const cache::TileBounds& bounds = *scene.trees()[d.tree];
    const cache::Box box = bounds.box(bounds.nodes()[d.node]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      whole.min[axis] = std::min(whole.min[axis], box.min[axis]);
      whole.max[axis] = std::max(whole.max[axis], box.max[axis]);
    }
  }
  return whole;
}

}  // namespace

StaticScene::StaticScene(const render::GlFunctions& gl) : pool_(gl, {.mesh_bytes = kPoolBytes}) {}

Expected<std::unique_ptr<StaticScene>> StaticScene::bake(const render::GlFunctions& gl, render::TerrainScene& scene,
                                                         const render::LodCut& cut) {
  const Lattice lattice(box_of(scene, cut));
  cache::DrawableTile all;
  std::vector<std::uint32_t> skirts;  // After all surfaces, as in any tile.
  for (const render::DrawTile& d : cut.draws) {
    const auto tile = scene.cache().get({scene.trees()[d.tree]->nodes()[d.node].id, d.tree});
    if (tile == nullptr) return fail(ErrorCode::kBadData, "a drawn tile has left the memory; give the cache more");
    const auto base = static_cast<std::uint32_t>(all.vertices.size());
    for (const cache::DrawVertex& v : tile->vertices) all.vertices.push_back(lattice.vertex(tile->frame, v));
    for (std::size_t i = 0; i < tile->index_count(); ++i) {
      (i < 3 * std::size_t{tile->surface_triangles} ? all.wide_indices : skirts).push_back(base + tile->index(i));
    }
    all.surface_triangles += tile->surface_triangles;
  }
  all.wide_indices.insert(all.wide_indices.end(), skirts.begin(), skirts.end());
  all.frame = lattice.frame();
  std::unique_ptr<StaticScene> out(new StaticScene(gl));
  if (!out->pool_.upload({}, all)) return fail(ErrorCode::kIo, "the card has no room for the static buffer");
  const cache::Box box = scene.bounds().box(scene.bounds().nodes().front());
  out->bounds_ = cache::TileBounds(scene.bounds().layout(), std::vector<cache::TileInfo>{{.id = {},
                                                                                          .vertices = 0,
                                                                                          .triangles = 0,
                                                                                          .z_min_m = box.min[2],
                                                                                          .z_max_m = box.max[2],
                                                                                          .error_m = 0,
                                                                                          .rms_m = 0,
                                                                                          .border_error_m = 0}});
  out->cut_ = cut;
  out->cut_.draws = {{0, 0, 0, cut.nearest_m, cut.farthest_m, false}};
  return out;
}

render::DrawStats StaticScene::draw(const render::Renderer& renderer, const render::OffscreenTarget& target,
                                    const render::Camera& camera) {
  const std::array<const cache::TileBounds*, 1> trees{&bounds_};
  return renderer.draw(target, camera, trees, cut_, pool_, {});
}

}  // namespace tintree::bench
