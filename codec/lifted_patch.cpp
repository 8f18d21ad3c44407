#include "codec/lifted_patch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "codec/quick_bit_model.h"
#include "codec/quincunx.h"
#include "codec/range_coder.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

using Model = NumberModelOf<QuickBitModel>;

constexpr int kCoarsestSpacing = 64;

std::int64_t round_down(std::int64_t value, std::int64_t step) {
  return value >= 0 ? value / step : -((step - 1 - value) / step);
}

/// Both ways' walk over a patch. A `Way` says, in the order of the bytes, which filter a pass takes, and by how many
/// quanta a sample is off what was expected: filter(models, places) and number(model, index, expected, turned).
class Walk {
 public:
  Walk(const Patch& prediction, std::int64_t bound)
      : prediction_(&prediction),
        quantum_(2 * bound + 1),
        out_(prediction.side, 0),
        numbers_(prediction.heights.size()) {}

  template <typename Way>
  Patch run(Way& way) {
    int spacing = kCoarsestSpacing;
    while (spacing > side()) spacing /= 2;
    begin(way, spacing);
    for (int half = spacing / 2; half >= 1; half /= 2) {
      refine(way, {half, true});
      refine(way, {half, false});
    }
    return std::move(out_);
  }

 private:
  static constexpr std::size_t kRows = 10;
  static constexpr std::size_t kColumns = 6;

  int side() const { return out_.side; }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < side() && y < side(); }
  std::int64_t beyond(int x, int y) const { return out_.at(x, y) - prediction_->at(x, y); }

  /// The coarsest lattice, each sample foretold from those in the north and west.
  template <typename Way>
  void begin(Way& way, int spacing) {
    for (int y = 0; y < side(); y += spacing) {
      for (int x = 0; x < side(); x += spacing) {
        const std::int64_t west = x > 0 ? beyond(x - spacing, y) : y > 0 ? beyond(x, y - spacing) : 0;
        const std::int64_t north = y > 0 ? beyond(x, y - spacing) : west;
        put(way, first_, out_.index(x, y), prediction_->at(x, y) + (west + north) / 2, false);
      }
    }
  }

  template <typename Way>
  void refine(Way& way, const QuincunxPass& pass) {
    places_.clear();
    pass.each(side(), [&](int x, int y) {
      if (whole(pass, x, y)) places_.push_back(place(pass, x, y));
    });
    const QuincunxFilter filter = way.filter(filter_models_, places_);
    auto next = places_.begin();
    pass.each(side(), [&](int x, int y) {
      std::size_t column = kColumns;
      std::int64_t expected = 0;
      if (whole(pass, x, y)) {
        const auto quanta = static_cast<std::uint64_t>(next->bend() / (4 * quantum_));
        column = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(quanta)), kColumns - 1);
        expected = (next->expected(filter) + 16) >> 5;
        ++next;
      } else {
        expected = prediction_->at(x, y) + beyond_around(pass, x, y);
      }
      int near = 0;  // the numbers of the four places around
      int sizes = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        const int n = number(x + pass.around()[i].x * pass.half, y + pass.around()[i].y * pass.half);
        near += n;
        sizes += std::abs(n);
      }
      put(way, models_[row(sizes + sizes_before(pass, x, y))][column], out_.index(x, y), expected, near < 0);
    });
  }

  bool whole(const QuincunxPass& pass, int x, int y) const {
    return std::min(x, y) >= pass.reach() && std::max(x, y) + pass.reach() < side();
  }

  QuincunxPlace place(const QuincunxPass& pass, int x, int y) const {
    QuincunxPlace out{.index = out_.index(x, y), .foretold = prediction_->at(x, y)};
    std::array<std::size_t, 12> at{};
    for (std::size_t i = 0; i < at.size(); ++i) {
      at[i] = out_.index(x + pass.around()[i].x * pass.half, y + pass.around()[i].y * pass.half);
      (i < 4 ? out.near : out.next) += out_.heights[at[i]];
      (i < 4 ? out.near_foretold : out.next_foretold) += prediction_->heights[at[i]];
    }
    out.twist = out_.heights[at[0]] + out_.heights[at[1]] - out_.heights[at[2]] - out_.heights[at[3]];
    return out;
  }

  /// At the square's sides: what the nearest heights are beyond the prediction, of a whole opposite pair if there is
  /// one.
  std::int64_t beyond_around(const QuincunxPass& pass, int x, int y) const {
    std::array<std::int64_t, 2> sum{};
    std::array<std::int64_t, 2> count{};
    for (std::size_t i = 0; i < 4; ++i) {
      const int u = x + pass.around()[i].x * pass.half;
      const int v = y + pass.around()[i].y * pass.half;
      if (!inside(u, v)) continue;
      sum[i / 2] += beyond(u, v);
      ++count[i / 2];
    }
    if (count[0] > count[1]) return sum[0] / count[0];
    if (count[1] > count[0]) return sum[1] / count[1];
    return (sum[0] + sum[1]) / (count[0] + count[1]);
  }

  /// Cut to 3 either way; 0 outside.
  int number(int x, int y) const { return inside(x, y) ? numbers_[out_.index(x, y)] : 0; }
  int size(int x, int y) const { return std::abs(number(x, y)); }

  /// Of the numbers of this pass next to a place.
  int sizes_before(const QuincunxPass& pass, int x, int y) const {
    const int h = pass.half;
    const int two = 2 * h;
    return pass.diagonal ? 2 * size(x - two, y) + 2 * size(x, y - two) + size(x - two, y - two) + size(x + two, y - two)
                         : 2 * size(x - h, y - h) + 2 * size(x + h, y - h) + size(x - two, y) + size(x, y - two);
  }

  /// 0, 1, 2, 3, 4-5, 6-7, 8-11, 12-15, 16-23, more.
  static std::size_t row(int sizes) {
    const auto n = static_cast<unsigned>(sizes);
    if (n < 2) return n;
    const int width = static_cast<int>(std::bit_width(n));
    return static_cast<std::size_t>(2 * width - 2) + (n >> (width - 2) & 1);
  }

  template <typename Way>
  void put(Way& way, Model& model, std::size_t i, std::int64_t expected, bool turned) {
    const std::int64_t number = way.number(model, i, expected, turned);
    numbers_[i] = static_cast<std::int8_t>(std::clamp<std::int64_t>(number, -3, 3));
    // Unsigned: what damaged bytes make overflow only wraps round.
    const auto moved =
        static_cast<std::int64_t>(static_cast<std::uint64_t>(expected) +
                                  static_cast<std::uint64_t>(number) * static_cast<std::uint64_t>(quantum_));
    out_.heights[i] = std::clamp(moved, -kFarthestHeight, kFarthestHeight);
  }

  const Patch* prediction_;
  std::int64_t quantum_;
  Patch out_;
  std::vector<std::int8_t> numbers_;
  std::vector<QuincunxPlace> places_;
  Model first_;
  std::array<Model, 2> filter_models_;
  std::array<std::array<Model, kColumns + 1>, kRows> models_;
};

class Encoding {
 public:
  Encoding(const Patch& target, std::int64_t bound) : target_(&target), bound_(bound) {}

  /// The one that leaves the smallest numbers.
  QuincunxFilter filter(std::array<Model, 2>& models, const std::vector<QuincunxPlace>& places) {
    QuincunxFilter best;
    std::int64_t least = cost(best, places, std::numeric_limits<std::int64_t>::max());
    for (int edge = 0; edge < QuincunxFilter::kEdges; ++edge) {
      for (int blend = 0; blend < QuincunxFilter::kBlends; ++blend) {
        const std::int64_t other = cost({blend, edge}, places, least);
        if (other >= least) continue;
        least = other;
        best = {blend, edge};
      }
    }
    models[0].code(coder_, best.blend);
    models[1].code(coder_, best.edge);
    return best;
  }

  std::int64_t number(Model& model, std::size_t i, std::int64_t expected, bool turned) {
    const std::int64_t h = target_->heights[i];
    const std::int64_t n = h == kNoHeight ? 0 : round_down(h - expected + bound_, 2 * bound_ + 1);
    model.code(coder_, turned ? -n : n);
    return n;
  }

  std::vector<std::byte> finish() { return coder_.finish(); }

 private:
  /// In bits, roughly; any that is not below `enough` where it is not.
  std::int64_t cost(const QuincunxFilter& filter, const std::vector<QuincunxPlace>& places, std::int64_t enough) const {
    std::int64_t out = 0;
    for (const QuincunxPlace& place : places) {
      if (target_->heights[place.index] == kNoHeight) continue;
      const std::int64_t off = std::abs(target_->heights[place.index] - ((place.expected(filter) + 16) >> 5));
      if (off <= bound_) continue;
      out += 2 + 2 * std::bit_width(static_cast<std::uint64_t>((off + bound_) / (2 * bound_ + 1)));
      if (out >= enough) break;
    }
    return out;
  }

  const Patch* target_;
  std::int64_t bound_;
  RangeEncoder coder_;
};

class Decoding {
 public:
  explicit Decoding(std::span<const std::byte> bytes) : coder_(bytes) {}

  QuincunxFilter filter(std::array<Model, 2>& models, const std::vector<QuincunxPlace>&) {
    const std::int64_t blend = models[0].code(coder_, 0);
    const std::int64_t edge = models[1].code(coder_, 0);
    return {static_cast<int>(std::clamp<std::int64_t>(blend, 0, QuincunxFilter::kBlends - 1)),
            static_cast<int>(std::clamp<std::int64_t>(edge, 0, QuincunxFilter::kEdges - 1))};
  }
  std::int64_t number(Model& model, std::size_t, std::int64_t, bool turned) {
    const std::int64_t n = model.code(coder_, 0);
    return turned ? -n : n;
  }
  bool exhausted() const { return coder_.exhausted(); }

 private:
  RangeDecoder coder_;
};

tl::unexpected<Error> damaged(const char* what) {
  return fail(ErrorCode::kBadData, std::string("the payload's ") + what);
}

}  // namespace

Patch put_lifted(std::vector<std::byte>& bytes, const Patch& target, const Patch& prediction, std::int64_t bound) {
  Encoding way(target, bound);
  Patch out = Walk(prediction, bound).run(way);
  const std::vector<std::byte> coded = way.finish();
  put_varint(bytes, static_cast<std::uint64_t>(bound));
  put_varint(bytes, coded.size());
  bytes.insert(bytes.end(), coded.begin(), coded.end());
  return out;
}

Expected<Patch> take_lifted(std::span<const std::byte>& bytes, const Patch& prediction) {
  std::uint64_t bound = 0;
  std::uint64_t size = 0;
  if (!take_varint(bytes, bound) || bound > static_cast<std::uint64_t>(kMostLiftedBound))
    return damaged("bound is out of range");
  if (!take_varint(bytes, size) || size > bytes.size()) return damaged("patch is cut short");
  Decoding way(bytes.first(static_cast<std::size_t>(size)));
  bytes = bytes.subspan(static_cast<std::size_t>(size));
  Patch out = Walk(prediction, static_cast<std::int64_t>(bound)).run(way);
  return way.exhausted() ? Expected<Patch>(damaged("patch ends early")) : Expected<Patch>(std::move(out));
}

}  // namespace tintree::codec
