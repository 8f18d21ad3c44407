#pragma once

#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "cache/tile_pictures.h"
#include "render/gl_functions.h"

namespace tintree::render {

/// A tile's pictures on the card; 0 for what it lacks.
struct GpuPictures {
  GLuint colors = 0;
  GLuint directions = 0;
  GLuint lengths = 0;
  std::size_t bytes = 0;
};

/// Textures for tiles' pictures, drawn from compressed memory (Wahl et al. 2004, section 4, Compression), filtered
/// anisotropically and without mip-maps: the cut chooses tiles whose texels are about as large as pixels. A texture
/// that is given back serves for the next picture of its kind, so that nothing is allocated in a steady state. Lives
/// and dies while its context is current; not thread-safe.
class PictureTextures {
 public:
  explicit PictureTextures(const GlFunctions& gl);
  ~PictureTextures();
  PictureTextures(const PictureTextures&) = delete;
  PictureTextures& operator=(const PictureTextures&) = delete;

  GpuPictures upload(const cache::TilePictures& pictures);
  void give_back(const GpuPictures& pictures);

  /// Binds a tile's pictures to the units 0 (colours), 1 (directions) and 2 (lengths); in place of those it lacks
  /// no colour, upright normals and unit lengths.
  void bind(const GpuPictures& pictures) const;

 private:
  using Kind = std::pair<codec::PixelFormat, int>;  ///< Format and size.

  GLuint take(const codec::PixelArray& pixels, GpuPictures& owner);
  GLuint make(const codec::PixelArray& pixels) const;
  void fill(const codec::PixelArray& pixels, bool anew) const;

  const GlFunctions* gl_;
  std::map<Kind, std::vector<GLuint>> spare_;
  std::map<GLuint, Kind> kinds_;  ///< Of all textures.
  GpuPictures plain_;             ///< For what is lacking.
};

}  // namespace tintree::render
