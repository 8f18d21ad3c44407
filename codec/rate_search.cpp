#include "codec/rate_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <utility>

#include "codec/residual_plane.h"

namespace tintree::codec {
namespace {

constexpr std::size_t kLeastRate = 64;  // bytes

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

class Search {
 public:
  Search(const Patch& target, const Patch& prediction, const PatchSpec& spec)
      : target_(&target), prediction_(&prediction), spec_(spec) {
    choose_quantizer();
  }

  Expected<EncodedPatch> run() {
    if (spec_.lossless) {
      try_rate(0);
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
  attempt.patch.bytes = residual_bytes(none, {});
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
  attempt.patch.bytes = residual_bytes(quantizer_, *body);
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

}  // namespace

Expected<EncodedPatch> search_rate(const Patch& target, const Patch& prediction, const PatchSpec& spec) {
  return Search(target, prediction, spec).run();
}

}  // namespace tintree::codec
