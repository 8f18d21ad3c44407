#include "codec/draco_mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>

#include "codec/coded_tin_mesh.h"
#include "codec/draco_stream.h"
#include "codec/varint.h"

namespace tintree::codec {
namespace {

constexpr auto kPayloadVersion = std::byte{3};
/// Below this many vertices the fixed cost of the slow predictors can outweigh what they save.
constexpr std::size_t kTrySmallCoder = 300;
constexpr int kBestSpeed = 0;
/// From so many heights on the slow predictors' tables take 100 MiB and more, and save nothing.
constexpr std::int32_t kTallMesh = 1 << 20;
constexpr int kTallSpeed = 2;
constexpr int kSmallSpeed = 5;

void fill(draco::Mesh& out, const TileMesh& mesh) {
  static_assert(sizeof(GridVertex) == 3 * sizeof(std::int32_t));
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  out.set_num_points(count);
  draco::GeometryAttribute format;
  format.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT32, false, sizeof(GridVertex), 0);
  const int id = out.AddAttribute(format, true, count);
  draco::PointAttribute* positions = out.attribute(id);
  for (std::uint32_t i = 0; i < count; ++i) {
    positions->SetAttributeValue(draco::AttributeValueIndex(i), &mesh.vertices[i]);
  }
  out.SetNumFaces(mesh.triangles.size());
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    out.SetFace(draco::FaceIndex(f), {draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
}

bool encode_at(const draco::Mesh& mesh, int speed, draco::EncoderBuffer& buffer) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  return encoder.EncodeMeshToBuffer(mesh, &buffer).ok();
}

}  // namespace

Expected<std::vector<std::byte>> DracoMesh::encode(const TileMesh& mesh) const {
  if (mesh.vertices.size() > kMaxTileVertices || mesh.triangles.size() > kMaxTileTriangles) {
    return fail(ErrorCode::kBadData,
                "the tile has more vertices than the format allows; choose a larger --error or a smaller --tile");
  }
  draco::Mesh source;
  fill(source, mesh);
  draco::EncoderBuffer buffer;
  const bool tall = std::ranges::any_of(mesh.vertices, [](const GridVertex& v) { return v.z >= kTallMesh; });
  if (!encode_at(source, tall ? kTallSpeed : kBestSpeed, buffer))
    return fail(ErrorCode::kBadData, "Draco could not encode the mesh");
  if (mesh.vertices.size() < kTrySmallCoder) {
    draco::EncoderBuffer other;
    if (encode_at(source, kSmallSpeed, other) && other.size() < buffer.size()) std::swap(buffer, other);
  }
  std::vector<std::byte> out{kPayloadVersion, static_cast<std::byte>(static_cast<std::int8_t>(mesh.xy_shift))};
  put_signed_varint(out, mesh.z_offset);
  if (!pack_draco_stream(std::as_bytes(std::span(buffer.data(), buffer.size())), out)) {
    return fail(ErrorCode::kBadData, "this version of Draco writes another bitstream than the format holds");
  }
  return out;
}

Expected<TileMesh> DracoMesh::decode(std::span<const std::byte> bytes) const {
  if (!bytes.empty() && bytes.front() == kTinCoded) return CodedTinMesh().decode(bytes);
  TileMesh mesh;
  if (bytes.size() < 3) return fail(ErrorCode::kBadData, "the payload is cut short");
  if (bytes[0] != kPayloadVersion)
    return fail(ErrorCode::kBadData, "the payload has a version this program does not know");
  mesh.xy_shift = static_cast<std::int8_t>(bytes[1]);
  bytes = bytes.subspan(2);
  if (!take_signed_varint(bytes, mesh.z_offset)) return fail(ErrorCode::kBadData, "the payload is cut short");
  std::vector<std::byte> stream;
  if (!unpack_draco_stream(bytes, stream)) return fail(ErrorCode::kBadData, "the payload is damaged or cut short");
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stream.data()), stream.size());
  auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return fail(ErrorCode::kBadData, "Draco refuses the payload");
  const std::unique_ptr<draco::Mesh> source = std::move(decoded).value();
  const draco::PointAttribute* positions = source->GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (positions == nullptr || positions->num_components() != 3) {
    return fail(ErrorCode::kBadData, "the payload holds no positions");
  }
  if (source->num_points() > kMaxTileVertices || source->num_faces() > kMaxTileTriangles) {
    return fail(ErrorCode::kBadData, "the payload holds more vertices than the format allows");
  }
  mesh.vertices.resize(source->num_points());
  for (std::uint32_t i = 0; i < source->num_points(); ++i) {
    std::array<std::int32_t, 3> p{};
    if (!positions->ConvertValue<std::int32_t>(positions->mapped_index(draco::PointIndex(i)), p.data())) {
      return fail(ErrorCode::kBadData, "the payload's positions are no integers");
    }
    mesh.vertices[i] = {p[0], p[1], p[2]};
  }
  mesh.triangles.resize(source->num_faces());
  for (std::uint32_t f = 0; f < source->num_faces(); ++f) {
    const draco::Mesh::Face& face = source->face(draco::FaceIndex(f));
    mesh.triangles[f] = {face[0].value(), face[1].value(), face[2].value()};
  }
  return mesh;
}

}  // namespace tintree::codec
