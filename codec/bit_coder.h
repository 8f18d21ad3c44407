#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::codec {

/// What a coder has learnt of one kind of binary decision: how likely a 0 is, in 1/4096.
class BitModel {
 public:
  std::uint32_t zero() const { return zero_; }
  /// Halves the distance to what came in 2^rate steps: quickly at first, then slowly.
  void learn(bool bit) {
    const int rate = seen_ < kSlowest - 1 ? (++seen_, seen_) : kSlowest;
    const std::uint32_t to = bit ? kLeast : kWhole - kLeast;
    zero_ = static_cast<std::uint16_t>(static_cast<int>(zero_) +
                                       (static_cast<int>(to) - static_cast<int>(zero_)) / (1 << rate));
  }

  static constexpr int kBits = 12;

 private:
  static constexpr std::uint32_t kWhole = 1U << kBits;
  static constexpr std::uint32_t kLeast = 24;
  static constexpr int kSlowest = 6;

  std::uint16_t zero_ = kWhole / 2;
  std::uint8_t seen_ = 0;
};

/// So many zeros at their end the bytes of an encoder may lack.
inline constexpr std::size_t kBitCoderSpare = 4;

/// Adaptive binary range coder (Martin 1979; the arithmetic of LZMA): integers only, so that every machine decodes the
/// same. Cost: about 5 ns a decision.
class BitEncoder {
 public:
  void put(BitModel& model, bool bit);
  /// The bytes of all decisions; the encoder is used up.
  std::vector<std::byte> finish();

 private:
  void shift();

  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint8_t cache_ = 0;
  std::uint64_t pending_ = 0;  // bytes 0xff that a carry may still turn over
  bool begun_ = false;
  std::vector<std::byte> bytes_;
};

/// Never reads beyond its bytes: behind their end it reads zeros, and exhausted() tells so.
class BitDecoder {
 public:
  explicit BitDecoder(std::span<const std::byte> bytes);
  bool get(BitModel& model);
  /// Whether more has been asked for than was ever put in: the bytes are cut short or no such code.
  bool exhausted() const { return missing_ > kBitCoderSpare; }

 private:
  std::uint8_t next();

  std::span<const std::byte> bytes_;
  std::size_t missing_ = 0;
  std::uint32_t range_ = 0xffffffff;
  std::uint32_t code_ = 0;
};

/// Signed integers as decisions: is it 0, its sign, how many binary digits, the digits behind the first one.
class IntegerModel {
 public:
  void put(BitEncoder& coder, std::int64_t value);
  std::int64_t get(BitDecoder& coder);

 private:
  static constexpr std::size_t kLengths = 63;

  template <typename Code>
  std::int64_t visit(const Code& code, std::int64_t value);

  BitModel zero_;
  BitModel negative_;
  std::array<BitModel, kLengths> longer_;
  std::array<std::array<BitModel, 2>, kLengths> digits_;
  BitModel even_;  // digits further down
};

}  // namespace tintree::codec
