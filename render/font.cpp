#include "render/font.h"

#include <algorithm>

namespace tintree::render {

std::size_t take_character(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  // The leading ones of the first byte tell how many bytes there are.
  const std::size_t wanted = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  const std::size_t bytes = std::min(wanted, text.size());
  char32_t code = wanted == 1 ? first : first & (0x7fU >> wanted);
  for (std::size_t i = 1; i < bytes; ++i) code = code << 6U | (byte(i) & 0x3fU);
  text.remove_prefix(bytes);
  return std::min(kFontCharacters.find(code), kFontCharacters.size() - 1);
}

std::size_t character_count(std::string_view text) {
  std::size_t count = 0;
  for (; !text.empty(); ++count) take_character(text);
  return count;
}

}  // namespace tintree::render
