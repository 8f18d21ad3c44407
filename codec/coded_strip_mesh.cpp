#include "codec/coded_strip_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <memory>
#include <vector>

#include "codec/quick_bit_model.h"
#include "codec/range_coder.h"
#include "codec/strip_follower.h"
#include "codec/strip_packer.h"
#include "codec/strip_source.h"

namespace tintree::codec {
namespace {

constexpr std::size_t kSizes = 24;
constexpr std::uint32_t kUnknown = UINT32_MAX;

/// What is known of types: after the two before, and at an entering edge of this size.
class TypeModels {
 public:
  template <typename Coder>
  StripType code(Coder& coder, int size, StripType type) {
    auto& models = models_[std::min(static_cast<std::size_t>(size), kSizes - 1)][before_];
    // C or not, then A or B.
    StripType got = StripType::kC;
    if (!coder.bit(models[0], type == StripType::kC))
      got = coder.bit(models[1], type == StripType::kB) ? StripType::kB : StripType::kA;
    before_ = before_ % 9 * 3 + static_cast<std::size_t>(got);
    return got;
  }

 private:
  std::array<std::array<std::array<QuickBitModel, 2>, 27>, kSizes> models_;
  std::size_t before_ = 0;
};

/// What is known of heights: by the size of the edge that the path leaves by.
class HeightModels {
 public:
  explicit HeightModels(const StripHead& head) : head_(head) {}

  /// The height of a vertex between the two of an edge; `height` if it is written.
  template <typename Coder>
  std::uint32_t code(Coder& coder, int size, std::uint32_t v1, std::uint32_t v2, std::uint32_t height) {
    if (head_.holes && coder.bit(gone_[v1 == head_.missing() || v2 == head_.missing()], height == head_.missing()))
      return head_.missing();
    const std::uint32_t a = v1 == head_.missing() ? v2 : v1;
    const std::uint32_t b = v2 == head_.missing() ? v1 : v2;
    const std::uint32_t guess = a == head_.missing() ? 0 : (a + b) / 2;
    NumberModelOf<QuickBitModel>& model = models_[std::min(static_cast<std::size_t>(size), kSizes - 1)];
    const std::int64_t off = model.code(coder, std::int64_t{height} - std::int64_t{guess});
    return guess + static_cast<std::uint32_t>(off);
  }

 private:
  StripHead head_;
  std::array<QuickBitModel, 2> gone_;
  std::array<NumberModelOf<QuickBitModel>, kSizes> models_;
};

/// Heights in the order of the path, each vertex's at its first entry; `given` are those to be written, or empty.
template <typename Coder>
bool code_heights(Coder& coder, const StripHead& head, const StripFollower& path, const std::vector<int>& sizes,
                  std::vector<std::uint32_t>& heights) {
  const auto models = std::make_unique<HeightModels>(head);
  std::vector<std::uint32_t> of_vertex(heights.size(), kUnknown);
  const auto one = [&](std::size_t entry, int size, std::uint32_t v1, std::uint32_t v2) {
    std::uint32_t& known = of_vertex[path.vertex(entry)];
    if (known == kUnknown) known = models->code(coder, size, v1, v2, heights[entry]);
    heights[entry] = known;
    return known >> head.height_bits == 0;
  };
  if (!one(0, 0, 0, 0) || !one(1, 0, heights[0], heights[0])) return false;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const auto& corners = path.corners(i);
    if (!one(corners[2], sizes[i], heights[corners[0]], heights[corners[1]])) return false;
  }
  return true;
}

/// A payload taken apart.
struct CodedStrip {
  StripHead head;
  StripFollower path;
  std::vector<StripType> types;
  std::vector<StripHeader> headers{};    // of sub-strips
  std::vector<std::uint32_t> heights{};  // of entries
};

Expected<CodedStrip> read(std::span<const std::byte> bytes) {
  const auto refuse = [] { return fail(ErrorCode::kBadData, "the payload's strip is damaged or cut short"); };
  const auto head = take_strip_head(bytes, kStripCoded);
  if (!head) return tl::unexpected(head.error());
  const StripHeaderLayout layout = StripHeaderLayout::of(head->levels);
  // A triangle has a bit at least.
  if (bytes.size() < layout.bytes || head->triangles / kMostBitsPerByte > bytes.size()) return refuse();
  std::uint64_t packed = 0;
  for (std::size_t i = 0; i < layout.bytes; ++i) packed |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
  RangeDecoder decoder(bytes.subspan(layout.bytes));
  CodedStrip out{*head, StripFollower(*head, layout.unpack(packed)), {}};
  const auto models = std::make_unique<TypeModels>();
  StripWinding winding;
  std::vector<int> sizes;
  for (std::uint32_t i = 0; i < head->triangles; ++i) {
    const StripType type = models->code(decoder, out.path.edge().size, StripType::kA);
    const bool left = winding.next(type);
    if (i % kSubStrip == 0) out.headers.push_back(out.path.header(left));
    if (!out.path.step(type, left)) return refuse();
    out.types.push_back(type);
    sizes.push_back(out.path.edge().size);
  }
  out.heights.resize(head->triangles + std::size_t{2});
  if (!code_heights(decoder, *head, out.path, sizes, out.heights) || !decoder.finished()) return refuse();
  return out;
}

}  // namespace

Expected<std::vector<std::byte>> CodedStripMesh::encode(const TileMesh& mesh) const {
  const auto source = find_strip(mesh);
  if (!source) return tl::unexpected(source.error());
  std::vector<std::byte> out;
  put_strip_head(out, kStripCoded, source->head);
  std::vector<StripStep> steps;
  steps.reserve(source->head.triangles);
  source->walk([&](const StripStep& s) { steps.push_back(s); });
  StripHeader first;
  first.x = static_cast<std::int32_t>(steps[0].v1.x);
  first.y = static_cast<std::int32_t>(steps[0].v1.y);
  first.edge = edge_between(steps[0].v1, steps[0].v2);
  const StripHeaderLayout layout = StripHeaderLayout::of(source->head.levels);
  for (std::size_t i = 0; i < layout.bytes; ++i) out.push_back(static_cast<std::byte>(layout.pack(first) >> (8 * i)));

  RangeEncoder encoder;
  StripFollower path(source->head, first);
  const auto types = std::make_unique<TypeModels>();
  std::vector<int> sizes;
  std::vector<std::uint32_t> heights{source->code(steps[0].v1), source->code(steps[0].v2)};
  for (const StripStep& s : steps) {
    types->code(encoder, path.edge().size, s.type);
    path.step(s.type, s.left);
    sizes.push_back(path.edge().size);
    heights.push_back(source->code(s.v3));
  }
  code_heights(encoder, source->head, path, sizes, heights);
  std::ranges::copy(encoder.finish(0), std::back_inserter(out));
  return out;
}

Expected<TileMesh> CodedStripMesh::decode(std::span<const std::byte> bytes) const {
  const auto strip = read(bytes);
  if (!strip) return tl::unexpected(strip.error());
  return strip->path.mesh(strip->heights);
}

Expected<std::vector<std::byte>> packed_strip(std::span<const std::byte> bytes) {
  if (bytes.empty() || bytes.front() != kStripCoded) return std::vector(bytes.begin(), bytes.end());
  const auto strip = read(bytes);
  if (!strip) return tl::unexpected(strip.error());
  StripPacker packer(strip->head, strip->heights[0], strip->heights[1]);
  for (std::size_t i = 0; i < strip->types.size(); ++i) {
    if (i % kSubStrip == 0) packer.header(strip->headers[i / kSubStrip]);
    packer.entry(strip->types[i], strip->heights[i + 2]);
  }
  return packer.finish();
}

}  // namespace tintree::codec
