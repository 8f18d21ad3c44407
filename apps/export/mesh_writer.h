#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "codec/error.h"

namespace tintree::exporter {

/// Three vertex numbers, counted from 0 in the order in which the vertices were added.
using Face = std::array<std::uint32_t, 3>;

/// A mesh file in the making; one file a format implements it. What is added goes to disk at once, so
/// that memory does not grow. Without finish() nothing is left behind. Not thread-safe.
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;

  /// Metres: x east, y north, z up.
  virtual void add_vertex(const std::array<double, 3>& position_m) = 0;
  /// Counter-clockwise seen from above.
  virtual void add_face(const Face& face) = 0;
  /// kIo once anything could not be written.
  virtual Expected<void> ok() const = 0;
  /// Completes the file and moves it to its goal.
  virtual Expected<void> finish() = 0;
};

/// Begins a file of `format`, "ply" (binary, little-endian, positions as doubles) or "obj" (text, every
/// number in the fewest digits that give back the same double). `comments` become its comment lines.
Expected<std::unique_ptr<MeshWriter>> create_mesh_writer(const std::string& format, const std::string& path,
                                                         const std::vector<std::string>& comments);

}  // namespace tintree::exporter
