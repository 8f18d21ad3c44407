#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "codec/error.h"
#include "render/gpu_tile_pool.h"
#include "render/impostor.h"
#include "render/impostor_buffer.h"
#include "render/renderer.h"
#include "render/shader_program.h"

namespace tintree::render {

/// The impostor of a view's far ground: colours and depths as a picture (render/impostor.h), shown from wherever the
/// eye is by now. While one is shown the next is drawn, a few tiles a frame, so that it is there before the one does
/// not hold any more and no frame has to draw all of it. The two take 16 bytes a texel, 6.25 texels a pixel of the
/// view, out of the memory of the pool. Lives and dies while its context is current; not thread-safe.
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

  /// For every frame before it is drawn: drops what does not hold any more, and makes up its mind what goes into the
  /// next picture. What that lacks is returned; it is drawn once nothing is. Nothing when the pictures do not fit into
  /// the pool's memory beside what this frame has used so far, or onto the card: then give them up.
  std::optional<std::vector<cache::TileRef>> plan(const Camera& camera, Trees trees, GpuTilePool& pool,
                                                  const CutOptions& options, const ChooseCut& choose);
  /// Draws the next part of the planned picture if all of its tiles are there. `haze_begin_m`: as in the frame's cut.
  DrawStats refresh(const Renderer& renderer, Trees trees, GpuTilePool& pool, const Style& style, double haze_begin_m);

  /// Takes out of a cut what the picture shows to this camera; returns how many tiles that are.
  std::uint32_t take_from(LodCut& cut, Trees trees, const Camera& camera) const;
  /// Draws it into what is bound, in front of the background, for a camera that it holds for. `near_m`: as
  /// Renderer::near_m.
  void draw(const Camera& camera, double near_m) const;

  /// Graphics memory that it holds.
  std::size_t bytes() const;

 private:
  /// A picture and how its ground was drawn.
  struct Picture {
    ImpostorView view;
    double near_m = 0;  ///< As Renderer::near_m.
    Style style;
    TileSet tiles;
  };
  /// One that is not done yet.
  struct Begun {
    Picture picture;
    CutOptions options;
    double beyond_m = 0;  ///< Ground nearer than that is left out.
    LodCut cut;           ///< What is on it, once that is complete.
    double haze_begin_m = 0;
    int frames_left = 0;    ///< Over which the rest is drawn; 0 before the first.
    std::size_t drawn = 0;  ///< Tiles of the cut that have been.
  };

  FarPicture(const GlFunctions& gl, ShaderProgram program);
  void move_to(const Camera& camera);
  bool moved() const;
  bool wants_next(Trees trees, const CutOptions& options) const;
  bool begin(GpuTilePool& pool, const CutOptions& options);
  void choose_cut(Trees trees, const ChooseCut& choose);
  void start_drawing(const Style& style, double haze_begin_m);
  void show_begun(Trees trees);
  void rest();

  const GlFunctions* gl_;
  ShaderProgram program_;
  GLuint no_vertices_ = 0;
  std::array<ImpostorBuffer, 2> buffers_;
  std::size_t shown_buffer_ = 0;  ///< The other is drawn into.

  Camera before_;  ///< The camera a frame ago,
  Camera now_;     ///< and now.
  bool any_before_ = false;
  double step_m_ = 0;  ///< Of the camera from frame to frame.
  std::optional<Picture> shown_;
  std::optional<Begun> begun_;
  int rest_ = 0;  ///< Frames that go without.
};

}  // namespace tintree::render
