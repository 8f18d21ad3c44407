#include "codec/residual_plane.h"

#include <cstdlib>
#include <string>
#include <utility>

#include "codec/varint.h"

namespace tintree::codec {
namespace {

tl::unexpected<Error> damaged(const char* what) {
  return fail(ErrorCode::kBadData, std::string("the payload's ") + what);
}

}  // namespace

Patch dequantized(const Patch& prediction, const Quantizer& quantizer, const Plane& plane) {
  Patch out = prediction;
  for (std::size_t i = 0; i < out.heights.size(); ++i) {
    out.heights[i] += quantizer.low + (plane.samples.empty() ? 0 : quantizer.step * plane.samples[i]);
  }
  return out;
}

std::vector<std::byte> residual_bytes(const Quantizer& quantizer, std::span<const std::byte> stream) {
  std::vector<std::byte> out;
  put_varint(out, static_cast<std::uint64_t>(quantizer.bits));
  put_signed_varint(out, quantizer.low);
  if (quantizer.bits == 0) return out;
  put_varint(out, static_cast<std::uint64_t>(quantizer.step));
  put_varint(out, stream.size());
  out.insert(out.end(), stream.begin(), stream.end());
  return out;
}

Expected<Patch> take_residuals(std::span<const std::byte>& bytes, int bits, const Patch& prediction) {
  std::uint64_t step = 1;
  std::uint64_t size = 0;
  Quantizer quantizer{.bits = bits};
  if (!take_signed_varint(bytes, quantizer.low)) return damaged("patch ends early");
  Plane plane;
  if (bits > 0) {
    if (!take_varint(bytes, step) || !take_varint(bytes, size) || size > bytes.size())
      return damaged("plane ends early");
    auto decoded = decode_plane(bytes.first(static_cast<std::size_t>(size)), prediction.side, prediction.side, bits);
    if (!decoded) return tl::unexpected(decoded.error());
    plane = std::move(*decoded);
    bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
  constexpr std::int64_t kFarthest = kFarthestHeight;
  if (quantizer.low < -kFarthest || quantizer.low > kFarthest || step == 0 ||
      step > static_cast<std::uint64_t>(kFarthest >> kMostBits)) {
    return damaged("quantiser is out of range");
  }
  quantizer.step = static_cast<std::int64_t>(step);
  return dequantized(prediction, quantizer, plane);
}

}  // namespace tintree::codec
