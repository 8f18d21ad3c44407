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
#include "codec/spot_map.h"

namespace tintree::codec {
namespace {

using Index = std::int32_t;
using Spot = SplitPoint;

constexpr Index kNone = -1;

/// Puts a mesh.
class Putter final : public RightTriangleCoder {
 public:
  Putter(const TileMesh& mesh, std::int64_t cells) : cells_(cells), square_(right_triangle_square(cells)) {
    for (const GridVertex& v : mesh.vertices)
      spots_.push_back({std::int64_t{v.x} << mesh.xy_shift, std::int64_t{v.y} << mesh.xy_shift});
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      heights_.insert(spots_[i], mesh.z_offset + mesh.vertices[i].z);
      force(spots_[i]);
    }
    for (const Triangle& t : mesh.triangles)
      triangles_.push_back(canonical({spots_[t[0]], spots_[t[1]], spots_[t[2]]}));
    std::ranges::sort(triangles_);
  }

  bool bit(BitModel& model, bool truth) override { return coder_.bit(model, truth); }
  std::int64_t number(NumberModel& model, std::int64_t truth) override { return model.code(coder_, truth); }
  bool splits(const Spot& spot) const override { return splits_.find(spot) != nullptr; }
  bool height(const Spot& spot, std::int64_t& z) const override {
    const std::int64_t* at = heights_.find(spot);
    if (at != nullptr) z = *at;
    return at != nullptr;
  }
  bool has(const std::array<Spot, 3>& triangle) const override {
    return std::ranges::binary_search(triangles_, canonical(triangle));
  }
  bool broken() const override { return false; }
  std::vector<std::byte> finish() { return coder_.finish(); }

 private:
  using Keys = std::array<std::uint64_t, 3>;

  /// The same for every rotation.
  static Keys canonical(const std::array<Spot, 3>& t) {
    Keys keys{split_key(t[0]), split_key(t[1]), split_key(t[2])};
    std::ranges::rotate(keys, std::ranges::min_element(keys));
    return keys;
  }
  /// Notes a split and all that it needs.
  void force(const Spot& spot);

  std::int64_t cells_;
  std::int64_t square_;
  std::vector<Spot> spots_;
  SpotMap<std::int64_t> heights_;
  SpotMap<bool> splits_;
  std::vector<Keys> triangles_;
  RangeEncoder coder_;
};

void Putter::force(const Spot& spot) {
  const auto [x, y] = spot;
  if (x < 0 || y < 0 || x > cells_ || y > cells_ || (x % square_ == 0 && y % square_ == 0)) return;
  if (!splits_.insert(spot, true)) return;
  const std::int64_t unit = split_unit(spot);
  // The corners of squares are there without any split.
  const bool centre = (x & unit) != 0 && (y & unit) != 0;
  if (centre && 2 * unit >= square_) return;
  for (const Spot& parent : split_parents(spot)) force(parent);
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
  if (mesh.xy_shift < 0) return fail(ErrorCode::kUsage, "its vertices do not lie on samples");
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
  if (bytes.empty() || bytes.front() > kWithHoles) return damaged();
  Taker taker(bytes.subspan(1));
  RightTriangleWalk walk(cells, guess, taker, bytes.front() == kWithHoles);
  std::vector<std::array<Index, 3>> triangles;
  if (!walk.run(triangles)) return damaged();
  auto mesh = make_mesh(walk.points(), triangles, cells);
  if (mesh && bytes.front() == kWithHoles) split_fans(*mesh);
  return mesh;
}

}  // namespace tintree::codec
