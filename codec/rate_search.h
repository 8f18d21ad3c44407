#pragma once

#include "codec/error.h"
#include "codec/patch.h"
#include "codec/wavelet_patch.h"

namespace tintree::codec {

/// Codes a patch as the paper does (Yusov & Turlapov 2008, section 3.4.1, figure 7): its residuals quantised over their
/// range and coded by JPEG 2000 at the lowest rate found at which the criterion holds.
Expected<EncodedPatch> search_rate(const Patch& target, const Patch& prediction, const PatchSpec& spec);

}  // namespace tintree::codec
