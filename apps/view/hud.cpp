#include "apps/view/hud.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "apps/view/controls.h"
#include "render/font.h"

namespace tintree::view {
namespace {

constexpr float kTextPx = 14;
constexpr float kLeastTextPx = 6;
constexpr glm::vec4 kWhite{1, 1, 1, 1};
constexpr glm::vec4 kTitle{1, 0.85F, 0.45F, 1};
constexpr glm::vec4 kShade{0.05F, 0.07F, 0.10F, 0.62F};
constexpr glm::vec4 kHelpShade{0.05F, 0.07F, 0.10F, 0.82F};

/// One line of the help: a title, or an input and what it does.
struct HelpLine {
  std::string input;
  std::string does;
};

std::vector<HelpLine> help_lines(const ControlGroup& group) {
  std::vector<HelpLine> out{{std::string(group.title), ""}};
  for (const Control& c : group.controls) out.push_back({input_text(c), std::string(c.does)});
  return out;
}

std::size_t longest(const std::vector<HelpLine>& lines, std::string HelpLine::*part) {
  std::size_t most = 0;
  for (const HelpLine& line : lines) {
    const bool title = line.does.empty();
    if (!title) most = std::max(most, render::character_count(line.*part));
  }
  return most;
}

std::string megabytes(std::size_t bytes) { return fmt::format("{:.0f} MB", static_cast<double>(bytes) / 1e6); }

class Layout {
 public:
  Layout(int width_px, int height_px, double scale)
      : width_(static_cast<float>(width_px)), height_(static_cast<float>(height_px)) {
    hud_.size_px = kTextPx * static_cast<float>(scale);
    character_ = render::character_px(hud_.size_px);
  }

  std::size_t characters_across() const { return static_cast<std::size_t>(std::max(1.0F, width_ / character_.x - 2)); }

  /// Lines on a band along the lower edge.
  void lower_band(const std::vector<std::string>& lines) {
    if (lines.empty()) return;
    const float band = (static_cast<float>(lines.size()) + 0.4F) * character_.y;
    hud_.panels.push_back({{0, height_ - band}, {width_, height_}, kShade});
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const float y = height_ - band + (static_cast<float>(i) + 0.2F) * character_.y;
      hud_.lines.push_back({{character_.x, y}, lines[i], kWhite});
    }
  }

  void upper_left(const std::vector<std::string>& lines) {
    if (lines.empty()) return;
    std::size_t most = 0;
    for (const std::string& line : lines) most = std::max(most, render::character_count(line));
    const glm::vec2 from(character_.x, 0.5F * character_.y);
    const glm::vec2 size((static_cast<float>(most) + 2) * character_.x,
                         (static_cast<float>(lines.size()) + 0.4F) * character_.y);
    hud_.panels.push_back({from, from + size, kShade});
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const glm::vec2 at = from + glm::vec2(character_.x, (static_cast<float>(i) + 0.2F) * character_.y);
      hud_.lines.push_back({at, lines[i], kTitle});
    }
  }

  void help() {
    std::vector<HelpLine> lines;
    for (const ControlGroup& group : control_groups()) {
      if (!lines.empty()) lines.emplace_back();
      const auto more = help_lines(group);
      lines.insert(lines.end(), more.begin(), more.end());
    }
    const std::size_t inputs = longest(lines, &HelpLine::input) + 2;
    const glm::vec2 needed(static_cast<float>(inputs + longest(lines, &HelpLine::does) + 4),
                           static_cast<float>(lines.size() + 2));
    const float fit = std::min(1.0F, std::min(width_ / (needed.x * character_.x), height_ / (needed.y * character_.y)));
    hud_.size_px = std::max(kLeastTextPx, hud_.size_px * fit);
    character_ = render::character_px(hud_.size_px);
    const glm::vec2 size = needed * character_;
    const glm::vec2 from = glm::vec2(0.5F * (width_ - size.x), 0.5F * (height_ - size.y));
    hud_.panels.push_back({from, from + size, kHelpShade});
    glm::vec2 at = from + glm::vec2(2 * character_.x, character_.y);
    for (const HelpLine& line : lines) {
      hud_.lines.push_back({at, line.input, line.does.empty() ? kTitle : kWhite});
      hud_.lines.push_back({{at.x + static_cast<float>(inputs) * character_.x, at.y}, line.does, kWhite});
      at.y += character_.y;
    }
  }

  Hud take() { return std::move(hud_); }

 private:
  float width_;
  float height_;
  glm::vec2 character_;
  Hud hud_;
};

}  // namespace

std::vector<std::string> figures_text(const Readings& r) {
  const double asked = std::max(1.0, static_cast<double>(r.hits) + r.misses);
  std::vector<std::string> out{
      r.frames_per_second > 0 ? fmt::format("{:.0f} fps", r.frames_per_second) : std::string("at rest"),
      fmt::format("{:.1f} ms", 1e3 * r.frame_seconds),
      fmt::format("{} triangles", r.triangles),
      fmt::format("{} tiles", r.tiles),
      fmt::format("{} out of view", r.culled),
      fmt::format("{} hidden", r.occluded),
      fmt::format("error {:.2f} of {:.3g} px", r.max_error_px, r.allowed_px),
      fmt::format("cache hits {:.0f} %", 100 * r.hits / asked),
      fmt::format("memory {} + {} graphics", megabytes(r.cache_bytes), megabytes(r.gpu_bytes)),
  };
  if (r.to_come > 0) out.push_back(fmt::format("{} tiles to come", r.to_come));
  return out;
}

std::vector<std::string> wrap(const std::vector<std::string>& parts, std::size_t characters) {
  static constexpr std::string_view kBetween = " · ";
  std::vector<std::string> lines;
  std::size_t used = 0;
  for (const std::string& part : parts) {
    const std::size_t more = render::character_count(kBetween) + render::character_count(part);
    if (lines.empty() || used + more > characters) {
      lines.push_back(part);
      used = render::character_count(part);
    } else {
      lines.back() += std::string(kBetween) + part;
      used += more;
    }
  }
  return lines;
}

Hud lay_out(const HudText& text, int width_px, int height_px, double scale) {
  Layout layout(width_px, height_px, scale);
  if (text.help) {
    layout.help();
    return layout.take();
  }
  std::vector<std::string> lower = wrap(text.figures, layout.characters_across());
  if (!text.place.empty()) lower.insert(lower.begin(), text.place);
  layout.lower_band(lower);
  layout.upper_left(text.notices);
  return layout.take();
}

}  // namespace tintree::view
