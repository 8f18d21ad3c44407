// make_font FONT.ttf OUT.cpp: writes overlay_font() of render/font.h, whose characters come from the font file.
// Runs while tintree is built, so that an installed program needs neither FreeType nor the file.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_MODULE_H

#include "render/font.h"

namespace {

constexpr int kSizePx = 32;
constexpr int kMarginPx = 4;
constexpr int kColumns = 16;

void check(FT_Error error, const char* what) {
  if (error == 0) return;
  std::fprintf(stderr, "make_font: FreeType fails (%d): %s\n", error, what);
  std::exit(1);
}

struct Atlas {
  int width = 0;
  std::vector<std::uint8_t> values;
};

/// Copies the character that `glyph` holds into its cell, whose upper left corner is at (x0, y0).
void place(const FT_GlyphSlot glyph, int x0, int y0, int ascent, Atlas& atlas) {
  for (unsigned row = 0; row < glyph->bitmap.rows; ++row) {
    for (unsigned column = 0; column < glyph->bitmap.width; ++column) {
      const int x = x0 + kMarginPx + glyph->bitmap_left + static_cast<int>(column);
      const int y = y0 + kMarginPx + ascent - glyph->bitmap_top + static_cast<int>(row);
      atlas.values[static_cast<std::size_t>(y * atlas.width + x)] =
          glyph->bitmap.buffer[static_cast<std::ptrdiff_t>(row) * glyph->bitmap.pitch + column];
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  check(FT_Init_FreeType(&library), "start");
  const FT_Int spread = kMarginPx;
  check(FT_Property_Set(library, "sdf", "spread", &spread), "spread");
  check(FT_New_Face(library, argv[1], 0, &face), argv[1]);
  check(FT_Set_Pixel_Sizes(face, 0, kSizePx), "size");

  const auto scaled = [&](FT_Short units) { return static_cast<float>(units) * kSizePx / face->units_per_EM; };
  const int ascent = static_cast<int>(scaled(face->ascender)) + 1;
  const int descent = static_cast<int>(-scaled(face->descender)) + 1;
  const int cell_width = static_cast<int>(scaled(face->max_advance_width)) + 1 + 2 * kMarginPx;
  const int cell_height = ascent + descent + 2 * kMarginPx;
  const auto characters = tintree::render::kFontCharacters;
  const int rows = (static_cast<int>(characters.size()) + kColumns - 1) / kColumns;
  Atlas atlas{kColumns * cell_width, {}};
  atlas.values.assign(static_cast<std::size_t>(atlas.width * rows * cell_height), 0);
  for (int i = 0; i < static_cast<int>(characters.size()); ++i) {
    check(FT_Load_Char(face, characters[static_cast<std::size_t>(i)], FT_LOAD_NO_HINTING), "character");
    if (face->glyph->outline.n_points == 0) continue;
    check(FT_Render_Glyph(face->glyph, FT_RENDER_MODE_SDF), "distances");
    place(face->glyph, i % kColumns * cell_width, i / kColumns * cell_height, ascent, atlas);
  }

  std::ofstream out(argv[2]);
  out << "// Made from " << face->family_name << " by render/make_font.cpp.\n"
      << "#include \"render/font.h\"\n\nnamespace tintree::render {\nnamespace {\n\n"
      << "constexpr std::uint8_t kDistances[] = {";
  for (std::size_t i = 0; i < atlas.values.size(); ++i)
    out << (i % 32 == 0 ? "\n" : "") << static_cast<int>(atlas.values[i]) << ',';
  out << "};\n\n}  // namespace\n\nconst Font& overlay_font() {\n  static constexpr Font kFont{" << kSizePx << ", {"
      << cell_width << ", " << cell_height << "}, " << kColumns << ", " << rows << ", " << kMarginPx
      << ", static_cast<float>(" << scaled(face->max_advance_width) << "), static_cast<float>(" << ascent
      << "), static_cast<float>(" << scaled(face->height)
      << "), kDistances};\n  return kFont;\n}\n\n}  // namespace tintree::render\n";
  FT_Done_Face(face);
  FT_Done_FreeType(library);
  out.close();
  return out ? 0 : 1;
}
