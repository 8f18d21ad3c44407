#pragma once

#include <string>
#include <vector>

#include "render/text_drawer.h"

namespace tintree::view {

/// Figures of a frame, for the line at the picture's lower edge.
struct Readings {
  double frame_seconds = 0;
  double frames_per_second = 0;  ///< Of the last frames drawn without a rest; 0 while there are none.
  std::uint64_t triangles = 0;
  std::uint32_t tiles = 0;
  std::uint32_t culled = 0;     ///< Parts of the tree outside the view.
  std::uint32_t occluded = 0;   ///< Parts behind nearer ground, where that was looked for.
  std::uint32_t hits = 0;       ///< Of the tiles that came into view since the start: ready in memory.
  std::uint32_t misses = 0;     ///< The others: had to be read.
  std::size_t cache_bytes = 0;  ///< Main memory for tiles.
  std::size_t gpu_bytes = 0;    ///< Graphics memory for tiles.
  double max_error_px = 0;
  double allowed_px = 1;
  std::size_t to_come = 0;  ///< Tiles on their way.
};

/// What the picture says; empty strings and lists are left out.
struct HudText {
  std::vector<std::string> figures;  ///< Parts of the statistics line.
  std::string place;                 ///< Under the cursor.
  std::vector<std::string> notices;  ///< What has just happened.
  bool help = false;
};

/// Text and areas behind it, ready for render::TextDrawer.
struct Hud {
  std::vector<render::TextPanel> panels;
  std::vector<render::TextLine> lines;
  float size_px = 16;
};

/// Parts of the statistics line, in its order.
std::vector<std::string> figures_text(const Readings& readings);

/// Joins parts by " · " to lines of at most `characters` where that is possible.
std::vector<std::string> wrap(const std::vector<std::string>& parts, std::size_t characters);

/// Lays text out over a picture of this size; `scale` is the screen's (1, or 2 where it has twice the pixels).
/// The help shrinks until it fits.
Hud lay_out(const HudText& text, int width_px, int height_px, double scale);

}  // namespace tintree::view
