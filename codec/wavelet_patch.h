#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "codec/error.h"
#include "codec/patch.h"

namespace tintree::codec {

/// When a patch is coded well enough.
enum class PatchCriterion : std::uint8_t {
  kMax,  ///< No sample is further off than the bound,
  kRms,  ///< or the root of their mean square is not.
};

/// By its name on the command line and in the manifest, "max" or "rms".
inline PatchCriterion criterion_named(std::string_view name) {
  return name == "max" ? PatchCriterion::kMax : PatchCriterion::kRms;
}

struct PatchSpec {
  PatchCriterion criterion = PatchCriterion::kMax;
  std::int64_t bound = 1;  ///< In units of height; 0 or more.
  /// Levels of the quantiser over the residuals' range, 2^bits; more, up to 16, where the bound needs them.
  int bits = 8;
  /// Takes the first rate that holds, close to the bound and mostly after one or two encodes. Where triangles
  /// are coded against the patch they cost about as much less as it costs more.
  bool quick = false;
  /// By put_lifted() instead of JPEG 2000, in 0.3 to 0.7 of its bytes; kMax only.
  bool lifted = false;
  /// The quantised residuals are coded without loss; the bound counts for nothing.
  bool lossless = false;
};

struct EncodedPatch {
  std::vector<std::byte> bytes;
  Patch reconstruction;  ///< What decode_patch() makes of them.
  int encodes = 0;       ///< Of JPEG 2000.
};

/// Codes `target` (kNoHeight: any height will do) against the prediction, so that the criterion holds.
Expected<EncodedPatch> encode_patch(const Patch& target, const Patch& prediction, const PatchSpec& spec);

/// Reads one and drops it from `bytes`. kBadData for what is no patch of the prediction's size.
Expected<Patch> decode_patch(std::span<const std::byte>& bytes, const Patch& prediction);

}  // namespace tintree::codec
