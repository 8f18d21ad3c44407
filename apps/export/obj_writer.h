#pragma once

#include <string>
#include <vector>

#include "apps/export/mesh_writer.h"
#include "apps/export/output_file.h"

namespace tintree::exporter {

/// Wavefront OBJ: lines "v x y z" and "f a b c", mixed, with vertices counted from 1.
class ObjWriter final : public MeshWriter {
 public:
  static Expected<std::unique_ptr<MeshWriter>> create(const std::string& path,
                                                      const std::vector<std::string>& comments);

  void add_vertex(const std::array<double, 3>& position_m) override;
  void add_face(const Face& face) override;
  Expected<void> ok() const override { return file_.ok(); }
  Expected<void> finish() override { return file_.commit(); }

 private:
  explicit ObjWriter(OutputFile file) : file_(std::move(file)) {}

  OutputFile file_;
};

}  // namespace tintree::exporter
