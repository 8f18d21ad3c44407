#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tintree::codec {

/// LEB128: 7 bits a byte, low bits first, the high bit set on all but the last byte.
inline void put_varint(std::vector<std::byte>& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::byte>(value | 0x80));
  out.push_back(static_cast<std::byte>(value));
}

/// Reads one and drops it from `bytes`; false when it is cut short or longer than 10 bytes.
inline bool take_varint(std::span<const std::byte>& bytes, std::uint64_t& value) {
  value = 0;
  for (int shift = 0; shift < 64 && !bytes.empty(); shift += 7) {
    const auto b = static_cast<std::uint64_t>(bytes.front());
    bytes = bytes.subspan(1);
    value |= (b & 0x7f) << shift;
    if (b < 0x80) return true;
  }
  return false;
}

/// Signed numbers, those near 0 in few bytes: 0, -1, 1, -2, ... are 0, 1, 2, 3, ...
inline void put_signed_varint(std::vector<std::byte>& out, std::int64_t value) {
  put_varint(out, (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63));
}

inline bool take_signed_varint(std::span<const std::byte>& bytes, std::int64_t& value) {
  std::uint64_t bits = 0;
  if (!take_varint(bytes, bits)) return false;
  value = static_cast<std::int64_t>(bits >> 1) ^ -static_cast<std::int64_t>(bits & 1);
  return true;
}

}  // namespace tintree::codec
