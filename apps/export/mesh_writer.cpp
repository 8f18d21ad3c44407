#include "apps/export/mesh_writer.h"

#include "apps/export/obj_writer.h"
#include "apps/export/ply_writer.h"

namespace tintree::exporter {

Expected<std::unique_ptr<MeshWriter>> create_mesh_writer(const std::string& format, const std::string& path,
                                                         const std::vector<std::string>& comments) {
  if (format == "ply") return PlyWriter::create(path, comments);
  if (format == "obj") return ObjWriter::create(path, comments);
  return fail(ErrorCode::kUsage, "there is no format '" + format + "'; choose ply or obj", "--to");
}

}  // namespace tintree::exporter
