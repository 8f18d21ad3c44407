#pragma once

#include "codec/mesh_codec.h"

namespace tintree::codec {

/// Method `strip`, payload version 3: the strip in fewer bits, which have to be read from the first on: types and
/// heights go through an adaptive range coder, each vertex has its height once, and that as what is left over a
/// prediction from the entering edge (Dick et al. 2009 name it as future work; docs/format.md, payload version 3).
class CodedStripMesh final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

/// The strip of a coded payload (version 3) as one of version 1, the same that StripMesh would have made of the mesh;
/// one of version 1 as it is.
Expected<std::vector<std::byte>> packed_strip(std::span<const std::byte> payload);

}  // namespace tintree::codec
