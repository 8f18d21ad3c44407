#include "codec/wavelet_patch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "codec/range_coder.h"
#include "codec/jpeg2000_plane.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

constexpr int kMostBits = 16;
constexpr std::uint64_t kCorrectedFlag = 32;
constexpr std::size_t kLeastRate = 64;  // bytes
/// No height of ours is farther from 0; damaged bytes may lead there.
constexpr std::int64_t kFarthest = std::int64_t{1} << 50;

/// The quantiser: residual = low + step * number, number in 0 .. 2^bits - 1.
struct Quantizer {
  std::int64_t low = 0;
  std::int64_t step = 1;
  int bits = 0;  ///< 0: all numbers are 0 and no plane follows.
};

struct Stats {
  std::int64_t max = 0;
  double rms = 0;
};

Stats difference(const Patch& target, const Patch& other) {
  Stats out;
  double squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < target.heights.size(); ++i) {
    if (target.heights[i] == kNoHeight) continue;
    const std::int64_t d = std::abs(target.heights[i] - other.heights[i]);
    out.max = std::max(out.max, d);
    squares += static_cast<double>(d) * static_cast<double>(d);
    ++count;
  }
  if (count > 0) out.rms = std::sqrt(squares / static_cast<double>(count));
  return out;
}

std::int64_t round_down(std::int64_t value, std::int64_t step) {
  return value >= 0 ? value / step : -((step - 1 - value) / step);
}

Patch dequantized(const Patch& prediction, const Quantizer& quantizer, const Plane& plane) {
  Patch out = prediction;
  for (std::size_t i = 0; i < out.heights.size(); ++i) {
    out.heights[i] += quantizer.low + (plane.samples.empty() ? 0 : quantizer.step * plane.samples[i]);
  }
  return out;
}

void put_head(std::vector<std::byte>& out, const Quantizer& quantizer, bool corrected,
              std::span<const std::byte> body) {
  put_varint(out, static_cast<std::uint64_t>(quantizer.bits) | (corrected ? kCorrectedFlag : 0));
  put_signed_varint(out, quantizer.low);
  if (quantizer.bits == 0) return;
  put_varint(out, static_cast<std::uint64_t>(quantizer.step));
  put_varint(out, body.size());
  out.insert(out.end(), body.begin(), body.end());
}

/// How many quanta of 2 bound + 1 a sample is moved; most are not. One walk for both ways: `code(model, i)` codes
/// that of sample i and returns it.
class Corrections {
 public:
  Corrections(const Plane& plane, std::int64_t step, std::int64_t bound, int side)
      : plane_(&plane), step_(step), quantum_(2 * bound + 1), side_(side) {}

  template <typename Code>
  void visit(const Code& code) {
    std::vector<std::int64_t> numbers(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    const auto size = [&](int x, int y) {
      return x < 0 || y < 0 || x >= side_ ? 0 : std::min<std::int64_t>(std::abs(numbers[index(x, y)]), 4);
    };
    for (int y = 0; y < side_; ++y) {
      for (int x = 0; x < side_; ++x) {
        const std::int64_t near = 2 * size(x - 1, y) + 2 * size(x, y - 1) + size(x - 1, y - 1) + size(x + 1, y - 1);
        static constexpr std::array<std::size_t, 8> kNear{0, 1, 2, 3, 3, 4, 4, 5};
        const std::size_t row = near < 8 ? kNear[static_cast<std::size_t>(near)] : 6;
        numbers[index(x, y)] = code(models_[row][activity(x, y)], index(x, y));
      }
    }
  }

  std::int64_t quantum() const { return quantum_; }

 private:
  static constexpr std::size_t kActivities = 6;

  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(x);
  }

  /// How much the decoded residuals change here, in quanta.
  std::size_t activity(int x, int y) const {
    if (plane_->samples.empty()) return 0;
    const auto number = [&](int i, int j) {
      return std::int64_t{plane_->samples[index(std::clamp(i, 0, side_ - 1), std::clamp(j, 0, side_ - 1))]};
    };
    const std::int64_t change =
        std::abs(number(x + 1, y) - number(x - 1, y)) + std::abs(number(x, y + 1) - number(x, y - 1)) +
        std::abs(4 * number(x, y) - number(x + 1, y) - number(x - 1, y) - number(x, y + 1) - number(x, y - 1));
    const auto quanta = static_cast<std::uint64_t>(4 * change * step_ / quantum_);
    return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(quanta)), kActivities - 1);
  }

  const Plane* plane_;
  std::int64_t step_;
  std::int64_t quantum_;
  int side_;
  std::array<std::array<NumberModel, kActivities>, 7> models_;
};

/// Appends what brings every sample of `out` within the bound.
void put_corrections(std::vector<std::byte>& bytes, const Patch& target, const Plane& plane, std::int64_t step,
                     std::int64_t bound, Patch& out) {
  Corrections corrections(plane, step, bound, target.side);
  RangeEncoder coder;
  corrections.visit([&](NumberModel& model, std::size_t i) {
    std::int64_t number = 0;
    if (target.heights[i] != kNoHeight) {
      number = round_down(target.heights[i] - out.heights[i] + bound, corrections.quantum());
      out.heights[i] += number * corrections.quantum();
    }
    return model.code(coder, number);
  });
  const std::vector<std::byte> coded = coder.finish();
  put_varint(bytes, static_cast<std::uint64_t>(bound));
  put_varint(bytes, coded.size());
  bytes.insert(bytes.end(), coded.begin(), coded.end());
}

tl::unexpected<Error> damaged(const char* what) {
  return fail(ErrorCode::kBadData, std::string("the payload's ") + what);
}

/// The way back; drops what it reads from `bytes`.
Expected<void> take_corrections(std::span<const std::byte>& bytes, const Plane& plane, std::int64_t step, Patch& out) {
  std::uint64_t bound = 0;
  std::uint64_t size = 0;
  if (!take_varint(bytes, bound) || bound > static_cast<std::uint64_t>(kFarthest >> 20))
    return damaged("bound is out of range");
  if (!take_varint(bytes, size) || size > bytes.size()) return damaged("corrections end early");
  RangeDecoder coder(bytes.first(static_cast<std::size_t>(size)));
  bytes = bytes.subspan(static_cast<std::size_t>(size));
  Corrections corrections(plane, step, static_cast<std::int64_t>(bound), out.side);
  corrections.visit([&](NumberModel& model, std::size_t i) {
    const std::int64_t number = model.code(coder, 0);
    // Unsigned: what damaged bytes make overflow only wraps round.
    out.heights[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(out.heights[i]) +
                                               static_cast<std::uint64_t>(number) *
                                                   static_cast<std::uint64_t>(corrections.quantum()));
    return number;
  });
  return coder.exhausted() ? Expected<void>(damaged("corrections are cut short")) : Expected<void>();
}

class Search {
 public:
  Search(const Patch& target, const Patch& prediction, const PatchSpec& spec)
      : target_(&target), prediction_(&prediction), spec_(spec) {
    choose_quantizer();
  }

  Expected<EncodedPatch> run() {
    if (spec_.lossless) {
      try_rate(0);
    } else if (spec_.corrected) {
      find_cheapest();
    } else {
      find_lowest();
    }
    if (error_) return tl::unexpected(*error_);
    best_->encodes = encodes_;
    return std::move(*best_);
  }

 private:
  struct Attempt {
    EncodedPatch patch;
    bool fits = false;
  };

  void choose_quantizer();
  void try_without();
  bool try_rate(std::size_t rate);
  void find_lowest();
  void find_cheapest();
  bool fits(const Patch& reconstruction) const {
    const Stats off = difference(*target_, reconstruction);
    return spec_.criterion == PatchCriterion::kMax ? off.max <= spec_.bound
                                                   : off.rms <= static_cast<double>(spec_.bound);
  }
  bool keep(Attempt attempt);

  const Patch* target_;
  const Patch* prediction_;
  PatchSpec spec_;
  Quantizer quantizer_;
  std::int64_t mean_ = 0;
  Plane numbers_;
  std::optional<EncodedPatch> best_;
  std::optional<Error> error_;
  int encodes_ = 0;
};

void Search::choose_quantizer() {
  std::int64_t low = std::numeric_limits<std::int64_t>::max();
  std::int64_t high = std::numeric_limits<std::int64_t>::min();
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < target_->heights.size(); ++i) {
    if (target_->heights[i] == kNoHeight) continue;
    const std::int64_t d = target_->heights[i] - prediction_->heights[i];
    low = std::min(low, d);
    high = std::max(high, d);
    sum += static_cast<double>(d);
    ++count;
  }
  if (count == 0) return;
  mean_ = std::llround(sum / static_cast<double>(count));
  quantizer_.low = low;
  for (quantizer_.bits = spec_.bits;; ++quantizer_.bits) {
    const std::int64_t levels = (std::int64_t{1} << quantizer_.bits) - 1;
    quantizer_.step = std::max<std::int64_t>(1, (high - low + levels - 1) / levels);
    const bool fine = quantizer_.step <= std::max<std::int64_t>(1, spec_.bound);
    if (fine || spec_.lossless || quantizer_.bits == kMostBits) break;
  }
  if (spec_.corrected) quantizer_.step = std::max(quantizer_.step, spec_.bound / 2);
  const auto highest = static_cast<std::uint64_t>((high - low + quantizer_.step / 2) / quantizer_.step);
  quantizer_.bits = std::max(1, static_cast<int>(std::bit_width(highest)));
  numbers_ = {target_->side, target_->side, quantizer_.bits, {}};
  numbers_.samples.reserve(target_->heights.size());
  for (std::size_t i = 0; i < target_->heights.size(); ++i) {
    const std::int64_t d = target_->heights[i] == kNoHeight ? mean_ : target_->heights[i] - prediction_->heights[i];
    numbers_.samples.push_back(static_cast<std::int32_t>((d - low + quantizer_.step / 2) / quantizer_.step));
  }
}

/// Keeps the attempt when it is the smallest that fits; true when it fits.
bool Search::keep(Attempt attempt) {
  if (!attempt.fits) return false;
  if (!best_ || attempt.patch.bytes.size() < best_->bytes.size()) best_ = std::move(attempt.patch);
  return true;
}

/// No plane: the prediction, moved by the residuals' mean.
void Search::try_without() {
  const Quantizer none{.low = mean_};
  Attempt attempt;
  attempt.patch.reconstruction = dequantized(*prediction_, none, {});
  put_head(attempt.patch.bytes, none, spec_.corrected, {});
  if (spec_.corrected) put_corrections(attempt.patch.bytes, *target_, {}, 1, spec_.bound, attempt.patch.reconstruction);
  attempt.fits = fits(attempt.patch.reconstruction);
  keep(std::move(attempt));
}

/// True when it fits; at rate 0, without loss, it is taken whether it does or not.
bool Search::try_rate(std::size_t rate) {
  ++encodes_;
  auto body = encode_plane(numbers_, rate);
  auto plane = body ? decode_plane(*body, numbers_.width, numbers_.height, numbers_.bits)
                    : Expected<Plane>(tl::unexpected(body.error()));
  if (!plane) {
    error_ = plane.error();
    return true;
  }
  Attempt attempt;
  attempt.patch.reconstruction = dequantized(*prediction_, quantizer_, *plane);
  put_head(attempt.patch.bytes, quantizer_, spec_.corrected, *body);
  if (spec_.corrected) {
    put_corrections(attempt.patch.bytes, *target_, *plane, quantizer_.step, spec_.bound, attempt.patch.reconstruction);
  }
  attempt.fits = rate == 0 || fits(attempt.patch.reconstruction);
  return keep(std::move(attempt));
}

/// The lowest rate at which the criterion holds: fourfold steps upwards, then three halvings of the last one.
void Search::find_lowest() {
  try_without();
  if (best_ || quantizer_.bits == 0) return;
  const std::size_t whole = numbers_.samples.size() * static_cast<std::size_t>(numbers_.bits) / 8;
  std::size_t low = kLeastRate / 2;
  std::size_t high = kLeastRate;
  while (high < whole && !try_rate(high)) {
    low = high;
    high *= 4;
  }
  if (error_) return;
  if (high >= whole) {
    try_rate(0);
    high = best_ ? std::min(whole, best_->bytes.size()) : whole;
  }
  for (int halving = 0; halving < 3 && high > low + 8 && !error_; ++halving) {
    const auto middle = static_cast<std::size_t>(std::sqrt(static_cast<double>(low) * static_cast<double>(high)));
    (try_rate(middle) ? high : low) = middle;
  }
}

/// The rate at which plane and corrections together take the fewest bytes, which may fall, rise and fall again with it:
/// fourfold steps over all rates, then halves and roots of two around the best.
void Search::find_cheapest() {
  try_without();
  if (quantizer_.bits == 0) return;
  const std::size_t whole = numbers_.samples.size() * static_cast<std::size_t>(numbers_.bits) / 8;
  std::size_t best_rate = 0;
  const auto attempt = [&](double rate) {
    if (error_ || rate > static_cast<double>(whole)) return;
    const std::size_t before = best_->bytes.size();
    try_rate(static_cast<std::size_t>(rate));
    if (best_->bytes.size() < before) best_rate = static_cast<std::size_t>(rate);
  };
  for (std::size_t rate = kLeastRate; rate < whole; rate *= 4) attempt(static_cast<double>(rate));
  for (const double factor : {2.0, std::sqrt(2.0)}) {
    const auto middle = static_cast<double>(best_rate);
    if (best_rate == 0) return;
    attempt(middle / factor);
    attempt(middle * factor);
  }
}

}  // namespace

Patch predict_patch(const Patch& parent, int quadrant, int units) {
  const int n = parent.side - 2 * kPatchMargin;
  Patch out(parent.side, 0);
  // A sample lies a quarter of the parent's spacing off the nearer of the two that it is between.
  const auto near = [&](int i, int half) { return (i + half + kPatchMargin) >> 1; };
  const int east = (quadrant & 1) * n;
  const int south = (quadrant >> 1) * n;
  for (int y = 0; y < out.side; ++y) {
    const int y0 = near(y, south);
    const int y1 = y0 + (((y + south) & 1) == 0 ? -1 : 1);
    for (int x = 0; x < out.side; ++x) {
      const int x0 = near(x, east);
      const int x1 = x0 + (((x + east) & 1) == 0 ? -1 : 1);
      const std::int64_t sum =
          9 * parent.at(x0, y0) + 3 * parent.at(x1, y0) + 3 * parent.at(x0, y1) + parent.at(x1, y1);
      out.at(x, y) = (sum * units + 8) >> 4;
    }
  }
  return out;
}

Expected<EncodedPatch> encode_patch(const Patch& target, const Patch& prediction, const PatchSpec& spec) {
  return Search(target, prediction, spec).run();
}

Expected<Patch> decode_patch(std::span<const std::byte>& bytes, const Patch& prediction) {
  std::uint64_t flags = 0;
  std::uint64_t step = 1;
  std::uint64_t size = 0;
  Quantizer quantizer;
  if (!take_varint(bytes, flags) || !take_signed_varint(bytes, quantizer.low)) return damaged("patch ends early");
  const bool corrected = (flags & kCorrectedFlag) != 0;
  quantizer.bits = static_cast<int>(flags & (kCorrectedFlag - 1));
  if ((flags & ~(2 * kCorrectedFlag - 1)) != 0 || quantizer.bits > kMostBits)
    return damaged("patch is of no known kind");
  Plane plane;
  if (quantizer.bits > 0) {
    if (!take_varint(bytes, step) || !take_varint(bytes, size) || size > bytes.size())
      return damaged("plane ends early");
    auto decoded =
        decode_plane(bytes.first(static_cast<std::size_t>(size)), prediction.side, prediction.side, quantizer.bits);
    if (!decoded) return tl::unexpected(decoded.error());
    plane = std::move(*decoded);
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
  if (std::abs(quantizer.low) > kFarthest || step == 0 || step > static_cast<std::uint64_t>(kFarthest >> kMostBits)) {
    return damaged("quantiser is out of range");
  }
  quantizer.step = static_cast<std::int64_t>(step);
  Patch out = dequantized(prediction, quantizer, plane);
  if (corrected) {
    if (auto done = take_corrections(bytes, plane, quantizer.step, out); !done) return tl::unexpected(done.error());
  }
  const bool near = std::ranges::all_of(out.heights, [](std::int64_t h) { return h >= -kFarthest && h <= kFarthest; });
  return near ? Expected<Patch>(std::move(out)) : damaged("heights are out of range");
}

}  // namespace tintree::codec
