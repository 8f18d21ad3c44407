#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <vector>

#include <charls/charls.h>

#include "tests/bench/rivals/coded_size.h"
#include "tests/bench/rivals/cpu_clock.h"

namespace tintree::bench {
namespace {

constexpr int kMaxNear = 255;

}  // namespace

Expected<CodedRaster> jpegls(const HeightGrid& grid, int error_m) try {
  const int near = error_m <= kMaxNear ? error_m : 0;
  const int step = error_m <= kMaxNear ? 1 : 2 * error_m + 1;
  const auto lowest = static_cast<int>(*std::ranges::min_element(grid.heights_m));
  std::vector<std::uint16_t> samples;
  samples.reserve(grid.heights_m.size());
  for (const double h : grid.heights_m) {
    samples.push_back(static_cast<std::uint16_t>((static_cast<int>(h) - lowest + step / 2) / step));
  }

  const CpuClock clock;
  charls::jpegls_encoder encoder;
  encoder.frame_info({static_cast<std::uint32_t>(grid.columns), static_cast<std::uint32_t>(grid.rows), 16, 1})
      .near_lossless(near);
  std::vector<std::uint8_t> coded(encoder.estimated_destination_size());
  encoder.destination(coded);
  coded.resize(encoder.encode(samples));
  CodedRaster out;
  out.bytes = coded.size();
  out.seconds = clock.seconds();

  std::vector<std::uint16_t> decoded(samples.size());
  out.decode_seconds = least_seconds([&] { charls::jpegls_decoder(coded, true).decode(decoded); });
  double squares = 0;
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    const double distance = std::abs(static_cast<double>(decoded[i]) * step + lowest - grid.heights_m[i]);
    out.max_error_m = std::max(out.max_error_m, distance);
    squares += distance * distance;
  }
  out.rms_m = std::sqrt(squares / static_cast<double>(decoded.size()));
  return out;
} catch (const std::exception& e) {  // CharLS reports by exceptions
  return fail(ErrorCode::kBadData, e.what(), "JPEG-LS");
}

}  // namespace tintree::bench
