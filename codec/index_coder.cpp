#include "codec/index_coder.h"

#include <algorithm>
#include <numeric>

#include "codec/bit_pack.h"
#include "codec/tile_mesh.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

enum Kind : std::uint8_t { kUniform = 0, kTable = 1 };

/// Of one level too an index takes a bit, so that a payload's length bounds what a reader allocates.
constexpr std::uint64_t kLeastLevels = 2;

/// Calls `index(i)` for every place in turn and packs what it returns.
template <typename Index>
void put_indices(std::vector<std::byte>& out, std::size_t count, std::uint64_t levels, const Index& index) {
  const DigitBlock block(levels);
  BitWriter bits(out);
  for (std::size_t i = 0; i < count;) {
    std::uint64_t number = 0;
    std::uint64_t power = 1;
    for (int d = 0; d < block.digits && i < count; ++d, ++i, power *= levels) number += power * index(i);
    bits.put(number, block.bits);
  }
  bits.finish();
}

template <typename Place>
bool take_indices(std::span<const std::byte> bytes, std::size_t count, std::uint64_t levels, const Place& place) {
  const DigitBlock block(levels);
  const auto digits = static_cast<std::size_t>(block.digits);
  const std::size_t blocks = (count + digits - 1) / digits;
  if (bytes.size() != (blocks * static_cast<std::size_t>(block.bits) + 7) / 8) return false;
  BitReader bits(bytes);
  for (std::size_t i = 0; i < count;) {
    std::uint64_t number = bits.take(block.bits);
    for (std::size_t d = 0; d < digits && i < count; ++d, ++i, number /= levels) place(i, number % levels);
    if (number != 0) return false;
  }
  return true;
}

void put_uniform(std::vector<std::byte>& out, std::span<const std::int32_t> heights, std::int32_t low,
                 std::int32_t step, std::uint64_t levels) {
  out.push_back(static_cast<std::byte>(kUniform));
  put_varint(out, static_cast<std::uint64_t>(low));
  put_varint(out, static_cast<std::uint64_t>(step));
  put_varint(out, levels);
  put_indices(out, heights.size(), levels,
              [&](std::size_t i) { return static_cast<std::uint64_t>((heights[i] - low) / step); });
}

void put_table(std::vector<std::byte>& out, std::span<const std::int32_t> heights,
               const std::vector<std::int32_t>& table) {
  out.push_back(static_cast<std::byte>(kTable));
  put_varint(out, table.size());
  std::int32_t last = 0;
  for (const std::int32_t height : table) {
    put_varint(out, static_cast<std::uint64_t>(height - last));
    last = height;
  }
  put_indices(out, heights.size(), table.size(), [&](std::size_t i) {
    return static_cast<std::uint64_t>(std::ranges::lower_bound(table, heights[i]) - table.begin());
  });
}

std::optional<HeightQuantizer> take_uniform(std::span<const std::byte> bytes, std::span<std::int32_t> heights) {
  std::uint64_t low = 0;
  std::uint64_t step = 0;
  std::uint64_t levels = 0;
  constexpr auto kMost = static_cast<std::uint64_t>(kMaxHeightAddress);
  if (!take_varint(bytes, low) || !take_varint(bytes, step) || !take_varint(bytes, levels)) return std::nullopt;
  if (low > kMost || step < 1 || step > kMost || levels < kLeastLevels || levels > kMost + 2) return std::nullopt;
  bool inside = true;
  const bool taken = take_indices(bytes, heights.size(), levels, [&](std::size_t i, std::uint64_t index) {
    const std::uint64_t height = low + index * step;
    inside = inside && height <= kMost;
    heights[i] = static_cast<std::int32_t>(height & kMost);
  });
  if (!taken || !inside) return std::nullopt;
  return HeightQuantizer{static_cast<std::int32_t>(low), static_cast<std::int32_t>(step)};
}

std::optional<HeightQuantizer> take_table(std::span<const std::byte> bytes, std::span<std::int32_t> heights) {
  std::uint64_t count = 0;
  // An entry takes a byte at least.
  if (!take_varint(bytes, count) || count < kLeastLevels || count > bytes.size()) return std::nullopt;
  HeightQuantizer out;
  std::vector<std::int32_t>& table = out.table;
  std::uint64_t height = 0;
  for (std::uint64_t k = 0; k < count; ++k) {
    std::uint64_t step = 0;
    if (!take_varint(bytes, step) || step > static_cast<std::uint64_t>(kMaxHeightAddress)) return std::nullopt;
    height += step;
    if (height > static_cast<std::uint64_t>(kMaxHeightAddress)) return std::nullopt;
    table.push_back(static_cast<std::int32_t>(height));
  }
  const bool taken = take_indices(bytes, heights.size(), count, [&](std::size_t i, std::uint64_t index) {
    heights[i] = table[static_cast<std::size_t>(index)];
  });
  if (!taken) return std::nullopt;
  return out;
}

}  // namespace

void put_quantized(std::vector<std::byte>& out, std::span<const std::int32_t> heights) {
  if (heights.empty()) return;
  std::vector<std::int32_t> table(heights.begin(), heights.end());
  std::ranges::sort(table);
  table.erase(std::unique(table.begin(), table.end()), table.end());
  std::int32_t step = 0;
  for (const std::int32_t height : table) step = std::gcd(step, height - table.front());
  step = std::max(step, 1);
  const auto span = static_cast<std::uint64_t>((table.back() - table.front()) / step);
  std::vector<std::byte> uniform;
  put_uniform(uniform, heights, table.front(), step, std::max(span + 1, kLeastLevels));
  if (table.size() >= kLeastLevels && table.size() <= span) {
    std::vector<std::byte> listed;
    put_table(listed, heights, table);
    if (listed.size() < uniform.size()) uniform = std::move(listed);
  }
  out.insert(out.end(), uniform.begin(), uniform.end());
}

std::optional<HeightQuantizer> take_quantized(std::span<const std::byte> bytes, std::span<std::int32_t> heights) {
  if (bytes.empty()) return std::nullopt;
  const auto kind = static_cast<std::uint8_t>(bytes.front());
  if (kind == kUniform) return take_uniform(bytes.subspan(1), heights);
  return kind == kTable ? take_table(bytes.subspan(1), heights) : std::nullopt;
}

}  // namespace tintree::codec
