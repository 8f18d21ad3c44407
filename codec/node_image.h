#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tintree::codec {

/// The pictures of a tile lie on its nodes (docs/format.md, Pictures): `size` x `size` texels, row-major, north row
/// first, the outer ones on the sides of the tile's square, where they are its neighbours' too.

/// Colours in sRGB; a texel is covered (alpha 255) or not (alpha 0, and then its colour means nothing).
struct ColorImage {
  int size = 0;
  std::vector<std::uint8_t> rgba;  ///< 4 bytes a texel.

  ColorImage() = default;
  explicit ColorImage(int side)
      : size(side), rgba(4 * static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}
  const std::uint8_t* at(int x, int y) const { return rgba.data() + offset(x, y); }
  std::uint8_t* at(int x, int y) { return rgba.data() + offset(x, y); }

 private:
  std::size_t offset(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x));
  }
};

/// Mean normals in the world frame (east, north, up): unit vectors where the ground is smooth, shorter the rougher it
/// is, never longer, and never pointing down.
struct NormalImage {
  int size = 0;
  std::vector<std::array<float, 3>> vectors;

  NormalImage() = default;
  explicit NormalImage(int side)
      : size(side), vectors(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}
  const std::array<float, 3>& at(int x, int y) const { return vectors[offset(x, y)]; }
  std::array<float, 3>& at(int x, int y) { return vectors[offset(x, y)]; }

 private:
  std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x);
  }
};

/// The largest side that a reader accepts.
inline constexpr int kMaxImageSize = 4097;

}  // namespace tintree::codec
