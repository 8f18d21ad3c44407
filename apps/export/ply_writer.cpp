#include "apps/export/ply_writer.h"

#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace tintree::exporter {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is written in the machine's own byte order");

/// Room for the digits of both counts together.
constexpr std::size_t kCountDigits = 24;

}  // namespace

Expected<std::unique_ptr<MeshWriter>> PlyWriter::create(const std::string& path,
                                                        const std::vector<std::string>& comments) {
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto faces = OutputFile::create(path, ".faces.tmp");
  if (!faces) return tl::unexpected(faces.error());
  return std::unique_ptr<MeshWriter>(new PlyWriter(std::move(*file), std::move(*faces), comments));
}

PlyWriter::PlyWriter(OutputFile file, OutputFile faces, std::vector<std::string> comments)
    : file_(std::move(file)), faces_(std::move(faces)), comments_(std::move(comments)) {
  file_.write(header());
}

/// Always of the same length, whatever the counts: a last comment of blanks makes up for their digits.
std::string PlyWriter::header() const {
  const std::string vertices = fmt::format("{}", vertex_count_);
  const std::string faces = fmt::format("{}", face_count_);
  std::string out = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments_) out += "comment " + comment + "\n";
  out += "comment " + std::string(kCountDigits - vertices.size() - faces.size(), ' ') + "\n";
  out += "element vertex " + vertices + "\nproperty double x\nproperty double y\nproperty double z\n";
  out += "element face " + faces + "\nproperty list uchar int vertex_indices\nend_header\n";
  return out;
}

void PlyWriter::add_vertex(const std::array<double, 3>& position_m) {
  ++vertex_count_;
  file_.write({reinterpret_cast<const char*>(position_m.data()), sizeof position_m});
}

void PlyWriter::add_face(const Face& face) {
  ++face_count_;
  std::array<char, 1 + sizeof(Face)> record{3};
  std::memcpy(record.data() + 1, face.data(), sizeof face);
  faces_.write({record.data(), record.size()});
}

Expected<void> PlyWriter::ok() const {
  auto done = file_.ok();
  return done ? faces_.ok() : done;
}

Expected<void> PlyWriter::finish() {
  file_.append(faces_);
  file_.write_at(0, header());
  return file_.commit();
}

}  // namespace tintree::exporter
