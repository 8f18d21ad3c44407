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

/// Encodes of a search at most, before it gives in and codes without loss.
constexpr int kMostEncodes = 8;
/// What an attempt aims at, in parts of the bound, and what is good enough.
constexpr double kAim = 0.99;
constexpr double kEnough = 0.98;
constexpr double kQuickAim = 0.95;
/// A quick search divides the bound into so many steps of the quantiser, and lowers its loss by at least that at a
/// time.
constexpr std::int64_t kQuickSteps = 4;
constexpr double kQuickRetry = 0.9;
/// The largest difference is about so many times the root of their mean square.
constexpr double kPeak = 4;
/// Two losses so much apart are the same.
constexpr double kNear = 1.01;
/// A loss that fits is followed by one so many times as large at least, while none has broken the bound.
constexpr double kGrowth = 1.25;
/// Losses below that, in numbers, are next to none.
constexpr double kLeastLoss = 0.1;

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
      try_loss(0);
    } else {
      find_largest();
    }
    if (error_) return tl::unexpected(*error_);
    best_->encodes = encodes_;
    return std::move(*best_);
  }

 private:
  void choose_quantizer();
  void try_without();
  double try_loss(double loss);
  void find_largest();
  /// What it is off, in parts of the bound: it fits up to 1.
  double share(const Patch& reconstruction) const {
    const Stats off = difference(*target_, reconstruction);
    const double most = spec_.criterion == PatchCriterion::kMax ? static_cast<double>(off.max) : off.rms;
    return most == 0 ? 0 : most / static_cast<double>(spec_.bound);
  }
  void keep(EncodedPatch attempt);

  const Patch* target_;
  const Patch* prediction_;
  PatchSpec spec_;
  Quantizer quantizer_;
  std::int64_t mean_ = 0;
  double present_ = 1;  ///< The root of the share of samples that count.
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
  present_ = std::sqrt(static_cast<double>(count) / static_cast<double>(target_->heights.size()));
  quantizer_.low = low;
  for (quantizer_.bits = spec_.bits;; ++quantizer_.bits) {
    const std::int64_t levels = (std::int64_t{1} << quantizer_.bits) - 1;
    quantizer_.step = std::max<std::int64_t>(1, (high - low + levels - 1) / levels);
    const bool fine =
        quantizer_.step <= std::max<std::int64_t>(1, spec_.quick ? spec_.bound / kQuickSteps : spec_.bound);
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

/// Of two that fit the smaller one.
void Search::keep(EncodedPatch attempt) {
  if (!best_ || attempt.bytes.size() < best_->bytes.size()) best_ = std::move(attempt);
}

/// No plane: the prediction, moved by the residuals' mean.
void Search::try_without() {
  const Quantizer none{.low = mean_};
  EncodedPatch attempt{residual_bytes(none, {}), dequantized(*prediction_, none, {})};
  if (share(attempt.reconstruction) <= 1) keep(std::move(attempt));
}

/// What it is off, in parts of the bound; kept when it fits, and without loss in any case.
double Search::try_loss(double loss) {
  ++encodes_;
  auto body = encode_plane(numbers_, loss);
  auto plane = body ? decode_plane(*body, numbers_.width, numbers_.height, numbers_.bits)
                    : Expected<Plane>(tl::unexpected(body.error()));
  if (!plane) {
    error_ = plane.error();
    return 0;
  }
  EncodedPatch attempt{residual_bytes(quantizer_, *body), dequantized(*prediction_, quantizer_, *plane)};
  const double off = share(attempt.reconstruction);
  if (loss == 0 || off <= 1) keep(std::move(attempt));
  return off;
}

/// The largest loss with which the criterion holds. A root of mean squares goes with it, nearly, and is good enough
/// when it is near the bound; a largest difference may stay the same over a wide range of losses, which is searched to
/// its end.
void Search::find_largest() {
  try_without();
  if (best_ || quantizer_.bits == 0) return;
  const double aim = spec_.quick ? kQuickAim : kAim;
  const bool max = spec_.criterion == PatchCriterion::kMax;
  const double peak = max ? kPeak : 1;
  double loss = aim * present_ * static_cast<double>(spec_.bound) / static_cast<double>(quantizer_.step) / peak;
  double fits_at = 0;
  double breaks_at = std::numeric_limits<double>::infinity();
  while (encodes_ < kMostEncodes && loss > kLeastLoss && breaks_at > kNear * fits_at) {
    const double off = try_loss(loss);
    const bool fits = off <= 1;
    if (error_ || (fits && (spec_.quick || (!max && off >= kEnough)))) return;
    (fits ? fits_at : breaks_at) = loss;
    loss *= std::clamp(aim / off, 0.25, spec_.quick ? kQuickRetry : 4.0);
    if (std::isinf(breaks_at)) loss = std::max(loss, kGrowth * fits_at);
    if (fits_at == 0 || std::isinf(breaks_at)) continue;
    // Well between the two, however little what is off went with the loss.
    const double ratio = breaks_at / fits_at;
    loss = std::clamp(loss, fits_at * std::pow(ratio, 0.15), fits_at * std::pow(ratio, 0.85));
  }
  if (!best_) try_loss(0);
}

}  // namespace

Expected<EncodedPatch> search_rate(const Patch& target, const Patch& prediction, const PatchSpec& spec) {
  return Search(target, prediction, spec).run();
}

}  // namespace tintree::codec
