#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::codec {

/// The chance of a 0, learnt as it goes (the adaptive binary model of LZMA's range coder).
struct BitModel {
  static constexpr int kBits = 12;
  static constexpr int kRate = 4;
  std::uint16_t zero = 1 << (kBits - 1);

  void learn(bool bit) {
    if (bit) {
      zero = static_cast<std::uint16_t>(zero - (zero >> kRate));
    } else {
      zero = static_cast<std::uint16_t>(zero + (((1 << kBits) - zero) >> kRate));
    }
  }
};

/// Writes bits in as much room as their models make them worth (Martin 1979; Pavlov's carry handling).
class BitEncoder {
 public:
  explicit BitEncoder(std::vector<std::byte>& out) : out_(&out) {}

  void put(BitModel& model, bool bit) {
    const std::uint32_t bound = (range_ >> BitModel::kBits) * model.zero;
    if (bit) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    for (; range_ < (1U << 24); range_ <<= 8) shift();
  }
  void finish() {
    for (int i = 0; i < 5; ++i) shift();
  }

 private:
  void shift() {
    if (low_ < 0xff000000U || low_ > UINT32_MAX) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      if (begun_) out_->push_back(static_cast<std::byte>(held_ + carry));
      for (; pending_ > 0; --pending_) out_->push_back(static_cast<std::byte>(0xff + carry));
      held_ = static_cast<std::uint8_t>(low_ >> 24);
      begun_ = true;
    } else {
      ++pending_;
    }
    low_ = (low_ & 0x00ffffff) << 8;
  }

  std::vector<std::byte>* out_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = UINT32_MAX;
  std::uint64_t pending_ = 0;
  std::uint8_t held_ = 0;
  bool begun_ = false;
};

/// Reads them again; past the end it reads zeros.
class BitDecoder {
 public:
  explicit BitDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
  }

  bool take(BitModel& model) {
    const std::uint32_t bound = (range_ >> BitModel::kBits) * model.zero;
    const bool bit = code_ >= bound;
    if (bit) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    for (; range_ < (1U << 24); range_ <<= 8) code_ = code_ << 8 | next();
    return bit;
  }
  /// Whether exactly the bytes that the encoder wrote were read.
  bool at_end() const { return read_ == bytes_.size(); }

 private:
  std::uint32_t next() {
    const std::size_t at = read_++;
    return at < bytes_.size() ? static_cast<std::uint32_t>(bytes_[at]) : 0;
  }

  std::span<const std::byte> bytes_;
  std::size_t read_ = 0;
  std::uint32_t range_ = UINT32_MAX;
  std::uint32_t code_ = 0;
};

/// Signed numbers near 0: their magnitude's number of digits bit by bit, then the sign and the digits.
class NumberModel {
 public:
  static constexpr std::size_t kDigits = 25;

  /// `coder(model, bit)` writes a bit, or reads one and returns it; a number of kDigits digits and more is cut.
  template <typename Coder>
  std::int32_t code(const Coder& coder, std::int32_t value) {
    const auto magnitude = static_cast<std::uint32_t>(value < 0 ? -value : value);
    const auto wanted = static_cast<std::size_t>(std::bit_width(magnitude));
    std::size_t digits = 0;
    while (digits < kDigits && coder(length_[digits], digits < wanted)) ++digits;
    if (digits == 0) return 0;
    const bool negative = coder(sign_, value < 0);
    std::uint32_t got = 1;
    for (std::size_t i = digits - 1; i-- > 0;) {
      // Only the first digit below the leading one is worth learning.
      BitModel even;
      const bool bit = (magnitude >> i & 1) != 0;
      got = got << 1 | (coder(i + 2 == digits ? second_[digits] : even, bit) ? 1U : 0U);
    }
    return negative ? -static_cast<std::int32_t>(got) : static_cast<std::int32_t>(got);
  }

 private:
  std::array<BitModel, kDigits + 1> length_;
  std::array<BitModel, kDigits + 1> second_;
  BitModel sign_;
};

}  // namespace tintree::codec
