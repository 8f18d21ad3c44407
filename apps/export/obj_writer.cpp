#include "apps/export/obj_writer.h"

#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace tintree::exporter {

Expected<std::unique_ptr<MeshWriter>> ObjWriter::create(const std::string& path,
                                                        const std::vector<std::string>& comments) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  for (const std::string& comment : comments) file->write("# " + comment + "\n");
  return std::unique_ptr<MeshWriter>(new ObjWriter(std::move(*file)));
}

void ObjWriter::add_vertex(const std::array<double, 3>& position_m) {
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "v {} {} {}\n", position_m[0], position_m[1], position_m[2]);
  file_.write({line.data(), line.size()});
}

void ObjWriter::add_face(const Face& face) {
  fmt::memory_buffer line;
  fmt::format_to(std::back_inserter(line), "f {} {} {}\n", std::uint64_t{face[0]} + 1, std::uint64_t{face[1]} + 1,
                 std::uint64_t{face[2]} + 1);
  file_.write({line.data(), line.size()});
}

}  // namespace tintree::exporter
