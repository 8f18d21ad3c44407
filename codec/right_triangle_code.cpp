#include "codec/right_triangle_code.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

#include "codec/range_coder.h"
#include "codec/right_triangle_walk.h"
#include "codec/split_fans.h"
#include "codec/split_hierarchy.h"

namespace tintree::codec {
namespace {

using Index = std::int32_t;
using Spot = SplitPoint;

constexpr Index kNone = kNoPoint;
/// Whose grids of points take a few MiB, however few there are.
constexpr std::int64_t kMostCells = std::int64_t{1} << 22;

/// Puts a mesh.
class Putter final : public RightTriangleCoder {
 public:
  /// Of a mesh whose vertices lie inside the tile, which must outlive this.
  Putter(const TileMesh& mesh, std::int64_t cells)
      : mesh_(&mesh), cells_(cells), square_(right_triangle_square(cells)), vertices_(cells), splits_(cells) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Spot at = spot(i);
      vertices_.set(at.x, at.y, static_cast<Index>(i));
      force(at);
    }
    for (const Triangle& t : mesh.triangles) triangles_.push_back(canonical({spot(t[0]), spot(t[1]), spot(t[2])}));
    std::ranges::sort(triangles_);
  }

  bool bit(BitModel& model, bool truth) override { return coder_.bit(model, truth); }
  std::int64_t number(NumberModel& model, std::int64_t truth) override { return model.code(coder_, truth); }
  bool splits(const Spot& spot) const override { return splits_.get(spot.x, spot.y); }
  bool height(const Spot& spot, std::int64_t& z) const override {
    const Index vertex = vertices_.get(spot.x, spot.y);
    if (vertex == kNone) return false;
    z = mesh_->z_offset + mesh_->vertices[static_cast<std::size_t>(vertex)].z;
    return true;
  }
  bool has(const std::array<Spot, 3>& triangle) const override {
    return std::ranges::binary_search(triangles_, canonical(triangle));
  }
  bool broken() const override { return false; }
  std::vector<std::byte> finish() { return coder_.finish(); }

 private:
  using Keys = std::array<std::uint64_t, 3>;

  static std::uint64_t key(const Spot& p) {
    return static_cast<std::uint64_t>(p.y) << 32 | static_cast<std::uint64_t>(p.x);
  }
  /// The same for every rotation.
  static Keys canonical(const std::array<Spot, 3>& t) {
    Keys keys{key(t[0]), key(t[1]), key(t[2])};
    std::rotate(keys.begin(), std::ranges::min_element(keys), keys.end());
    return keys;
  }
  Spot spot(std::size_t vertex) const {
    const GridVertex& v = mesh_->vertices[vertex];
    return {std::int64_t{v.x} << mesh_->xy_shift, std::int64_t{v.y} << mesh_->xy_shift};
  }
  void force(const Spot& spot);

  const TileMesh* mesh_;
  std::int64_t cells_;
  std::int64_t square_;
  PointNumbers vertices_;
  SparseGrid<bool, false> splits_;
  std::vector<Keys> triangles_;
  RangeEncoder coder_;
};

/// The corners of squares are there without any split.
void Putter::force(const Spot& spot) {
  force_split(spot, [this](const Spot& p) {
    const bool inside = p.x >= 0 && p.y >= 0 && p.x <= cells_ && p.y <= cells_;
    if (!inside || (p.x % square_ == 0 && p.y % square_ == 0) || splits_.get(p.x, p.y)) return false;
    splits_.set(p.x, p.y, true);
    return true;
  });
}

/// Takes one.
class Taker final : public RightTriangleCoder {
 public:
  explicit Taker(std::span<const std::byte> bytes) : coder_(bytes) {}

  bool bit(BitModel& model, bool) override { return coder_.bit(model); }
  std::int64_t number(NumberModel& model, std::int64_t) override { return model.code(coder_, 0); }
  bool splits(const Spot&) const override { return false; }
  bool height(const Spot&, std::int64_t&) const override { return false; }
  bool has(const std::array<Spot, 3>&) const override { return false; }
  bool broken() const override { return coder_.exhausted(); }

 private:
  RangeDecoder coder_;
};

constexpr std::byte kWhole{0};
constexpr std::byte kWithHoles{1};

tl::unexpected<Error> damaged() { return fail(ErrorCode::kBadData, "the payload's triangles are damaged"); }

/// The triangles' corners, each once, on the coarsest grid.
Expected<TileMesh> make_mesh(const std::vector<RightTrianglePoint>& points,
                             const std::vector<std::array<Index, 3>>& triangles, std::int64_t cells) {
  TileMesh mesh;
  std::vector<Index> compact(points.size(), kNone);
  std::vector<const RightTrianglePoint*> used;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  auto all_bits = static_cast<std::uint64_t>(cells);
  mesh.triangles.reserve(triangles.size());
  for (const auto& t : triangles) {
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k) {
      Index& number = compact[static_cast<std::size_t>(t[k])];
      if (number == kNone) {
        const RightTrianglePoint& p = points[static_cast<std::size_t>(t[k])];
        number = static_cast<Index>(used.size());
        used.push_back(&p);
        lowest = std::min(lowest, p.z);
        highest = std::max(highest, p.z);
        all_bits |= static_cast<std::uint64_t>(p.spot.x | p.spot.y);
      }
      out[k] = static_cast<std::uint32_t>(number);
    }
    mesh.triangles.push_back(out);
  }
  if (used.empty() || highest - lowest > kMaxHeightAddress) return damaged();
  mesh.xy_shift = std::countr_zero(all_bits);
  mesh.z_offset = lowest;
  mesh.vertices.reserve(used.size());
  for (const RightTrianglePoint* p : used) {
    mesh.vertices.push_back({static_cast<std::int32_t>(p->spot.x >> mesh.xy_shift),
                             static_cast<std::int32_t>(p->spot.y >> mesh.xy_shift),
                             static_cast<std::int32_t>(p->z - lowest)});
  }
  return mesh;
}

}  // namespace

Expected<std::vector<std::byte>> encode_right_triangles(const TileMesh& mesh, std::int64_t cells,
                                                        const HeightGuess& guess) {
  const auto inside = [&](std::int32_t at) { return at >= 0 && at <= cells >> mesh.xy_shift; };
  if (cells > kMostCells) return fail(ErrorCode::kUsage, "the tile is too many samples wide for right triangles");
  if (mesh.xy_shift < 0 || mesh.xy_shift >= 32 ||
      !std::ranges::all_of(mesh.vertices, [&](const GridVertex& v) { return inside(v.x) && inside(v.y); })) {
    return fail(ErrorCode::kUsage, "its vertices do not lie on a tile's samples");
  }
  for (const bool holes : {false, true}) {
    Putter putter(mesh, cells);
    RightTriangleWalk walk(cells, guess, putter, holes);
    std::vector<std::array<Index, 3>> triangles;
    walk.run(triangles);
    // Whole: every triangle there is, and no point that is no vertex.
    if (triangles.size() != mesh.triangles.size() || (!holes && walk.points().size() != mesh.vertices.size())) continue;
    const auto spot = [&](Index i) { return walk.points()[static_cast<std::size_t>(i)].spot; };
    if (!std::ranges::all_of(triangles, [&](const auto& t) {
          return putter.has({spot(t[0]), spot(t[1]), spot(t[2])});
        })) {
      continue;
    }
    std::vector<std::byte> out{holes ? kWithHoles : kWhole};
    const std::vector<std::byte> coded = putter.finish();
    out.insert(out.end(), coded.begin(), coded.end());
    return out;
  }
  return fail(ErrorCode::kUsage, "its triangles are no right triangles of a tile");
}

Expected<TileMesh> decode_right_triangles(std::span<const std::byte> bytes, std::int64_t cells,
                                          const HeightGuess& guess) {
  if (bytes.empty() || bytes.front() > kWithHoles || cells > kMostCells) return damaged();
  Taker taker(bytes.subspan(1));
  RightTriangleWalk walk(cells, guess, taker, bytes.front() == kWithHoles);
  std::vector<std::array<Index, 3>> triangles;
  if (!walk.run(triangles)) return damaged();
  auto mesh = make_mesh(walk.points(), triangles, cells);
  if (mesh && bytes.front() == kWithHoles) split_fans(*mesh);
  return mesh;
}

}  // namespace tintree::codec
