#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>

#include "cache/manifest.h"
#include "cache/tile_bounds.h"
#include "codec/coded_tin_mesh.h"
#include "codec/mesh_codec.h"
#include "codec/nested_tile.h"

namespace {

using namespace tintree;

constexpr std::int64_t kCells = 256;

codec::TreeLayout layout() {
  codec::TreeLayout l;
  l.columns = 1500;
  l.rows = 700;
  l.leaf_level = codec::TreeLayout::leaf_level_for(l.columns, l.rows, l.tile_cells);
  l.leaf_error_m = 1;
  l.z_step_m.assign(static_cast<std::size_t>(l.leaf_level) + 1, 0.25);
  return l;
}

/// Of method `wavelet`: the root stands alone, other tiles lie on it.
void read_wavelet_payload(std::span<const std::byte> bytes) {
  codec::TreeLayout l = layout();
  const auto decoder =
      codec::make_tile_decoder("wavelet", l, [&](const codec::TileId&) -> Expected<std::vector<std::byte>> {
        return std::vector<std::byte>{std::byte{0}, std::byte{0}};
      });
  for (const codec::TileId& id : {codec::TileId{0, 0, 0}, codec::TileId{1, 1, 0}}) {
    const auto mesh = decoder->decode(id, bytes);
    if (mesh) static_cast<void>(codec::validate(*mesh, l.cells_across(id.level)));
  }
}

/// What decodes and validates has to survive being encoded again; what the others' payloads hold may turn out not to be
/// a mesh of theirs then.
void read_payload(const char* method, std::span<const std::byte> bytes) {
  const codec::MeshCodec& codec = *codec::find_codec(method);
  const auto mesh = codec.decode(bytes);
  if (!mesh || !codec::validate(*mesh, kCells)) return;
  if (!mesh->triangles.empty() && !codec.encode(*mesh) && std::string_view(method) != "strip") std::abort();
}

/// Method `tin`, payload version 4: what decodes and validates is the same again after another way through.
void read_coded_tin(std::span<const std::byte> bytes) {
  const codec::CodedTinMesh codec;
  const auto mesh = codec.decode(bytes);
  if (!mesh || !codec::validate(*mesh, kCells) || mesh->triangles.empty()) return;
  const auto coded = codec.encode(*mesh);
  if (!coded || coded->front() != codec::kTinCoded) return;
  const auto again = codec.decode(*coded);
  if (!again || again->triangles.size() != mesh->triangles.size()) std::abort();
}

void read_manifest(std::span<const std::byte> bytes) {
  const auto manifest =
      cache::Manifest::from_json(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  if (manifest && !cache::Manifest::from_json(manifest->to_json())) std::abort();
}

void read_bounds(std::span<const std::byte> bytes) {
  const auto bounds = cache::TileBounds::from_bytes(layout(), bytes);
  if (bounds && bounds->to_bytes().size() != bytes.size()) std::abort();
}

}  // namespace

/// The first byte chooses the reader.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  switch (data[0] % 8) {
    case 0:
      read_payload("tin", bytes);
      break;
    case 1:
      read_manifest(bytes);
      break;
    case 2:
      read_wavelet_payload(bytes);
      break;
    case 3:
      read_bounds(bytes);
      break;
    case 4:
      read_payload("strip", bytes);
      break;
    case 5:
      read_payload("nested", bytes);
      static_cast<void>(codec::decode_nested(bytes));
      break;
    case 6:
      read_payload("scalar", bytes);
      break;
    default:
      read_coded_tin(bytes);
  }
  return 0;
}
