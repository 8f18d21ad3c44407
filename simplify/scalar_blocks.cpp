#include "simplify/scalar_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>

#include "codec/scalar_pieces.h"
#include "simplify/spoke_distance.h"
#include "simplify/surface_distance.h"

namespace tintree::simplify {
namespace {

using codec::GridBlock;
using codec::GridPlace;
using codec::kBlockCells;
using codec::ScalarShape;

/// Splits blocks until all fit; what a walk over pieces finds that do not fit is its `fits_`.
class BlockSearch final : public codec::ScalarPieces {
 public:
  BlockSearch(SurfaceView& view, ScalarSpec spec) : spec_(std::move(spec)), distance_(view, spec_.column0, spec_.row0) {
    std::int32_t stride = static_cast<std::int32_t>(spec_.level.cells / 2);
    while (stride > 1 && stride >= std::min(spec_.width(), spec_.height())) stride /= 2;
    shape_.sides = spec_.sides;
    shape_.blocks = codec::BlockTree(spec_.width(), spec_.height(), stride);
    shape_.blocks.for_each([&](const GridBlock& block) { fresh_.push_back(block); });
  }

  ScalarShape search() {
    do {
      do balance();
      while (match_sides());
    } while (split_unfit() && !distance_.interrupted());
    return std::move(shape_);
  }

  void cell(const GridPlace& nw, const GridPlace& se) override {
    if (!fits_) return;
    if (se.x - nw.x == se.y - nw.y) {
      const Point a = point(nw);
      const Point d = point(se);
      const auto fit = [&](const Point& b, const Point& c) {
        return distance_.fit_triangle(a, b, c, spec_.bound_m) == SurfaceDistance::Fit::kWithin;
      };
      fits_ = fit(d, point({se.x, nw.y})) && fit(point({nw.x, se.y}), d);
    } else {
      triangle(nw, se, {se.x, nw.y});
      triangle(nw, {nw.x, se.y}, se);
    }
  }
  void fan(const GridPlace& hub, std::span<const GridPlace> around) override {
    if (!fits_) return;
    Star star{point(hub), spec_.bound_m, {}, {}};
    Point last = point(around.back());
    for (const GridPlace& place : around) {
      const Point next = point(place);
      star.sides.push_back({last, next});
      star.spokes.push_back({next, spec_.bound_m});
      last = next;
    }
    fits_ = keeps(star);
  }
  void triangle(const GridPlace& a, const GridPlace& b, const GridPlace& c) override {
    if (!fits_) return;
    const Point p = point(b);
    const Point q = point(c);
    fits_ = keeps({point(a), spec_.bound_m, {{p, q}}, {{p, spec_.bound_m}, {q, spec_.bound_m}}});
  }

 private:
  enum class Samples { kWhole, kMixed, kEmpty };

  Point point(const GridPlace& p) const {
    const double height_m = distance_.surface().sample(p.x, p.y);
    return {static_cast<double>(p.x), static_cast<double>(p.y),
            static_cast<double>(spec_.address(p.x, p.y, height_m)) * spec_.level.heights.step_m};
  }

  /// A star with the edges opposite to its hub.
  bool keeps(const Star& star) {
    HeightInterval interval;
    distance_.clip_star(star, interval);
    for (const Star::Side& side : star.sides) {
      if (!interval.empty()) clip_spoke(distance_.surface(), side.from, side.to, spec_.bound_m, interval);
    }
    return !interval.empty();
  }

  /// In a block and on its edges.
  Samples samples(const GridBlock& block) const {
    const std::int64_t reach = std::int64_t{block.stride} * kBlockCells;
    const std::int64_t x1 = std::min<std::int64_t>(block.x + reach, spec_.width());
    const std::int64_t y1 = std::min<std::int64_t>(block.y + reach, spec_.height());
    bool valid = false;
    bool missing = false;
    for (std::int64_t y = block.y; y <= y1;) {
      std::int64_t rows = 0;
      for (std::int64_t x = block.x; x <= x1;) {
        const SampleRun run = distance_.surface().run_at(x, y);
        const std::int64_t columns = std::min(x1 - x + 1, run.columns);
        rows = std::min(y1 - y + 1, run.rows);
        valid = valid || run.all_valid;
        for (std::int64_t j = 0; j < rows && !run.all_valid; ++j) {
          const float* row = run.heights + j * cache::kBlockStride;
          const auto gone = std::count_if(row, row + columns, [](float h) { return std::isnan(h); });
          missing = missing || gone > 0;
          valid = valid || gone < columns;
          if (valid && missing) return Samples::kMixed;
        }
        x += columns;
      }
      y += rows;
    }
    return missing ? Samples::kEmpty : Samples::kWhole;
  }

  /// The block at a neighbouring place; nothing beyond the tile.
  template <typename Visit>
  void for_each_neighbour(const GridBlock& block, const Visit& visit) const {
    const std::int64_t reach = std::int64_t{block.stride} * kBlockCells;
    const auto at = [&](std::int64_t x, std::int64_t y) {
      if (x < 0 || y < 0 || x >= spec_.width() || y >= spec_.height()) return;
      visit(shape_.blocks.at(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y)));
    };
    at(std::int64_t{block.x} - 1, block.y);
    at(block.x, std::int64_t{block.y} - 1);
    at(block.x + reach, block.y);
    at(block.x, block.y + reach);
  }

  void split(const GridBlock& block) {
    shape_.blocks.split(block.node);
    // Those as wide have finer neighbours now.
    for_each_neighbour(block, [&](const GridBlock& next) {
      if (next.stride == block.stride) set_tested(next.node, false);
    });
    const std::int32_t half = block.stride / 2 * kBlockCells;
    for (const auto& [dx, dy] : {std::array{0, 0}, std::array{half, 0}, std::array{0, half}, std::array{half, half}}) {
      if (block.x + dx < spec_.width() && block.y + dy < spec_.height())
        fresh_.push_back(shape_.blocks.at(block.x + dx, block.y + dy));
    }
  }

  /// Settles fresh blocks: none has a hole in it, nor a neighbour of more than twice its stride.
  void balance() {
    std::vector<GridBlock> settled;
    while (!fresh_.empty() || !settled.empty()) {
      // First all that are empty, which ask nothing of their neighbours, nor their neighbours of them.
      const bool is_fresh = !fresh_.empty();
      std::vector<GridBlock>& blocks = is_fresh ? fresh_ : settled;
      const GridBlock block = blocks.back();
      blocks.pop_back();
      if (shape_.blocks.is_split(block.node)) continue;
      if (is_fresh) {
        const Samples found = samples(block);
        if (found == Samples::kEmpty) {
          shape_.blocks.set_empty(block.node);
        } else if (found == Samples::kMixed && block.stride > 1) {
          split(block);
        } else {
          settled.push_back(block);
        }
        continue;
      }
      wide_.clear();
      for_each_neighbour(block, [&](const GridBlock& next) {
        if (!next.empty && next.stride > 2 * block.stride) wide_.push_back(next);
      });
      if (!wide_.empty()) settled.push_back(block);
      for (const GridBlock& next : wide_) {
        if (!shape_.blocks.is_split(next.node)) split(next);
      }
    }
  }

  /// Splits blocks until all at one edge of a side have one stride or the edge within a cell; false when that was so.
  bool match_sides() {
    for (int side = 0; side < 4; ++side) {
      const auto& places = shape_.sides[static_cast<std::size_t>(side)];
      const bool horizontal = side == ScalarShape::kNorth || side == ScalarShape::kSouth;
      const std::int32_t line = side == ScalarShape::kSouth  ? spec_.height() - 1
                                : side == ScalarShape::kEast ? spec_.width() - 1
                                                             : 0;
      for (std::size_t k = 0; k + 1 < places.size(); ++k) {
        if (places[k + 1] - places[k] == 1) continue;
        wide_.clear();
        std::int32_t finest = std::numeric_limits<std::int32_t>::max();
        for (std::int64_t at = places[k]; at < places[k + 1];) {
          const auto here = static_cast<std::int32_t>(at);
          wide_.push_back(horizontal ? shape_.blocks.at(here, line) : shape_.blocks.at(line, here));
          finest = std::min(finest, wide_.back().stride);
          at = (horizontal ? wide_.back().x : wide_.back().y) + std::int64_t{wide_.back().stride} * kBlockCells;
        }
        for (const GridBlock& block : wide_) {
          if (block.stride > finest) split(block);
        }
      }
    }
    return !fresh_.empty();
  }

  /// Whether any had to be split.
  bool split_unfit() {
    codec::ScalarPieceWalk walk(shape_);
    std::vector<GridBlock> unfit;
    shape_.blocks.for_each([&](const GridBlock& block) {
      if (block.empty || block.stride == 1 || is_tested(block.node) || distance_.interrupted()) return;
      fits_ = true;
      walk.visit(block, *this);
      if (!fits_) unfit.push_back(block);
      // Edges of sides are many blocks' together.
      set_tested(block.node, fits_ && !touches_side(block));
    });
    for (const GridBlock& block : unfit) split(block);
    return !unfit.empty();
  }

  bool touches_side(const GridBlock& block) const {
    const std::int64_t reach = std::int64_t{block.stride} * kBlockCells;
    return block.x == 0 || block.y == 0 || block.x + reach >= spec_.width() || block.y + reach >= spec_.height();
  }
  bool is_tested(std::size_t node) const { return node < tested_.size() && tested_[node]; }
  void set_tested(std::size_t node, bool tested) {
    if (node >= tested_.size()) tested_.resize(shape_.blocks.nodes());
    tested_[node] = tested;
  }

  ScalarSpec spec_;
  SurfaceDistance distance_;
  ScalarShape shape_;
  std::vector<GridBlock> fresh_;
  std::vector<GridBlock> wide_;
  std::vector<bool> tested_;  // by node: fits, and no neighbour has been split since
  bool fits_ = true;
};

}  // namespace

ScalarShape choose_blocks(SurfaceView& view, ScalarSpec spec) { return BlockSearch(view, std::move(spec)).search(); }

}  // namespace tintree::simplify
