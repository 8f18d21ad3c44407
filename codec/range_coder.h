#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::codec {

/// What an adaptive binary coder knows of one kind of bit: the mean of a fast and a slow estimate of how probable 0 is,
/// in 2^-16.
class BitModel {
 public:
  /// In 1..2^16 - 1.
  std::uint32_t zero() const { return (std::uint32_t{fast_} + slow_) >> 1; }
  void learn(bool bit) {
    move(fast_, bit, 4);
    move(slow_, bit, 7);
  }

 private:
  static void move(std::uint16_t& p, bool bit, int rate) {
    p = static_cast<std::uint16_t>(bit ? p - (p >> rate) : p + ((0xffffU - p) >> rate));
  }
  std::uint16_t fast_ = 1U << 15;
  std::uint16_t slow_ = 1U << 15;
};

/// So many zeros may be missing at an encoder's end.
inline constexpr std::size_t kRangeSpare = 4;

/// No bit costs less than 1 / kMostBitsPerByte bytes, so bytes say how many bits they may hold at most.
inline constexpr std::size_t kMostBitsPerByte = 5200;

/// BitModel, or one that learns in another way (QuickBitModel).
template <typename Model>
concept BitPredictor = requires(Model model) {
  model.zero();
  model.learn(true);
};

/// Writes bits by their models' probabilities: a range coder with carries (Martin 1979, as LZMA has it). Integers only,
/// so that every machine reads the same. Cost: about 5 ns a bit.
class RangeEncoder {
 public:
  template <BitPredictor Model>
  bool bit(Model& model, bool value) {
    const std::uint32_t below = (range_ >> 16) * model.zero();
    if (value) {
      low_ += below;
      range_ -= below;
    } else {
      range_ = below;
    }
    model.learn(value);
    normalise();
    return value;
  }
  /// A bit of which nothing is known.
  bool bit(bool value) {
    range_ >>= 1;
    if (value) low_ += range_;
    normalise();
    return value;
  }
  /// All bytes, less up to `spare` (0 to kRangeSpare) zeros at their end. The encoder is used up.
  std::vector<std::byte> finish(std::size_t spare = kRangeSpare) {
    for (int i = 0; i < 5; ++i) shift();
    for (std::size_t i = 0; i < spare && !out_.empty() && out_.back() == std::byte{0}; ++i) out_.pop_back();
    return std::move(out_);
  }

 private:
  void normalise() {
    for (; range_ < (1U << 24); range_ <<= 8) shift();
  }
  void shift() {
    if (low_ < 0xff000000U || low_ > 0xffffffffU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      if (started_) out_.push_back(static_cast<std::byte>(cache_ + carry));
      for (; pending_ > 0; --pending_) out_.push_back(static_cast<std::byte>(0xff + carry));
      cache_ = static_cast<std::uint8_t>(low_ >> 24);
      started_ = true;
    } else {
      ++pending_;
    }
    low_ = (low_ & 0x00ffffffU) << 8;
  }

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffffU;
  std::uint8_t cache_ = 0;
  bool started_ = false;
  std::size_t pending_ = 0;
  std::vector<std::byte> out_;
};

/// Reads what RangeEncoder has written; beyond the end it reads zeros, and exhausted() tells so.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  /// The value given is what an encoder would write, and ignored: so that one function can do both.
  template <BitPredictor Model>
  bool bit(Model& model, bool = false) {
    const std::uint32_t below = (range_ >> 16) * model.zero();
    const bool value = code_ >= below;
    if (value) {
      code_ -= below;
      range_ -= below;
    } else {
      range_ = below;
    }
    model.learn(value);
    normalise();
    return value;
  }
  bool bit(bool = false) {
    range_ >>= 1;
    const bool value = code_ >= range_;
    if (value) code_ -= range_;
    normalise();
    return value;
  }
  /// Whether more has been asked for than was ever written: the bytes are cut short or no such code.
  bool exhausted() const { return missing_ > kRangeSpare; }
  /// Whether exactly the bytes of finish(0) have been read.
  bool finished() const { return bytes_.empty() && missing_ == 0; }

 private:
  void normalise() {
    for (; range_ < (1U << 24); range_ <<= 8) code_ = code_ << 8 | next();
  }
  std::uint32_t next() {
    if (bytes_.empty()) {
      ++missing_;
      return 0;
    }
    const auto b = static_cast<std::uint32_t>(bytes_.front());
    bytes_ = bytes_.subspan(1);
    return b;
  }

  std::span<const std::byte> bytes_;
  std::size_t missing_ = 0;
  std::uint32_t code_ = 0;
  std::uint32_t range_ = 0xffffffffU;
};

/// Whole numbers of either sign, those near 0 in few bits: zero or not, sign, number of digits, the digits. `Coder` is
/// RangeEncoder or RangeDecoder.
template <BitPredictor Bit>
class NumberModelOf {
 public:
  template <typename Coder>
  std::int64_t code(Coder& coder, std::int64_t value) {
    if (!coder.bit(some_, value != 0)) return 0;
    const bool negative = coder.bit(negative_, value < 0);
    const auto size = static_cast<std::uint64_t>(value < 0 ? -value : value);
    const int digits = static_cast<int>(std::bit_width(size));
    int known = 1;
    while (known < kMostDigits && coder.bit(more_[known], digits > known)) ++known;
    std::uint64_t read = 1;
    for (int i = known - 2; i >= 0; --i) {
      const bool digit = (size >> i & 1) != 0;
      const bool adaptive = i >= known - 3;
      const std::size_t before = i == known - 2 ? 0 : 1 + (read & 1);
      read = read << 1 | (adaptive ? coder.bit(digit_[known][before], digit) : coder.bit(digit) ? 1U : 0U);
    }
    return negative ? -static_cast<std::int64_t>(read) : static_cast<std::int64_t>(read);
  }

 private:
  static constexpr int kMostDigits = 62;
  Bit some_;
  Bit negative_;
  Bit more_[kMostDigits + 1];
  Bit digit_[kMostDigits + 1][3];
};

using NumberModel = NumberModelOf<BitModel>;

}  // namespace tintree::codec
