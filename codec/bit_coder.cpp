#include "codec/bit_coder.h"

#include <utility>

namespace tintree::codec {
namespace {

constexpr std::uint32_t kNormal = 1U << 24;  // the range never stays below

}  // namespace

void BitEncoder::put(BitModel& model, bool bit) {
  const std::uint32_t split = (range_ >> BitModel::kBits) * model.zero();
  if (bit) {
    low_ += split;
    range_ -= split;
  } else {
    range_ = split;
  }
  model.learn(bit);
  while (range_ < kNormal) {
    range_ <<= 8;
    shift();
  }
}

/// Moves the top byte out, once no carry can reach it any more.
void BitEncoder::shift() {
  if (low_ < 0xff000000U || low_ > 0xffffffffU) {
    const auto carry = static_cast<std::uint8_t>(low_ >> 32);
    if (begun_) bytes_.push_back(static_cast<std::byte>(cache_ + carry));
    for (; pending_ > 0; --pending_) bytes_.push_back(static_cast<std::byte>(0xff + carry));
    begun_ = true;
    cache_ = static_cast<std::uint8_t>(low_ >> 24);
  } else {
    ++pending_;
  }
  low_ = (low_ & 0x00ffffffU) << 8;
}

std::vector<std::byte> BitEncoder::finish() {
  for (int i = 0; i < 5; ++i) shift();
  for (std::size_t i = 0; i < kBitCoderSpare && !bytes_.empty() && bytes_.back() == std::byte{0}; ++i)
    bytes_.pop_back();
  return std::move(bytes_);
}

BitDecoder::BitDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
  for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next();
}

std::uint8_t BitDecoder::next() {
  if (bytes_.empty()) {
    ++missing_;
    return 0;
  }
  const auto byte = static_cast<std::uint8_t>(bytes_.front());
  bytes_ = bytes_.subspan(1);
  return byte;
}

bool BitDecoder::get(BitModel& model) {
  const std::uint32_t split = (range_ >> BitModel::kBits) * model.zero();
  const bool bit = code_ >= split;
  if (bit) {
    code_ -= split;
    range_ -= split;
  } else {
    range_ = split;
  }
  model.learn(bit);
  while (range_ < kNormal) {
    range_ <<= 8;
    code_ = code_ << 8 | next();
  }
  return bit;
}

/// One walk for both ways: `code(model, bit)` puts the bit, or gets one and ignores what is passed.
template <typename Code>
std::int64_t IntegerModel::visit(const Code& code, std::int64_t value) {
  if (!code(zero_, value != 0)) return 0;
  const bool negative = code(negative_, value < 0);
  const std::uint64_t size = value < 0 ? -static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  std::size_t length = 1;
  while (length < kLengths && code(longer_[length], length < 64 && (size >> length) != 0)) ++length;
  std::uint64_t out = 1;
  for (std::size_t digit = length - 1; digit-- > 0;) {
    const std::size_t depth = length - 2 - digit;
    BitModel& model = depth == 0 ? digits_[length - 1][0] : depth == 1 ? digits_[length - 1][out & 1] : even_;
    out = out << 1 | static_cast<std::uint64_t>(code(model, (size >> digit & 1) != 0));
  }
  return negative ? -static_cast<std::int64_t>(out) : static_cast<std::int64_t>(out);
}

void IntegerModel::put(BitEncoder& coder, std::int64_t value) {
  visit(
      [&](BitModel& model, bool bit) {
        coder.put(model, bit);
        return bit;
      },
      value);
}

std::int64_t IntegerModel::get(BitDecoder& coder) {
  return visit([&](BitModel& model, bool) { return coder.get(model); }, 0);
}

}  // namespace tintree::codec
