#include "apps/audit/report_charts.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace tintree::audit {
namespace {

constexpr std::size_t kBars = 32;
constexpr double kWidth = 288;
constexpr double kHeight = 96;
constexpr double kLeft = 42;  // room for the axis
constexpr double kBottom = 30;

void draw_axes(std::string& out, double most) {
  auto to = std::back_inserter(out);
  for (const int percent : {0, 25, 50, 75, 100}) {
    const double x = kLeft + kWidth * percent / 100;
    fmt::format_to(to, R"(<line class="tick" x1="{0:.1f}" y1="{1}" x2="{0:.1f}" y2="{2}"/>)", x, kHeight, kHeight + 4);
    fmt::format_to(to, R"(<text x="{:.1f}" y="{}" text-anchor="middle">{}{}</text>)", x, kHeight + 16, percent,
                   percent == 100 ? " %" : "");
  }
  fmt::format_to(to, R"(<text x="{}" y="9" text-anchor="end">{:.2g} %</text>)", kLeft - 4, 100 * most);
  fmt::format_to(to, R"(<text x="{}" y="{}" text-anchor="end">0</text>)", kLeft - 4, kHeight);
  fmt::format_to(to, R"(<line class="axis" x1="{0}" y1="{2}" x2="{1}" y2="{2}"/>)", kLeft, kLeft + kWidth, kHeight);
}

}  // namespace

std::string histogram_svg(const LevelReport& level) {
  const std::vector<std::uint64_t> bars = level.histogram.bars(kBars);
  const auto total = static_cast<double>(std::max<std::uint64_t>(level.histogram.total(), 1));
  const double most = std::max(static_cast<double>(std::ranges::max(bars)) / total, 1e-9);
  const double step = kWidth / static_cast<double>(kBars);
  std::string out = fmt::format(R"(<svg class="histogram" viewBox="0 0 {} {}" role="img" aria-label="Level {}">)",
                                kLeft + kWidth + 26, kHeight + kBottom, level.level);
  auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < kBars; ++i) {
    const double share = static_cast<double>(bars[i]) / total;
    const double height = (kHeight - 8) * share / most;
    const auto at = static_cast<double>(i);
    fmt::format_to(
        to, R"(<rect x="{:.2f}" y="{:.2f}" width="{:.2f}" height="{:.2f}"><title>{:.0f} to {:.0f} % of the bound: )",
        kLeft + at * step + 0.5, kHeight - height, step - 1, height, 100 * at / kBars, 100 * (at + 1) / kBars);
    fmt::format_to(to, "{:.3g} % of the samples</title></rect>", 100 * share);
  }
  draw_axes(out, most);
  const double p999 = kLeft + kWidth * std::min(level.vertical_p999_m / level.bound_m, 1.0);
  fmt::format_to(to, R"(<line class="mark" x1="{0:.1f}" y1="0" x2="{0:.1f}" y2="{1}"/>)", p999, kHeight);
  fmt::format_to(to, R"(<text class="mark" x="{:.1f}" y="9" text-anchor="end">99.9 %</text></svg>)", p999 - 4);
  return out;
}

std::string bar_svg(double share) {
  return fmt::format(
      R"(<svg class="bar" viewBox="0 0 100 10" preserveAspectRatio="none"><rect width="{:.2f}" height="10"/></svg>)",
      100 * std::clamp(share, 0.0, 1.0));
}

}  // namespace tintree::audit
