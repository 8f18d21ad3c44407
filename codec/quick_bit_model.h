#pragma once

#include <algorithm>
#include <cstdint>

namespace tintree::codec {

/// A BitModel (codec/range_coder.h) for kinds of bit that come a few hundred times: the first bits count for as much as
/// their number says, 1/2, 1/3, 1/4 ..., until that is below the rates of the long run.
class QuickBitModel {
 public:
  /// In 1..2^16 - 1.
  std::uint32_t zero() const { return (fast_ + slow_) >> 1; }
  void learn(bool bit) {
    const std::uint32_t share = kOne / (2U + seen_);
    move(fast_, bit, std::max(share, kOne >> 5));
    move(slow_, bit, std::max(share, kOne >> 7));
    if (seen_ < kMostSeen) ++seen_;
  }

 private:
  static constexpr std::uint32_t kOne = 1U << 16;
  static constexpr std::uint32_t kMostSeen = 126;

  static void move(std::uint32_t& p, bool bit, std::uint32_t rate) {
    p = bit ? p - (p * rate >> 16) : p + ((kOne - 1 - p) * rate >> 16);
  }

  std::uint32_t fast_ = kOne / 2;
  std::uint32_t slow_ = kOne / 2;
  std::uint32_t seen_ = 0;
};

}  // namespace tintree::codec
