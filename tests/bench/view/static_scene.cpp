#include "tests/bench/view/static_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

namespace tintree::bench {
namespace {

constexpr std::size_t kPoolBytes = std::size_t{2} << 30;
constexpr const char* kNoRoom = "the card has no room for the static buffer";

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

/// As much as the scene's own for what lies on leaves.
render::GpuBudgets budgets(const render::TerrainScene& scene) {
  const std::size_t fine_bytes = scene.pool().fine_textures().reserved_bytes();
  return {.mesh_bytes = kPoolBytes,
          .picture_bytes = kPoolBytes,
          .fine_texture_bytes = fine_bytes,
          .fine_texture_kinds = std::size_t{fine_bytes > 0}};
}

cache::TileRef ref_of(render::Trees trees, const render::DrawTile& d) {
  return {trees[d.tree]->nodes()[d.node].id, d.tree};
}

}  // namespace

StaticScene::StaticScene(const render::GlFunctions& gl, render::TerrainScene& scene, const render::LodCut& cut)
    : scene_(scene), pool_(gl, budgets(scene)), cut_(cut) {}

Expected<std::unique_ptr<StaticScene>> StaticScene::bake(const render::GlFunctions& gl, render::TerrainScene& scene,
                                                         const render::LodCut& cut) {
  std::unique_ptr<StaticScene> out(new StaticScene(gl, scene, cut));
  bool pictures = false;
  for (const render::DrawTile& d : cut.draws) {
    const auto tile = out->tile_of(ref_of(scene.trees(), d));
    if (!tile) return tl::unexpected(tile.error());
    if ((*tile)->vertices.empty())
      return fail(ErrorCode::kBadData, "only meshes can be baked; choose a tree of method tin");
    pictures = pictures || (*tile)->pictures.bytes() > 0;
  }
  const auto baked = pictures ? out->bake_tile_by_tile() : out->bake_as_one();
  if (!baked) return tl::unexpected(baked.error());
  return out;
}

Expected<std::shared_ptr<const cache::DrawableTile>> StaticScene::tile_of(const cache::TileRef& ref) const {
  auto tile = scene_.cache().get(ref);
  if (tile == nullptr) return fail(ErrorCode::kBadData, "a drawn tile has left the memory; give the cache more");
  return tile;
}

Expected<void> StaticScene::bake_tile_by_tile() {
  trees_.assign(scene_.trees().begin(), scene_.trees().end());
  for (const render::DrawTile& d : cut_.draws) {
    const cache::TileRef ref = ref_of(trees_, d);
    const auto tile = tile_of(ref);
    if (!tile) return tl::unexpected(tile.error());
    if (!pool_.upload(ref, **tile)) return fail(ErrorCode::kIo, kNoRoom);
    for (std::uint32_t p = 0; p < d.parts; ++p) {
      const cache::TileRef square{cut_.parts[d.first_part + p].texture, d.tree};
      const auto part = tile_of(square);
      if (!part) return tl::unexpected(part.error());
      if (!pool_.fine_textures().upload(square, (*part)->pictures.colors)) return fail(ErrorCode::kIo, kNoRoom);
    }
  }
  return {};
}

Expected<void> StaticScene::bake_as_one() {
  const Lattice lattice(box_of(scene_, cut_));
  cache::DrawableTile all;
  std::vector<std::uint32_t> skirts;  // After all surfaces, as in any tile.
  for (const render::DrawTile& d : cut_.draws) {
    const auto tile = tile_of(ref_of(scene_.trees(), d));
    if (!tile) return tl::unexpected(tile.error());
    const cache::DrawableTile& t = **tile;
    const auto base = static_cast<std::uint32_t>(all.vertices.size());
    for (const cache::DrawVertex& v : t.vertices) all.vertices.push_back(lattice.vertex(t.frame, v));
    for (std::size_t i = 0; i < t.index_count(); ++i) {
      (i < 3 * std::size_t{t.surface_triangles} ? all.wide_indices : skirts).push_back(base + t.index(i));
    }
    all.surface_triangles += t.surface_triangles;
  }
  all.wide_indices.insert(all.wide_indices.end(), skirts.begin(), skirts.end());
  all.frame = lattice.frame();
  if (!pool_.upload({}, all)) return fail(ErrorCode::kIo, kNoRoom);
  const cache::TileBounds& bounds = scene_.bounds();
  const cache::Box box = bounds.box(bounds.nodes().front());
  whole_ = cache::TileBounds(bounds.layout(), std::vector<cache::TileInfo>{{.id = {},
                                                                            .vertices = 0,
                                                                            .triangles = 0,
                                                                            .z_min_m = box.min[2],
                                                                            .z_max_m = box.max[2],
                                                                            .error_m = 0,
                                                                            .rms_m = 0,
                                                                            .border_error_m = 0}});
  trees_ = {&whole_};
  cut_.draws = {{0, 0, 0, cut_.nearest_m, cut_.farthest_m, false}};
  return {};
}

render::DrawStats StaticScene::draw(const render::Renderer& renderer, const render::OffscreenTarget& target,
                                    const render::Camera& camera) {
  return renderer.draw(target, camera, trees_, cut_, pool_, {});
}

}  // namespace tintree::bench
