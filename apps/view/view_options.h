#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "codec/error.h"
#include "render/camera.h"
#include "render/gl_context.h"
#include "render/lod_cut.h"
#include "render/renderer.h"
#include "render/terrain_scene.h"

namespace tintree::view {

/// The command line of tintree-view, as it was given (docs/guide.md).
struct CommandLine {
  std::vector<std::string> trees;
  double pixel_error = 1;
  int gpu_memory_mib = 512;
  std::string size;      ///< "WxH"
  std::string headless;  ///< "", "egl" or "osmesa"
  std::string screenshot;
  std::string eye;  ///< "X,Y,Z"
  std::string target;
  std::vector<std::string> show;
  std::string sun;  ///< "AZIMUTH,ELEVATION"
  std::string flight;
  std::string frames;
  double fps = 30;
  bool real_time = false;
  std::string json;
  bool morph = false;
  bool impostors = false;
  double fog_m = 0;
  bool quiet = false;
};

/// What it means.
struct ViewOptions {
  std::vector<std::string> trees;
  double pixel_error = 1;
  std::size_t gpu_bytes = 0;  ///< Graphics memory for tiles.
  int width_px = 1280;
  int height_px = 720;
  std::optional<render::Headless> headless;  ///< None: a window.
  std::string screenshot;                    ///< Path of a picture to write; empty for none.
  std::optional<glm::dvec3> eye;             ///< World frame, metres.
  std::optional<glm::dvec3> target;
  render::Style style;
  bool boxes = false;  ///< Show the tiles' boxes.
  std::string flight;  ///< Path of a flight to play; empty for none.
  std::string frames;  ///< Folder for its frames; empty for none.
  double fps = 30;
  bool real_time = false;  ///< The clock leads the camera, not the frame's number.
  std::string json;
  bool morph = false;
  bool impostors = false;
  bool quiet = false;
};

/// Fails with kUsage and names the option that makes no sense.
Expected<ViewOptions> read_options(const CommandLine& line);

/// The scene that the options ask for, for a camera that moves.
render::SceneOptions scene_options(const ViewOptions& options);

/// The view that the options ask for. Without an eye: the whole terrain from the south, 38 degrees above
/// the horizon (or, with a target alone, from that side at a third of the terrain's size); without a
/// target: the middle of the terrain. Fails with kUsage when the eye is the target.
Expected<render::Camera> first_camera(const ViewOptions& options, render::Trees trees);

}  // namespace tintree::view
