#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace tintree::render {

/// The characters that there are; any other is drawn as the last of them.
inline constexpr std::u32string_view kFontCharacters =
    U" !\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`abcdefghijklmnopqrstuvwxyz{|}~°·×–…□";

/// A font of one width as distances to the outlines of its characters, so that it can be drawn at any size
/// (Green, "Improved Alpha-Tested Magnification", 2007). Made from DejaVu Sans Mono when the library is built
/// (make_font.cpp).
struct Font {
  int size_px = 0;      ///< Of an em at the atlas' own resolution; all below is in pixels of that.
  int cell_px[2] = {};  ///< Width and height of a character's cell in the atlas, its margins included.
  int columns = 0;      ///< Cells in a row of the atlas, in the order of kFontCharacters.
  int rows = 0;
  int margin_px = 0;     ///< Round a character; the distance of which 0 and 255 stand for is the same.
  float advance_px = 0;  ///< From one character to the next.
  float ascent_px = 0;   ///< From the upper end of a line to its baseline.
  float line_px = 0;     ///< From one line to the next.
  /// columns * cell width by rows * cell height values, the upper row first; 128 on an outline, more inside.
  std::span<const std::uint8_t> distances;
};

const Font& overlay_font();

/// Position in kFontCharacters of the character that `text` (UTF-8) begins with, which is taken off it. `text`
/// is not empty.
std::size_t take_character(std::string_view& text);

/// Characters of a UTF-8 text.
std::size_t character_count(std::string_view text);

}  // namespace tintree::render
