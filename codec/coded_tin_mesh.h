#pragma once

#include <cstddef>

#include "codec/mesh_codec.h"

namespace tintree::codec {

/// The first byte of its payloads.
inline constexpr auto kTinCoded = std::byte{4};

/// Method `tin`, payload version 4: connectivity and vertices in one adaptive range coder, each predicted from the
/// triangles before it (TinWalk; docs/format.md, Payload version 4). Whole numbers only: the same on every machine.
/// Where the mesh is no planar 2-manifold or is wider than kMostTinPlace, encode() gives what DracoMesh does.
class CodedTinMesh final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  /// Of version 4 alone; DracoMesh reads both.
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

}  // namespace tintree::codec
