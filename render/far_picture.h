#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include "codec/error.h"
#include "render/gpu_tile_pool.h"
#include "render/impostor.h"
#include "render/renderer.h"
#include "render/shader_program.h"

namespace tintree::render {

/// The impostor of a view's far ground: colours and depths as a picture, drawn anew as soon as it does not hold for a
/// view any more (render/impostor.h), which it shows from wherever the eye is by then. It takes 8 bytes a texel, 6.25
/// texels a pixel of the view, out of the memory of the pool. Lives and dies while its context is current; not
/// thread-safe.
class FarPicture {
 public:
  /// `gl` must outlive it. Fails with kIo when the driver refuses a shader.
  static Expected<std::unique_ptr<FarPicture>> create(const GlFunctions& gl);
  ~FarPicture();
  FarPicture(const FarPicture&) = delete;
  FarPicture& operator=(const FarPicture&) = delete;

  /// The cut of all ground in sight of a camera, hidden or not, as far as it has been loaded. Nodes that come closer
  /// than `beyond_m` count as loaded.
  using ChooseCut = std::function<LodCut(const Camera& camera, const CutOptions& options, double beyond_m)>;

  /// For every frame before it is drawn: drops the picture when it does not hold any more, and makes up its mind what
  /// goes into the next. What that lacks is returned; it is drawn once nothing is. Nothing when the picture itself does
  /// not fit into the pool's memory beside what this frame has used so far, or onto the card: then give it up.
  std::optional<std::vector<cache::TileRef>> plan(const Camera& camera, Trees trees, GpuTilePool& pool,
                                                  const CutOptions& options, const ChooseCut& choose);
  /// Draws the planned picture if all of it is there. `haze_begin_m`: as in the frame's cut.
  DrawStats refresh(const Renderer& renderer, Trees trees, GpuTilePool& pool, const Style& style, double haze_begin_m);

  /// Takes out of a cut what the picture shows to this camera; returns how many tiles that are.
  std::uint32_t take_from(LodCut& cut, Trees trees, const Camera& camera) const;
  /// Draws it into what is bound, in front of the background, for a camera that it holds for. `near_m`: as
  /// Renderer::near_m.
  void draw(const Camera& camera, double near_m) const;

  /// Graphics memory that it holds.
  std::size_t bytes() const;

 private:
  FarPicture(const GlFunctions& gl, ShaderProgram program);
  void forget();
  bool fit(const Camera& picture, GpuTilePool& pool);
  bool allocate(int width_px, int height_px);

  const GlFunctions* gl_;
  ShaderProgram program_;
  GLuint no_vertices_ = 0;
  GLuint framebuffer_ = 0;
  GLuint colors_ = 0;
  GLuint depths_ = 0;
  int width_px_ = 0;
  int height_px_ = 0;

  std::optional<Camera> last_;
  double step_m_ = 0;             ///< Of the camera from frame to frame.
  std::optional<LodCut> wanted_;  ///< Of the next picture.
  ImpostorView next_;
  std::optional<ImpostorView> made_;
  double made_near_m_ = 0;
  int held_ = 0;  ///< Frames that it has stood for,
  int rest_ = 0;  ///< and how many go without.
  Style style_;   ///< It was drawn with.
  TileSet tiles_;
};

}  // namespace tintree::render
