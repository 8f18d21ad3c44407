#pragma once

#include "codec/mesh_codec.h"

namespace tintree::codec {

/// Method `tin`: Draco's Edgebreaker over one integer position attribute, so that addresses come back
/// exactly (Wahl et al. 2004, section 4, Compression; Rossignac 1999). Payload: docs/format.md.
/// Cost: about 1 us a vertex to encode, 0.26 us to decode.
class DracoMesh final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  /// Of either payload version, this one and CodedTinMesh's.
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

}  // namespace tintree::codec
