#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace tintree::codec {

/// What method `scalar` quantises heights with.
enum class QuantizerKind : std::uint8_t { kUniform, kLloydMax };

/// By its name on the command line and in the manifest, "uniform" or "lloyd-max".
inline QuantizerKind quantizer_named(std::string_view name) {
  return name == "lloyd-max" ? QuantizerKind::kLloydMax : QuantizerKind::kUniform;
}

/// How often a height occurs, or how much it counts.
struct HeightWeight {
  double height_m = 0;
  double weight = 0;  ///< Positive.
};

/// An N-level scalar quantiser (Fowler et al., section 2): its reproduction heights, rising. A height's index is that
/// of the nearest one, of two the lower.
struct Quantizer {
  std::vector<double> values_m;

  std::size_t index(double height_m) const;
  double value(double height_m) const { return values_m[index(height_m)]; }
};

/// What a quantiser does to a set of heights.
struct Distortion {
  double mean_square = 0;  ///< m^2.
  double max_m = 0;
};
Distortion distortion(const Quantizer& quantizer, std::span<const HeightWeight> heights);

/// Peak signal-to-noise ratio in decibels (section 5) of heights that span `range_m`; infinite without distortion.
double psnr_db(double range_m, double mean_square);

/// Equations 3 and 4: `levels` (1 or more) equal intervals between the heights, reproduced by their middles.
Quantizer uniform_quantizer(double low_m, double high_m, std::size_t levels);

/// How a Lloyd-Max design went.
struct LloydMaxDesign {
  Quantizer quantizer;
  int iterations = 0;      ///< 0 where every height has a level of its own.
  bool converged = false;  ///< False: it was cut short.
};

/// Section 2.1: the quantiser of least mean square error, as far as Lloyd's iteration finds it: every level moves to
/// the mean of the heights that are nearest to it, until the distortion falls by less than 1e-7 of itself a round, or
/// `most_iterations` are done; it never rises. Levels begin where a fine quantiser's would lie, at the density's cube
/// root (Panter and Dite 1951); one that gets no height starts anew at the height that has most of the distortion.
/// Of heights fewer than levels each gets its own. `heights`: rising, each once, at least one. Cost: about 5 ns a
/// height and iteration.
LloydMaxDesign lloyd_max_quantizer(std::span<const HeightWeight> heights, std::size_t levels,
                                   int most_iterations = 500);

}  // namespace tintree::codec
