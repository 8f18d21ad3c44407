#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "codec/range_coder.h"
#include "codec/tin_front.h"
#include "codec/tin_guess.h"
#include "codec/tin_models.h"
#include "codec/tin_source.h"

namespace tintree::codec {

/// What both ways know of a mesh beforehand.
struct TinFrame {
  std::int32_t width = 0;   ///< Greatest x,
  std::int32_t height = 0;  ///< and y: 1 to kMostTinPlace.
  bool rectangle = false;   ///< The first outline is that of the rectangle.
  bool more = false;        ///< There are other borders.
};

/// Codes a mesh triangle by triangle from an outline inwards: at an edge whose other side is not known yet, whether
/// there is a triangle and whether its third vertex is known, and if not, where that lies and how high, each as what
/// is left over a guess from the geometry so far (the operations of Gumhold, Strasser 1998, the order and the contexts
/// by geometry as Lewiner et al. 2006, "GEncode"). One program for both ways: `Coder` is RangeEncoder or RangeDecoder.
template <typename Coder>
class TinWalk {
 public:
  /// `source` is the mesh to write, null when reading; vertices and triangles come to `mesh` in the order of the walk.
  TinWalk(Coder& coder, const TinFrame& frame, const TinSource* source, TileMesh& mesh)
      : coder_(coder), frame_(frame), source_(source), mesh_(mesh), front_(mesh.vertices) {
    if (source_ != nullptr) number_.assign(source_->mesh().vertices.size(), kUnknown);
  }

  /// False when what is read cannot be, or for a mesh that is not planar.
  bool run() {
    if (frame_.rectangle && !(code_rectangle() && grow())) return false;
    while (frame_.more && code_component()) {
      if (!grow()) return false;
    }
    return sound_;
  }

 private:
  using Index = TinFront::Index;
  using Number = TinModels::Number;
  static constexpr std::uint32_t kUnknown = UINT32_MAX;
  static constexpr std::int64_t kMostNumber = 1 << 24;

  bool writing() const { return source_ != nullptr; }
  bool fail() {
    sound_ = false;
    return false;
  }

  /// Adds a vertex, which is `from` of the source.
  bool add_vertex(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t from) {
    if (x < 0 || y < 0 || x > frame_.width || y > frame_.height || z < 0 || z > kMaxHeightAddress) return fail();
    if (mesh_.vertices.size() >= kMaxTileVertices || exhausted()) return fail();
    if (writing()) number_[from] = static_cast<std::uint32_t>(mesh_.vertices.size());
    mesh_.vertices.push_back(
        {static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)});
    last_z_ = z;
    return true;
  }
  bool exhausted() const {
    if constexpr (requires { coder_.exhausted(); }) return coder_.exhausted();
    return false;
  }
  const GridVertex& wanted(std::uint32_t from) const {
    static constexpr GridVertex kNothing;
    return writing() ? source_->mesh().vertices[from] : kNothing;
  }
  std::int64_t code_height(Number& model, std::int64_t guess, std::uint32_t from) {
    return guess + limited(model.code(coder_, wanted(from).z - guess));
  }
  static std::int64_t limited(std::int64_t number) { return std::clamp(number, -kMostNumber, kMostNumber); }

  /// Number and even low digits.
  std::int64_t code_offset(Number& model, std::int64_t value, int even_digits) {
    const std::int64_t half = (std::int64_t{1} << even_digits) >> 1;
    std::int64_t read = limited(model.code(coder_, (value + half) >> even_digits));
    for (int i = even_digits - 1; i >= 0; --i) read = read * 2 + (coder_.bit(((value + half) >> i & 1) != 0) ? 1 : 0);
    return read - half;
  }

  /// The outline of the rectangle, from the north-west corner southward.
  bool code_rectangle() {
    const std::vector<std::int32_t> sides = writing() ? source_->rectangle() : std::vector<std::int32_t>();
    const auto half = [&](std::size_t i) { return writing() ? sides[i] : TinSource::kNone; };
    const auto from = [&](std::size_t i) { return writing() ? source_->origin(sides[i % sides.size()]) : 0; };
    if (!add_vertex(0, 0, code_height(models_.first_height, 0, from(0)), from(0))) return false;
    const Index start = front_.insert(0, half(0), TinFront::kNone, TinFront::kNone);
    Index last = start;
    std::size_t i = 0;
    for (int side = 0; side < 4; ++side) {
      const std::int32_t length = side % 2 == 0 ? frame_.height : frame_.width;
      for (std::int64_t at = 0; at < length;) {
        ++i;
        const GridVertex& next = wanted(from(i));
        const std::array<std::int64_t, 4> along{next.y, next.x, frame_.height - next.y, frame_.width - next.x};
        at += 1 + limited(models_.gap.code(coder_, along[static_cast<std::size_t>(side)] - at - 1));
        if (at > length || at < 1) return fail();
        if (side == 3 && at == length) break;
        const std::array<std::array<std::int64_t, 2>, 4> places{
            {{0, at}, {at, frame_.height}, {frame_.width, frame_.height - at}, {frame_.width - at, 0}}};
        const auto [x, y] = places[static_cast<std::size_t>(side)];
        if (!add_vertex(x, y, code_height(models_.height, last_z_, from(i)), from(i))) return false;
        last = front_.insert(static_cast<std::uint32_t>(mesh_.vertices.size() - 1), half(i), last, TinFront::kNone);
      }
    }
    front_.link(last, start, front_[last].half);
    return !writing() || i == sides.size() || fail();
  }

  /// Another piece of the mesh, if there is one: its first edge, on its border.
  bool code_component() {
    std::int32_t half = TinSource::kNone;
    while (writing() && next_half_ < source_->half_edges() && half == TinSource::kNone) {
      const bool border = source_->twin(next_half_) == TinSource::kNone;
      if (border && number_[source_->origin(next_half_)] == kUnknown) half = next_half_;
      ++next_half_;
    }
    if (!coder_.bit(models_.more, half != TinSource::kNone)) return false;
    const std::uint32_t a = writing() ? source_->origin(half) : 0;
    const std::uint32_t b = writing() ? source_->origin(TinSource::following(half)) : 0;
    const auto number = static_cast<std::uint32_t>(mesh_.vertices.size());
    const std::int64_t x = code_even(wanted(a).x, frame_.width);
    const std::int64_t y = code_even(wanted(a).y, frame_.height);
    if (!add_vertex(x, y, code_height(models_.first_height, last_z_, a), a)) return false;
    const std::int64_t dx = limited(models_.start[0].code(coder_, wanted(b).x - x));
    const std::int64_t dy = limited(models_.start[1].code(coder_, wanted(b).y - y));
    if (!add_vertex(x + dx, y + dy, code_height(models_.height, last_z_, b), b)) return false;
    const Index first = front_.insert(number, half, TinFront::kNone, TinFront::kNone);
    const Index second = front_.insert(number + 1, TinSource::kNone, first, first);
    front_.link(second, first, TinSource::kNone);
    front_.close(second);
    return true;
  }
  std::int64_t code_even(std::int64_t value, std::int32_t most) {
    std::int64_t read = 0;
    for (int i = static_cast<int>(std::bit_width(static_cast<std::uint32_t>(most))) - 1; i >= 0; --i)
      read = read * 2 + (coder_.bit((value >> i & 1) != 0) ? 1 : 0);
    return read;
  }

  /// All triangles that hang together with the front.
  bool grow() {
    for (Index gate = front_.gate(); gate != TinFront::kNone; gate = front_.gate()) {
      if (!step(gate) || mesh_.triangles.size() > kMaxTileTriangles) return fail();
    }
    return true;
  }

  bool step(Index gate) {
    if (frame_.more && code_border(gate)) return true;
    const Index end = front_[gate].next;
    const Index before = front_[gate].previous;
    const Index after = front_[end].next;
    const std::int32_t half = front_[gate].half;
    // The third vertex, as a number of the walk.
    const std::uint32_t third = writing() ? number_[apex(half)] : kUnknown;
    if (before == after) {
      const bool closed =
          front_[before].open && front_[end].open && coder_.bit(models_.last, third == front_[before].vertex);
      if (closed) {
        add_triangle(gate, end, front_[before].vertex);
        for (const Index i : {gate, end, before}) front_.remove(i);
        return true;
      }
    } else {
      const auto turn = static_cast<std::size_t>(front_.turn(gate));
      const auto end_turn = static_cast<std::size_t>(front_.turn(end));
      if (front_[before].open && turn < 6 &&
          coder_.bit(models_.back[turn][group(end_turn)], third == front_[before].vertex)) {
        add_triangle(gate, end, front_[before].vertex);
        front_.remove(gate);
        front_.link(before, end, beyond(half, 1));
        return true;
      }
      if (front_[end].open && end_turn < 6 &&
          coder_.bit(models_.ahead[end_turn][group(turn)], third == front_[after].vertex)) {
        add_triangle(gate, end, front_[after].vertex);
        front_.remove(end);
        front_.link(gate, after, beyond(half, 2));
        return true;
      }
      // Of two nodes that is what turn() says.
      if (before != end && !coder_.bit(models_.fresh[turn > 3 ? 1 : 0], third == kUnknown)) return split(gate, third);
    }
    return third == kUnknown && code_vertex(gate);
  }

  /// Vertices that have a wide, a middling and a narrow angle.
  static std::size_t group(std::size_t turn) { return turn <= 1 ? 0 : turn <= 3 ? 1 : 2; }

  std::uint32_t apex(std::int32_t half) const {
    return source_->origin(TinSource::following(TinSource::following(half)));
  }
  /// The half-edge across an edge of the triangle of `half`, so many after that.
  std::int32_t beyond(std::int32_t half, int steps) const {
    if (!writing()) return TinSource::kNone;
    for (int i = 0; i < steps; ++i) half = TinSource::following(half);
    return source_->twin(half);
  }
  void add_triangle(Index gate, Index end, std::uint32_t third) {
    mesh_.triangles.push_back({front_[gate].vertex, front_[end].vertex, third});
  }

  /// Whether there is nothing beyond the gate.
  bool code_border(Index gate) {
    const Index end = front_[gate].next;
    const GridVertex& a = front_.point(gate);
    const GridVertex& b = front_.point(end);
    const bool at_side = (a.x == b.x && ((a.x == 0 && b.y < a.y) || (a.x == frame_.width && b.y > a.y))) ||
                         (a.y == b.y && ((a.y == 0 && b.x > a.x) || (a.y == frame_.height && b.x < a.x)));
    const std::size_t closed = (front_[front_[gate].previous].open ? 0U : 1U) + (front_[end].open ? 0U : 2U);
    if (!at_side && !coder_.bit(models_.border[closed][group(static_cast<std::size_t>(front_.turn(gate)))],
                                front_[gate].half == TinSource::kNone)) {
      return false;
    }
    front_.close(gate);
    return true;
  }

  bool code_vertex(Index gate) {
    const Index end = front_[gate].next;
    const std::int32_t half = front_[gate].half;
    const std::uint32_t from = writing() ? apex(half) : 0;
    const PlaceGuess guess(front_, gate, doubled_area_, frame_.width, frame_.height);
    auto offset = guess.offset_of(wanted(from));
    offset.across = code_offset(models_.across, offset.across, guess.even_digits());
    offset.along = code_offset(models_.along, offset.along, guess.even_digits());
    const auto [x, y] = guess.place_at(offset);
    if (x < 0 || y < 0 || x > frame_.width || y > frame_.height) return fail();
    const GridVertex at{static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), 0};
    const std::int64_t area = doubled_area(front_.point(gate), front_.point(end), at);
    doubled_area_ = area <= 0 ? doubled_area_ : doubled_area_ == 0 ? area : (6 * doubled_area_ + area) / 7;
    const auto number = static_cast<std::uint32_t>(mesh_.vertices.size());
    if (!add_vertex(x, y, code_height(models_.height, guess_height(front_, gate, at), from), from)) return false;
    add_triangle(gate, end, number);
    const Index node = front_.insert(number, beyond(half, 1), gate, end);
    front_.link(gate, node, beyond(half, 2));
    return true;
  }

  /// A triangle with a vertex elsewhere on the loop, which parts it in two.
  bool split(Index gate, std::uint32_t third) {
    const Index end = front_[gate].next;
    // On both ways round at once, so that all splits together take n log n steps.
    Index ahead = front_[end].next;
    Index back = front_[gate].previous;
    std::int64_t steps = 0;
    const auto advance = [&] {
      if (ahead == back || front_[ahead].next == back) return false;
      ahead = front_[ahead].next;
      back = front_[back].previous;
      return true;
    };
    for (; writing(); ++steps) {
      if (!advance()) return fail();
      if (front_[ahead].vertex == third || front_[back].vertex == third) break;
    }
    const std::int64_t wish = writing() && front_[ahead].vertex != third ? -1 - steps : steps;
    const std::int64_t coded = models_.split.code(coder_, wish);
    for (std::int64_t left = writing() ? 0 : coded < 0 ? -coded : coded + 1; left > 0; --left) {
      if (!advance()) return fail();
    }
    const Index node = coded < 0 ? back : ahead;
    const std::int32_t half = front_[gate].half;
    add_triangle(gate, end, front_[node].vertex);
    front_.insert(front_[node].vertex, beyond(half, 1), front_[node].previous, end);
    front_.link(gate, node, beyond(half, 2));
    return true;
  }

  Coder& coder_;
  TinFrame frame_;
  const TinSource* source_;
  TileMesh& mesh_;
  TinFront front_;
  std::vector<std::uint32_t> number_;  // of the source's vertices
  std::int32_t next_half_ = 0;
  std::int64_t last_z_ = 0;
  std::int64_t doubled_area_ = 0;
  bool sound_ = true;

  TinModels models_ = TinModels::begun();
};

}  // namespace tintree::codec
