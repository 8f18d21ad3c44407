#pragma once

#include <string>
#include <vector>

#include "apps/export/mesh_writer.h"
#include "apps/export/output_file.h"

namespace tintree::exporter {

/// Binary little-endian PLY (Turk 1994). Faces follow all vertices there, so they wait in a file of their
/// own, and the counts are put into the header at the end.
class PlyWriter final : public MeshWriter {
 public:
  static Expected<std::unique_ptr<MeshWriter>> create(const std::string& path,
                                                      const std::vector<std::string>& comments);

  void add_vertex(const std::array<double, 3>& position_m) override;
  void add_face(const Face& face) override;
  Expected<void> ok() const override;
  Expected<void> finish() override;

 private:
  PlyWriter(OutputFile file, OutputFile faces, std::vector<std::string> comments);
  std::string header() const;

  OutputFile file_;
  OutputFile faces_;
  std::vector<std::string> comments_;
  std::uint64_t vertex_count_ = 0;
  std::uint64_t face_count_ = 0;
};

}  // namespace tintree::exporter
