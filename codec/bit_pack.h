#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::codec {

/// Bits into bytes, the low ones first.
class BitWriter {
 public:
  explicit BitWriter(std::vector<std::byte>& out) : out_(&out) {}

  /// The lower `bits` (0 to 64) of a value whose others are 0.
  void put(std::uint64_t value, int bits) {
    for (; bits > 0; bits -= 8, value >>= 8) {
      const int part = bits < 8 ? bits : 8;
      held_ |= static_cast<std::uint32_t>(value & 0xff) << held_bits_;
      held_bits_ += part;
      if (held_bits_ >= 8) drop_byte();
    }
  }
  /// Fills up the last byte with 0.
  void finish() {
    if (held_bits_ > 0) drop_byte();
    held_bits_ = 0;
  }

 private:
  void drop_byte() {
    out_->push_back(static_cast<std::byte>(held_));
    held_ >>= 8;
    held_bits_ -= 8;
  }

  std::vector<std::byte>* out_;
  std::uint32_t held_ = 0;
  int held_bits_ = 0;
};

/// The way back. Beyond the end there are zeros, and ok() says so.
class BitReader {
 public:
  explicit BitReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  std::uint64_t take(int bits) {
    std::uint64_t value = 0;
    for (int done = 0; done < bits;) {
      const std::size_t at = static_cast<std::size_t>(next_ >> 3);
      if (at >= bytes_.size()) {
        ok_ = false;
        return 0;
      }
      const int skip = static_cast<int>(next_ & 7);
      const int part = bits - done < 8 - skip ? bits - done : 8 - skip;
      const std::uint64_t taken = static_cast<std::uint64_t>(bytes_[at]) >> skip & ((1U << part) - 1);
      value |= taken << done;
      done += part;
      next_ += static_cast<std::uint64_t>(part);
    }
    return value;
  }
  bool ok() const { return ok_; }
  /// What lies behind the last byte that was begun.
  std::span<const std::byte> rest() const {
    const auto used = static_cast<std::size_t>((next_ + 7) >> 3);
    return bytes_.subspan(used < bytes_.size() ? used : bytes_.size());
  }

 private:
  std::span<const std::byte> bytes_;
  std::uint64_t next_ = 0;
  bool ok_ = true;
};

/// How indices below `levels` (2 to 2^32) are packed: `digits` of them, as one number in base `levels`, in `bits` bits.
/// Of all blocks of up to 63 bits the one with the fewest bits an index: within 1 / digits of log2(levels).
struct DigitBlock {
  int digits = 1;
  int bits = 1;

  explicit DigitBlock(std::uint64_t levels) {
    std::uint64_t power = 1;
    digits = 0;
    for (int n = 1; power <= (std::uint64_t{1} << 63) / levels; ++n) {
      power *= levels;
      const auto needed = static_cast<int>(std::bit_width(power - 1));
      if (digits == 0 || needed * digits < bits * n) {
        digits = n;
        bits = needed;
      }
    }
  }
};

}  // namespace tintree::codec
