#include "codec/wavelet_patch.h"

#include <algorithm>

#include "codec/lifted_patch.h"
#include "codec/rate_search.h"
#include "codec/residual_plane.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

/// In the place of a number of bits.
constexpr std::uint64_t kLifted = 32;

EncodedPatch lifted(const Patch& target, const Patch& prediction, std::int64_t bound) {
  EncodedPatch out;
  put_varint(out.bytes, kLifted);
  out.reconstruction = put_lifted(out.bytes, target, prediction, bound);
  return out;
}

}  // namespace

Expected<EncodedPatch> encode_patch(const Patch& target, const Patch& prediction, const PatchSpec& spec) {
  if (spec.lifted) return lifted(target, prediction, spec.bound);
  return search_rate(target, prediction, spec);
}

Expected<Patch> decode_patch(std::span<const std::byte>& bytes, const Patch& prediction) {
  std::uint64_t kind = 0;
  if (!take_varint(bytes, kind)) return fail(ErrorCode::kBadData, "the payload's patch ends early");
  if (kind == kLifted) return take_lifted(bytes, prediction);
  if (kind > kMostBits) return fail(ErrorCode::kBadData, "the payload's patch is of no known kind");
  auto out = take_residuals(bytes, static_cast<int>(kind), prediction);
  if (!out) return out;
  const bool near =
      std::ranges::all_of(out->heights, [](std::int64_t h) { return h >= -kFarthestHeight && h <= kFarthestHeight; });
  return near ? std::move(out) : fail(ErrorCode::kBadData, "the payload's heights are out of range");
}

}  // namespace tintree::codec
