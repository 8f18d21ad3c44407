#include "codec/right_triangle_code.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <limits>
#include <unordered_map>
#include <utility>

#include "codec/range_coder.h"
#include "codec/split_fans.h"
#include "codec/split_hierarchy.h"

namespace tintree::codec {
namespace {

using Index = std::int32_t;
constexpr Index kNone = -1;
constexpr std::int64_t kSquares = 16;

using Spot = SplitPoint;

/// A point at which triangles are split, or a corner of the squares.
struct Point {
  Spot spot;
  std::int64_t unit = 0;  ///< Half the side of the square whose middle, or whose side's middle, it is.
  bool exists = true;     ///< Whether it is a vertex of the mesh.
  std::int64_t z = 0;     ///< Height in steps from height 0.
  std::int64_t guess = 0;
  std::int64_t bend = 0;  ///< How far off the middle of its longest side, in quarter steps; of corners 0.
};

/// What is known of a point before it is coded.
struct Outlook {
  std::int64_t guess = 0;
  std::int64_t flat = 0;       ///< The height between the ends of the longest side, in quarter steps.
  std::int64_t expected = 0;   ///< What the guess adds to that.
  std::int64_t roughness = 0;  ///< How much the points bent that this one depends on.
};

std::size_t size_class(std::int64_t quarters, std::size_t classes) {
  const auto size = static_cast<std::uint64_t>(std::abs(quarters)) / 4;
  return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(size)), classes - 1);
}

/// What differs between the two ways: each takes the truth, or ignores it, and returns it.
class Coder {
 public:
  virtual ~Coder() = default;
  virtual bool bit(BitModel& model, bool truth) = 0;
  virtual std::int64_t number(NumberModel& model, std::int64_t truth) = 0;
  /// Of the mesh that is put: is there a split, a vertex (with its height), a triangle?
  virtual bool splits(const Spot& spot) const = 0;
  virtual bool height(const Spot& spot, std::int64_t& z) const = 0;
  virtual bool has(const std::array<Spot, 3>& triangle) const = 0;
  virtual bool broken() const = 0;
};

/// The walk over the triangles, the same for both ways.
class Walk {
 public:
  Walk(std::int64_t cells, const HeightGuess& guess, Coder& coder, bool holes)
      : cells_(cells),
        square_(std::max<std::int64_t>(1, cells / kSquares)),
        guess_(&guess),
        coder_(&coder),
        holes_(holes) {}

  /// All triangles, as indices of points(); false when the coder broke.
  bool run(std::vector<std::array<Index, 3>>& triangles);
  const std::vector<Point>& points() const { return points_; }

 private:
  static constexpr std::size_t kExpected = 5;
  static constexpr std::size_t kRoughness = 4;

  static std::uint64_t key(const Spot& s) {
    return static_cast<std::uint64_t>(s.y) << 32 | static_cast<std::uint64_t>(s.x);
  }
  bool inside(const Spot& s) const { return s.x >= 0 && s.y >= 0 && s.x <= cells_ && s.y <= cells_; }
  Index find(const Spot& s) const {
    const auto at = by_spot_.find(key(s));
    return at == by_spot_.end() ? kNone : at->second;
  }
  Index add(const Spot& spot, std::int64_t unit, const Outlook& outlook);
  void add_corners();
  Outlook look(const Spot& spot, Index a, Index b, std::int64_t roughness) const;
  Index try_split(const Spot& spot, std::int64_t unit, const Spot& a, const Spot& b, std::int64_t roughness, bool side);
  void split_sides(const std::vector<Index>& middles, std::vector<Index>& out);
  void split_middles(const std::vector<Index>& sides, std::vector<Index>& out);
  void descend(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);
  void emit_half_cell(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);
  void emit(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out);

  std::int64_t cells_;
  std::int64_t square_;
  const HeightGuess* guess_;
  Coder* coder_;
  bool holes_;
  std::vector<Point> points_;
  std::unordered_map<std::uint64_t, Index> by_spot_;
  bool last_there_ = true;

  std::array<std::array<std::array<BitModel, kRoughness>, kExpected>, 2> split_models_;
  std::array<std::array<NumberModel, 3>, 3> height_models_;
  NumberModel corner_model_;
  std::array<BitModel, 3> exists_models_;
  std::array<BitModel, 2> triangle_models_;
  std::array<BitModel, 2> flip_models_;
};

bool Walk::run(std::vector<std::array<Index, 3>>& triangles) {
  add_corners();
  std::vector<Index> sides;
  std::vector<Index> middles;
  const std::int64_t half = square_ / 2;
  for (std::int64_t y = 0; half > 0 && y < cells_; y += square_) {
    for (std::int64_t x = 0; x < cells_; x += square_) {
      const bool even = ((x / square_ + y / square_) & 1) == 0;
      const Spot a{even ? x : x + square_, y};
      const Spot b{even ? x + square_ : x, y + square_};
      const Index middle = try_split({x + half, y + half}, half, a, b, 0, false);
      if (middle != kNone) middles.push_back(middle);
    }
  }
  while (!middles.empty() && !coder_->broken()) {
    sides.clear();
    split_sides(middles, sides);
    middles.clear();
    split_middles(sides, middles);
  }
  for (std::int64_t y = 0; y < cells_; y += square_) {
    for (std::int64_t x = 0; x < cells_ && !coder_->broken(); x += square_) {
      const Spot nw{x, y};
      const Spot ne{x + square_, y};
      const Spot sw{x, y + square_};
      const Spot se{x + square_, y + square_};
      const bool even = ((x / square_ + y / square_) & 1) == 0;
      descend(even ? nw : sw, even ? se : ne, even ? ne : nw, triangles);
      descend(even ? se : ne, even ? nw : sw, even ? sw : se, triangles);
    }
  }
  return !coder_->broken();
}

/// Codes whether it is a vertex, and its height.
Index Walk::add(const Spot& spot, std::int64_t unit, const Outlook& outlook) {
  Point point{spot, unit, true, 0, outlook.guess, 0};
  std::int64_t z = 0;
  const bool there = coder_->height(spot, z);
  if (holes_) {
    const Index west = unit == 0 ? find({spot.x - square_, spot.y}) : kNone;
    const std::size_t context = unit > 0 ? 2 : west == kNone || points_[static_cast<std::size_t>(west)].exists ? 0 : 1;
    point.exists = coder_->bit(exists_models_[context], there);
  }
  if (point.exists) {
    const std::int64_t likely = (outlook.flat + outlook.expected + 2) >> 2;
    NumberModel& model =
        unit == 0 ? corner_model_ : height_models_[size_class(outlook.expected, 3)][size_class(outlook.roughness, 3)];
    // Unsigned: what damaged bytes make overflow only wraps round, and is refused at the end.
    point.z = static_cast<std::int64_t>(static_cast<std::uint64_t>(likely) +
                                        static_cast<std::uint64_t>(coder_->number(model, z - likely)));
    point.z = std::clamp(point.z, -kMaxHeightOffset, kMaxHeightOffset);
    if (unit > 0) point.bend = 4 * point.z - outlook.flat;
  }
  const auto index = static_cast<Index>(points_.size());
  points_.push_back(point);
  by_spot_[key(spot)] = index;
  return index;
}

/// Each from its western or northern neighbour and what the guess rises from there.
void Walk::add_corners() {
  for (std::int64_t y = 0; y <= cells_; y += square_) {
    for (std::int64_t x = 0; x <= cells_; x += square_) {
      if (coder_->broken()) return;
      Index from = x > 0 ? find({x - square_, y}) : find({x, y - square_});
      if (from != kNone && !points_[static_cast<std::size_t>(from)].exists) from = kNone;
      Outlook outlook{(*guess_)(x, y), 0, 0, 0};
      outlook.flat = outlook.guess;
      if (from != kNone) {
        const Point& point = points_[static_cast<std::size_t>(from)];
        outlook.flat += 4 * point.z - point.guess;
      }
      add({x, y}, 0, outlook);
    }
  }
}

Outlook Walk::look(const Spot& spot, Index a, Index b, std::int64_t roughness) const {
  Outlook out;
  out.guess = (*guess_)(spot.x, spot.y);
  out.roughness = roughness;
  const Point& p = points_[static_cast<std::size_t>(a)];
  const Point& q = points_[static_cast<std::size_t>(b)];
  if (p.exists && q.exists) {
    out.flat = 2 * (p.z + q.z);
    out.expected = out.guess - ((p.guess + q.guess) >> 1);
  } else if (p.exists || q.exists) {
    const Point& r = p.exists ? p : q;
    out.flat = 4 * r.z;
    out.expected = out.guess - r.guess;
  } else {
    out.flat = out.guess;
  }
  return out;
}

Index Walk::try_split(const Spot& spot, std::int64_t unit, const Spot& a, const Spot& b, std::int64_t roughness,
                      bool side) {
  if (coder_->broken()) return kNone;
  const Index p = find(a);
  const Index q = find(b);
  if (p == kNone || q == kNone) return kNone;
  const Outlook outlook = look(spot, p, q, roughness);
  BitModel& model =
      split_models_[side ? 1 : 0][size_class(outlook.expected, kExpected)][size_class(roughness, kRoughness)];
  return coder_->bit(model, coder_->splits(spot)) ? add(spot, unit, outlook) : kNone;
}

/// The middles of the sides of squares whose own middles are there on both sides of it.
void Walk::split_sides(const std::vector<Index>& middles, std::vector<Index>& out) {
  for (const Index index : middles) {
    const Point point = points_[static_cast<std::size_t>(index)];
    const auto [x, y] = point.spot;
    const std::int64_t u = point.unit;
    for (const auto& [dx, dy] :
         {std::pair{-u, std::int64_t{0}}, {u, std::int64_t{0}}, {std::int64_t{0}, -u}, {std::int64_t{0}, u}}) {
      const Spot spot{x + dx, y + dy};
      const Spot across{x + 2 * dx, y + 2 * dy};
      std::int64_t roughness = std::abs(point.bend);
      if (inside(across)) {
        const Index other = find(across);
        if (other == kNone || other > index) continue;  // its turn comes with the later of the two
        roughness = std::max(roughness, std::abs(points_[static_cast<std::size_t>(other)].bend));
      }
      const Spot a{spot.x + dy, spot.y + dx};
      const Spot b{spot.x - dy, spot.y - dx};
      const Index made = try_split(spot, u, a, b, roughness, true);
      if (made != kNone) out.push_back(made);
    }
  }
}

/// The middles of squares with two opposite corners that are middles of larger squares' sides.
void Walk::split_middles(const std::vector<Index>& sides, std::vector<Index>& out) {
  for (const Index index : sides) {
    const Point point = points_[static_cast<std::size_t>(index)];
    const std::int64_t side = point.unit;
    const std::int64_t v = side / 2;
    if (v == 0) continue;
    for (const auto& [dx, dy] : {std::pair{-v, -v}, {v, -v}, {-v, v}, {v, v}}) {
      const Spot spot{point.spot.x + dx, point.spot.y + dy};
      const Spot opposite{spot.x + dx, spot.y + dy};
      if (!inside(opposite)) continue;
      const Index other = find(opposite);
      if (other == kNone || other > index) continue;
      const std::int64_t roughness =
          std::max(std::abs(point.bend), std::abs(points_[static_cast<std::size_t>(other)].bend));
      const Index made = try_split(spot, v, {spot.x + dx, spot.y - dy}, {spot.x - dx, spot.y + dy}, roughness, false);
      if (made != kNone) out.push_back(made);
    }
  }
}

/// Triangle with longest side a-b and apex c, counter-clockwise from above.
void Walk::descend(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out) {
  if (std::abs(a.x - b.x) == 1 && std::abs(a.y - b.y) == 1) return emit_half_cell(a, b, c, out);
  const Spot middle{(a.x + b.x) / 2, (a.y + b.y) / 2};
  if (find(middle) == kNone) return emit(a, b, c, out);
  descend(c, a, middle, out);
  descend(b, c, middle, out);
}

/// Half a cell of the DEM. Where the other half is a triangle too, the two get the surface's own diagonal, but for two
/// corners of the tile where a bit may say otherwise.
void Walk::emit_half_cell(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out) {
  const Spot d{a.x + b.x - c.x, a.y + b.y - c.y};
  const bool along = (a.x - b.x) == (a.y - b.y);
  if (along || find(c) == kNone || find(d) == kNone) return emit(a, b, c, out);
  const Spot cell{std::min(a.x, b.x), std::min(a.y, b.y)};
  const std::int64_t last = cells_ - 1;
  if ((cell.x == 0 && cell.y == last) || (cell.x == last && cell.y == 0)) {
    if (coder_->bit(flip_models_[cell.x == 0 ? 0 : 1], coder_->has({a, b, c}))) return emit(a, b, c, out);
  }
  emit(c, a, d, out);
}

void Walk::emit(const Spot& a, const Spot& b, const Spot& c, std::vector<std::array<Index, 3>>& out) {
  const std::array<Index, 3> corners{find(a), find(b), find(c)};
  for (const Index corner : corners) {
    if (corner == kNone || !points_[static_cast<std::size_t>(corner)].exists) return;
  }
  if (holes_) {
    last_there_ = coder_->bit(triangle_models_[last_there_ ? 1 : 0], coder_->has({a, b, c}));
    if (!last_there_) return;
  }
  out.push_back(corners);
}

/// Puts a mesh.
class Putter final : public Coder {
 public:
  Putter(const TileMesh& mesh, std::int64_t cells)
      : cells_(cells), square_(std::max<std::int64_t>(1, cells / kSquares)) {
    for (const GridVertex& v : mesh.vertices)
      spots_.push_back({std::int64_t{v.x} << mesh.xy_shift, std::int64_t{v.y} << mesh.xy_shift});
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      heights_[key(spots_[i])] = mesh.z_offset + mesh.vertices[i].z;
      force(spots_[i]);
    }
    for (const Triangle& t : mesh.triangles)
      triangles_.push_back(canonical({spots_[t[0]], spots_[t[1]], spots_[t[2]]}));
    std::ranges::sort(triangles_);
  }

  bool bit(BitModel& model, bool truth) override { return coder_.bit(model, truth); }
  std::int64_t number(NumberModel& model, std::int64_t truth) override { return model.code(coder_, truth); }
  bool splits(const Spot& spot) const override { return splits_.contains(key(spot)); }
  bool height(const Spot& spot, std::int64_t& z) const override {
    const auto at = heights_.find(key(spot));
    if (at == heights_.end()) return false;
    z = at->second;
    return true;
  }
  bool has(const std::array<Spot, 3>& triangle) const override {
    return std::ranges::binary_search(triangles_, canonical(triangle));
  }
  bool broken() const override { return false; }
  std::vector<std::byte> finish() { return coder_.finish(); }

 private:
  using Keys = std::array<std::uint64_t, 3>;

  static std::uint64_t key(const Spot& s) {
    return static_cast<std::uint64_t>(s.y) << 32 | static_cast<std::uint64_t>(s.x);
  }
  /// The same for every rotation.
  static Keys canonical(const std::array<Spot, 3>& t) {
    Keys keys{key(t[0]), key(t[1]), key(t[2])};
    std::ranges::rotate(keys, std::ranges::min_element(keys));
    return keys;
  }
  /// Notes a split and all that it needs.
  void force(const Spot& spot);

  std::int64_t cells_;
  std::int64_t square_;
  std::vector<Spot> spots_;
  std::unordered_map<std::uint64_t, std::int64_t> heights_;
  std::unordered_map<std::uint64_t, bool> splits_;
  std::vector<Keys> triangles_;
  RangeEncoder coder_;
};

void Putter::force(const Spot& spot) {
  const auto [x, y] = spot;
  if (x < 0 || y < 0 || x > cells_ || y > cells_ || (x % square_ == 0 && y % square_ == 0)) return;
  if (!splits_.emplace(key(spot), true).second) return;
  const std::int64_t unit = split_unit(spot);
  // The corners of squares are there without any split.
  const bool centre = (x & unit) != 0 && (y & unit) != 0;
  if (centre && 2 * unit >= square_) return;
  for (const Spot& parent : split_parents(spot)) force(parent);
}

/// Takes one.
class Taker final : public Coder {
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
Expected<TileMesh> make_mesh(const std::vector<Point>& points, const std::vector<std::array<Index, 3>>& triangles,
                             std::int64_t cells) {
  TileMesh mesh;
  std::vector<Index> compact(points.size(), kNone);
  std::vector<const Point*> used;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  std::int64_t highest = std::numeric_limits<std::int64_t>::min();
  auto all_bits = static_cast<std::uint64_t>(cells);
  mesh.triangles.reserve(triangles.size());
  for (const auto& t : triangles) {
    Triangle out{};
    for (std::size_t k = 0; k < 3; ++k) {
      Index& number = compact[static_cast<std::size_t>(t[k])];
      if (number == kNone) {
        const Point& p = points[static_cast<std::size_t>(t[k])];
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
  for (const Point* p : used) {
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
    Walk walk(cells, guess, putter, holes);
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
  Walk walk(cells, guess, taker, bytes.front() == kWithHoles);
  std::vector<std::array<Index, 3>> triangles;
  if (!walk.run(triangles)) return damaged();
  auto mesh = make_mesh(walk.points(), triangles, cells);
  if (mesh && bytes.front() == kWithHoles) split_fans(*mesh);
  return mesh;
}

}  // namespace tintree::codec
