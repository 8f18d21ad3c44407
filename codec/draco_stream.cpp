#include "codec/draco_stream.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include "codec/varint.h"

namespace tintree::codec {
namespace {

using Bytes = std::span<const std::byte>;

template <std::size_t n>
constexpr std::array<std::byte, n> bytes_of(const std::array<int, n>& values) {
  std::array<std::byte, n> out{};
  for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<std::byte>(values[i]);
  return out;
}

/// "DRACO", version 2.2, triangle mesh, Edgebreaker, no metadata.
constexpr auto kHeader = bytes_of<11>({'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0});
/// One group of attributes, by vertex: its order of traversal, one attribute, a position of three int32, how they are
/// predicted, wrapped and compressed. Three of the bytes vary.
constexpr auto kAttribute = bytes_of<15>({1, 0xff, 0, 0, 1, 0, 5, 3, 0, 0, 1, 0, 1, 1, 0});
constexpr std::size_t kTraversal = 3;
constexpr std::size_t kPrediction = 11;
constexpr std::size_t kSymbols = 14;
/// Predictions by their number in the form: parallelogram, constrained multi-parallelogram, difference.
constexpr auto kPredictions = bytes_of<3>({1, 4, 0});
/// How connectivity ends in one piece with an outline: its first triangle is at the outline.
constexpr auto kStartAtOutline = bytes_of<3>({0xff, 1, 0x11});
/// The stream's end: least and greatest coordinate, i32.
constexpr std::size_t kRangeBytes = 8;

/// Which of the ways of writing a stream was taken.
struct Form {
  bool by_degree = false;       ///< Bit 0: the traversal.
  bool raw_symbols = false;     ///< Bit 1: the symbols' coding.
  std::uint8_t prediction = 0;  ///< Bits 2 and 3.
  bool plain_disk = false;      ///< Bit 4: standard connectivity of one piece, with no handles.

  std::byte coded() const {
    return static_cast<std::byte>((by_degree ? 1 : 0) | (raw_symbols ? 2 : 0) | prediction << 2 |
                                  (plain_disk ? 16 : 0));
  }
  static std::optional<Form> of(std::byte coded) {
    const auto bits = static_cast<unsigned>(coded);
    const Form form{(bits & 1) != 0, (bits & 2) != 0, static_cast<std::uint8_t>(bits >> 2 & 3), (bits & 16) != 0};
    if (bits > 31 || form.prediction >= kPredictions.size()) return std::nullopt;
    return form;
  }
};

void append(std::vector<std::byte>& out, Bytes bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); }

bool begins_with(Bytes bytes, Bytes start) {
  return bytes.size() >= start.size() && std::ranges::equal(bytes.first(start.size()), start);
}

bool take_byte(Bytes& bytes, int value) {
  if (bytes.empty() || bytes.front() != static_cast<std::byte>(value)) return false;
  bytes = bytes.subspan(1);
  return true;
}

/// The form of a stream whose attribute's description begins `bytes`.
std::optional<Form> form_at(Bytes bytes) {
  if (bytes.size() < kAttribute.size() + kRangeBytes) return std::nullopt;
  for (std::size_t i = 0; i < kAttribute.size(); ++i) {
    if (i != kTraversal && i != kPrediction && i != kSymbols && bytes[i] != kAttribute[i]) return std::nullopt;
  }
  const auto prediction = std::ranges::find(kPredictions, bytes[kPrediction]);
  if (bytes[kTraversal] > std::byte{1} || bytes[kSymbols] > std::byte{1} || prediction == kPredictions.end()) {
    return std::nullopt;
  }
  return Form{bytes[kTraversal] == std::byte{1}, bytes[kSymbols] == std::byte{1},
              static_cast<std::uint8_t>(prediction - kPredictions.begin()), false};
}

/// Connectivity of a plain disk: vertices, triangles, splits and the traversal, the symbols' number being that of the
/// triangles.
struct Disk {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t splits = 0;
  Bytes traversal;

  /// Takes it from the start of a stream.
  static std::optional<Disk> take_plain(Bytes& bytes) {
    Disk disk;
    std::uint64_t symbols = 0;
    std::uint64_t size = 0;
    const bool whole = take_byte(bytes, 0) && take_varint(bytes, disk.vertices) && take_varint(bytes, disk.triangles) &&
                       take_byte(bytes, 0) && take_varint(bytes, symbols) && symbols == disk.triangles &&
                       take_varint(bytes, disk.splits) && take_byte(bytes, 0) && take_varint(bytes, size) &&
                       size <= bytes.size();
    if (!whole) return std::nullopt;
    disk.traversal = bytes.first(size);
    bytes = bytes.subspan(size);
    if (!begins_with(bytes, kStartAtOutline)) return std::nullopt;
    bytes = bytes.subspan(kStartAtOutline.size());
    return disk;
  }
  void put_plain(std::vector<std::byte>& out) const {
    out.push_back({});
    put_varint(out, vertices);
    put_varint(out, triangles);
    out.push_back({});
    put_varint(out, triangles);
    put_varint(out, splits);
    out.push_back({});
    put_varint(out, traversal.size());
    append(out, traversal);
    append(out, kStartAtOutline);
  }

  /// Takes it from the start of a packed stream.
  static std::optional<Disk> take_packed(Bytes& bytes) {
    Disk disk;
    std::uint64_t size = 0;
    const bool whole = take_varint(bytes, disk.vertices) && take_varint(bytes, disk.triangles) &&
                       take_varint(bytes, disk.splits) && take_varint(bytes, size) && size <= bytes.size();
    if (!whole) return std::nullopt;
    disk.traversal = bytes.first(size);
    bytes = bytes.subspan(size);
    return disk;
  }
  void put_packed(std::vector<std::byte>& out) const {
    for (const std::uint64_t v : {vertices, triangles, splits, std::uint64_t{traversal.size()}}) put_varint(out, v);
    append(out, traversal);
  }
};

/// The rest of a stream, from the attribute's description on.
void put_attribute(std::vector<std::byte>& packed, Bytes rest) {
  std::array<std::int32_t, 2> range{};
  std::memcpy(range.data(), rest.last(kRangeBytes).data(), kRangeBytes);
  put_signed_varint(packed, range[0]);
  put_signed_varint(packed, range[1]);
  append(packed, rest.subspan(kAttribute.size(), rest.size() - kAttribute.size() - kRangeBytes));
}

bool take_range(Bytes& packed, std::array<std::int32_t, 2>& range) {
  for (std::int32_t& v : range) {
    std::int64_t wide = 0;
    if (!take_signed_varint(packed, wide) || wide != static_cast<std::int32_t>(wide)) return false;
    v = static_cast<std::int32_t>(wide);
  }
  return true;
}

}  // namespace

bool pack_draco_stream(Bytes stream, std::vector<std::byte>& packed) {
  if (!begins_with(stream, kHeader)) return false;
  stream = stream.subspan(kHeader.size());
  Bytes rest = stream;
  const auto disk = Disk::take_plain(rest);
  auto form = disk ? form_at(rest) : std::nullopt;
  if (form) {
    form->plain_disk = true;
    packed.push_back(form->coded());
    disk->put_packed(packed);
    put_attribute(packed, rest);
    return true;
  }
  // Wherever the description seems to begin, cutting it out and putting it back gives the same bytes.
  for (std::size_t at = 0; at < stream.size(); ++at) {
    rest = stream.subspan(at);
    form = form_at(rest);
    if (!form) continue;
    packed.push_back(form->coded());
    put_varint(packed, at);
    append(packed, stream.first(at));
    put_attribute(packed, rest);
    return true;
  }
  return false;
}

bool unpack_draco_stream(Bytes packed, std::vector<std::byte>& stream) {
  if (packed.empty()) return false;
  const auto form = Form::of(packed.front());
  if (!form) return false;
  packed = packed.subspan(1);
  stream.assign(kHeader.begin(), kHeader.end());
  if (form->plain_disk) {
    const auto disk = Disk::take_packed(packed);
    if (!disk) return false;
    disk->put_plain(stream);
  } else {
    std::uint64_t size = 0;
    if (!take_varint(packed, size) || size > packed.size()) return false;
    append(stream, packed.first(size));
    packed = packed.subspan(size);
  }
  auto attribute = kAttribute;
  attribute[kTraversal] = std::byte{form->by_degree};
  attribute[kPrediction] = kPredictions[form->prediction];
  attribute[kSymbols] = std::byte{form->raw_symbols};
  append(stream, attribute);
  std::array<std::int32_t, 2> range{};
  if (!take_range(packed, range)) return false;
  append(stream, packed);
  append(stream, std::as_bytes(std::span(range)));
  return true;
}

}  // namespace tintree::codec
