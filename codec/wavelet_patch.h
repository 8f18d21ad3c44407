#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "codec/error.h"

namespace tintree::codec {

/// Samples that a patch holds beyond its own on every side (Yusov & Turlapov 2008, formulas 2 and 3).
inline constexpr int kPatchMargin = 2;
/// A layer's height where there is no surface.
inline constexpr std::int64_t kNoHeight = std::numeric_limits<std::int64_t>::min();

/// A square of one layer of the pyramid: n x n samples and their margin, row-major, north row first, as whole numbers
/// of some unit of height. The samples of the next coarser layer lie in the middles of four of these.
struct Patch {
  int side = 0;  ///< n + 2 kPatchMargin
  std::vector<std::int64_t> heights;

  Patch() = default;
  Patch(int s, std::int64_t height)
      : side(s), heights(static_cast<std::size_t>(s) * static_cast<std::size_t>(s), height) {}
  std::int64_t& at(int x, int y) { return heights[index(x, y)]; }
  std::int64_t at(int x, int y) const { return heights[index(x, y)]; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x);
  }
};

/// A child's patch by bilinear interpolation of its parent's (section 3.4): what a graphics card samples. The parent
/// has no missing heights, and its unit is `units` of the child's.
Patch predict_patch(const Patch& parent, int quadrant, int units);

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
  /// kMax only: the few samples that are still too far off are corrected one by one, instead of a higher rate for
  /// all (Yea & Pearlman 2004).
  bool corrected = false;
  /// The quantised residuals are coded without loss; the bound counts for nothing.
  bool lossless = false;
};

struct EncodedPatch {
  std::vector<std::byte> bytes;
  Patch reconstruction;  ///< What decode_patch() makes of them.
  int encodes = 0;       ///< Of JPEG 2000.
};

/// Codes the residuals of `target` (kNoHeight: any height will do) against the prediction: quantised over their range
/// and coded by JPEG 2000 at the lowest rate found at which the criterion holds (section 3.4.1, figure 7).
Expected<EncodedPatch> encode_patch(const Patch& target, const Patch& prediction, const PatchSpec& spec);

/// Reads one and drops it from `bytes`. kBadData for what is no patch of the prediction's size.
Expected<Patch> decode_patch(std::span<const std::byte>& bytes, const Patch& prediction);

}  // namespace tintree::codec
