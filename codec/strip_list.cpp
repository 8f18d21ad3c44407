#include "codec/strip_list.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "codec/target_clones.h"

namespace tintree::codec {
namespace {

/// What the next entering edge is after a triangle: an index of direction + 8 * size, changed by type and winding.
/// Sizes wrap at 32, so that no payload leads outside the tables.
constexpr std::uint32_t kEdges = 256;

/// How far v3 lies from the vertex that the path turns round, as a difference of words.
std::array<std::uint32_t, kEdges> make_offsets(const StripWords& words) {
  std::array<std::uint32_t, kEdges> out{};
  for (std::uint32_t e = 0; e < kEdges; ++e) {
    const std::uint32_t length = 1U << (e >> 3);
    const auto dx = static_cast<std::uint32_t>(kStripX[e & 7]);
    const auto dy = static_cast<std::uint32_t>(kStripY[e & 7]);
    out[e] = dx * length + (dy * length << words.xy_bits);
  }
  return out;
}

/// An edge after one of the 4 types (3 is none, and stands still) and 2 windings: index edge & 1, winding, type. What
/// is to be added to the direction and, times 8, to the size.
struct Turn {
  std::uint8_t direction;
  std::uint8_t size;
};
constexpr std::array<Turn, 16> make_turns() {
  std::array<Turn, 16> out{};
  for (std::uint32_t i = 0; i < 16; ++i) {
    if ((i & 3) == 3) continue;
    const StripEdge before{static_cast<int>(i >> 3), 1};
    const StripEdge after = before.next(static_cast<StripType>(i & 3), (i & 4) != 0);
    out[i] = {static_cast<std::uint8_t>((after.direction - before.direction) & 7),
              static_cast<std::uint8_t>((after.size - before.size) * 8)};
  }
  return out;
}
constexpr std::array<Turn, 16> kTurns = make_turns();

/// Where the path stands before a triangle.
struct Place {
  std::uint32_t v1, v2;  // words
  std::uint32_t edge;
  std::uint32_t right;  // 1: winds right but for type B
};

/// What all steps need.
struct Tables {
  StripWords words;
  std::array<std::uint32_t, kEdges> offsets;
  std::uint32_t xy_mask;
  std::uint32_t missing;

  explicit Tables(const StripPayload& p)
      : words(p), offsets(make_offsets(words)), xy_mask((1U << 2 * words.xy_bits) - 1), missing(p.missing()) {}
};

/// One triangle: v3, and the path past it.
inline std::uint32_t step(const Tables& tables, std::uint32_t entry, Place& at) {
  const std::uint32_t type = entry & 3;
  const std::uint32_t left = (at.right ^ static_cast<std::uint32_t>(type == 1) ^ 1) & 1;
  const Turn turn = kTurns[(at.edge & 1) << 3 | left << 2 | type];
  at.edge = ((at.edge & ~7U) + turn.size) % kEdges | ((at.edge + turn.direction) & 7);
  at.right = left ^ static_cast<std::uint32_t>(type == 2) ^ 1;
  const std::uint32_t offset = tables.offsets[at.edge];
  const std::uint32_t xy = left != 0 ? at.v1 + offset : at.v2 - offset;
  const std::uint32_t v3 = (xy & tables.xy_mask) | (entry >> 2) << 2 * tables.words.xy_bits;
  at.v1 = left != 0 ? at.v1 : v3;
  at.v2 = left != 0 ? v3 : at.v2;
  return v3;
}

/// The begin of a sub-strip. The heights of its edge lie in entries before it.
Place start(const Tables& tables, const StripPayload& p, std::uint32_t sub_strip) {
  const StripHeader h = p.header(sub_strip);
  const std::size_t entry = std::size_t{sub_strip} * kSubStrip + 2;
  const std::uint32_t back = std::min<std::uint32_t>(h.back, static_cast<std::uint32_t>(entry));
  const std::uint32_t near = p.entry(entry - 1) >> 2;
  const std::uint32_t far = p.entry(entry - back) >> 2;
  Place at{};
  at.edge = static_cast<std::uint32_t>(h.edge.direction) | static_cast<std::uint32_t>(h.edge.size % 32) << 3;
  const std::uint32_t v1 = tables.words.pack(h.x, h.y, 0);
  at.v1 = v1 | (h.back_is_v1 ? far : near) << 2 * tables.words.xy_bits;
  at.v2 = ((v1 + tables.offsets[at.edge]) & tables.xy_mask) | (h.back_is_v1 ? near : far) << 2 * tables.words.xy_bits;
  const auto type = static_cast<StripType>(p.entry(entry) & 3);
  at.right = h.left == (type == StripType::kB) ? 1 : 0;
  return at;
}

/// Zeros for triangles with a missing corner.
void drop_missing(const Tables& tables, std::span<std::uint32_t> words) {
  for (std::size_t i = 0; i + 3 <= words.size(); i += 3) {
    const auto missing = [&](std::size_t k) { return tables.words.height(words[i + k]) == tables.missing; };
    if (missing(0) || missing(1) || missing(2)) words[i] = words[i + 1] = words[i + 2] = 0;
  }
}

constexpr std::size_t kLanes = 8;

/// A coordinate of all directions, and 1, in 2 bits each.
constexpr std::uint32_t packed(const std::array<int, 8>& ways) {
  std::uint32_t out = 0;
  for (std::size_t d = 0; d < ways.size(); ++d) out |= static_cast<std::uint32_t>(ways[d] + 1) << 2 * d;
  return out;
}
constexpr std::uint32_t kWaysX = packed(kStripX);
constexpr std::uint32_t kWaysY = packed(kStripY);

/// A number of each of eight sub-strips.
using Lanes = std::uint32_t __attribute__((vector_size(4 * kLanes)));

/// step() for eight whole sub-strips from `strip` on, side by side, whose entries end at least 4 bytes before the
/// payload's.
TINTREE_CLONES void expand_lanes(const Tables& tables, const StripPayload& payload, std::uint32_t strip,
                                 std::uint32_t* out) {
  const std::size_t bits = static_cast<std::size_t>(payload.height_bits) + 2;
  const std::uint32_t mask = (1U << bits) - 1;
  const int height_at = 2 * tables.words.xy_bits;
  Lanes v1;
  Lanes v2;
  Lanes edge;
  Lanes right;
  for (std::size_t k = 0; k < kLanes; ++k) {
    const Place p = start(tables, payload, strip + static_cast<std::uint32_t>(k));
    v1[k] = p.v1;
    v2[k] = p.v2;
    edge[k] = p.edge;
    right[k] = p.right;
  }
  std::array<Lanes, 3 * kSubStrip> corners;
  for (std::size_t i = 0; i < kSubStrip; ++i) {
    // The sub-strips' entries lie a whole number of bytes apart, and an entry has up to 25 bits.
    const std::size_t position = (std::size_t{strip} * kSubStrip + i + 2) * bits;
    const std::byte* from = payload.entries.data() + (position >> 3);
    const auto load = [&](std::size_t k) {
      std::uint32_t word = 0;
      std::memcpy(&word, from + k * (kSubStrip / 8) * bits, 4);
      return word;
    };
    const Lanes words{load(0), load(1), load(2), load(3), load(4), load(5), load(6), load(7)};
    const Lanes entries = (words >> static_cast<std::uint32_t>(position & 7)) & mask;
    const Lanes type = entries & 3;
    const Lanes is_b = type & 1;
    const Lanes is_c = type >> 1;
    const Lanes left = right ^ is_b ^ 1;
    const Lanes odd = edge & 1;
    const Lanes turn = 2 - (is_b | is_c);
    const Lanes leftward = 0 - left;  // all bits
    const Lanes size = (edge & ~7U) + 8 * (is_b & odd) - 8 * (is_c & (odd ^ 1));
    edge = (size & (kEdges - 8)) | ((edge + ((turn ^ ~leftward) - ~leftward)) & 7);
    const Lanes place = 2 * (edge & 7);
    const Lanes way = ((kWaysX >> place) & 3) - 1 + (((kWaysY >> place) & 3) - 1) * (1U << tables.words.xy_bits);
    const Lanes offset = way << (edge >> 3);
    const Lanes xy = ((v1 + offset) & leftward) | ((v2 - offset) & ~leftward);
    const Lanes v3 = (xy & tables.xy_mask) | (entries >> 2) << height_at;
    corners[3 * i] = v1;
    corners[3 * i + 1] = v2;
    corners[3 * i + 2] = v3;
    right = left ^ is_c ^ 1;
    v1 = (v1 & leftward) | (v3 & ~leftward);
    v2 = (v3 & leftward) | (v2 & ~leftward);
  }
  for (std::size_t k = 0; k < kLanes; ++k) {
    for (std::size_t i = 0; i < corners.size(); ++i) *out++ = corners[i][k];
  }
}

}  // namespace

void follow_strip(const StripPayload& payload, std::span<std::uint32_t> words) {
  const Tables tables(payload);
  Place at = start(tables, payload, 0);
  const std::size_t bits = static_cast<std::size_t>(payload.height_bits) + 2;
  const std::uint32_t mask = (1U << bits) - 1;
  const std::byte* entries = payload.entries.data();
  std::uint32_t* out = words.data();
  std::size_t position = 2 * bits;
  // As long as 8 bytes can be loaded.
  const std::size_t safe = payload.entries.size() < 8
                               ? 0
                               : std::min<std::size_t>(payload.triangles, (8 * (payload.entries.size() - 8)) / bits);
  const std::size_t whole = safe < 2 ? 0 : safe - 2;
  for (std::size_t i = 0; i < whole; ++i, position += bits, out += 3) {
    std::uint64_t word = 0;
    std::memcpy(&word, entries + (position >> 3), 8);
    out[0] = at.v1;
    out[1] = at.v2;
    out[2] = step(tables, static_cast<std::uint32_t>(word >> (position & 7)) & mask, at);
  }
  for (std::size_t i = whole; i < payload.triangles; ++i, out += 3) {
    out[0] = at.v1;
    out[1] = at.v2;
    out[2] = step(tables, payload.entry(i + 2), at);
  }
  if (payload.holes) drop_missing(tables, words);
}

void expand_sub_strips(const StripPayload& payload, std::span<std::uint32_t> words) {
  const Tables tables(payload);
  const std::size_t bits = static_cast<std::size_t>(payload.height_bits) + 2;
  std::uint32_t strip = 0;
  for (; strip + kLanes < payload.sub_strips(); strip += kLanes) {
    if (((std::size_t{strip} + kLanes) * kSubStrip + 2) * bits / 8 + 4 > payload.entries.size()) break;
    expand_lanes(tables, payload, strip, words.data() + 3 * std::size_t{strip} * kSubStrip);
  }
  for (; strip < payload.sub_strips(); ++strip) {
    Place at = start(tables, payload, strip);
    const std::size_t end = std::min<std::size_t>(payload.triangles, (std::size_t{strip} + 1) * kSubStrip);
    for (std::size_t i = std::size_t{strip} * kSubStrip; i < end; ++i) {
      words[3 * i] = at.v1;
      words[3 * i + 1] = at.v2;
      words[3 * i + 2] = step(tables, payload.entry(i + 2), at);
    }
  }
  if (payload.holes) drop_missing(tables, words);
}

std::vector<std::uint32_t> strip_skirts(const StripPayload& payload, std::span<const std::uint32_t> words,
                                        const StripBorders& borders) {
  const StripWords format(payload);
  std::vector<std::uint32_t> out;
  const auto on_border = [&](std::uint32_t a, std::uint32_t b) {
    const auto x = static_cast<std::int32_t>(format.x(a));
    const auto y = static_cast<std::int32_t>(format.y(a));
    return (format.x(a) == format.x(b) && (x == borders[0] || x == borders[2])) ||
           (format.y(a) == format.y(b) && (y == borders[1] || y == borders[3]));
  };
  for (std::size_t i = 0; i + 3 <= words.size(); i += 3) {
    if (words[i] == words[i + 1]) continue;  // missing
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = words[i + k];
      const std::uint32_t b = words[i + (k + 1) % 3];
      if (!on_border(a, b)) continue;
      const std::uint32_t foot_a = a | StripWords::kFoot;
      const std::uint32_t foot_b = b | StripWords::kFoot;
      out.insert(out.end(), {b, a, foot_a, b, foot_a, foot_b});
    }
  }
  return out;
}

}  // namespace tintree::codec
