#pragma once

#include "codec/mesh_codec.h"

namespace tintree::codec {

/// Method `scalar` (Fowler et al.): heights of regular grids as indices of a scalar quantiser, packed densely; the
/// vertices on the sides apart, exactly. The quantiser is what the heights say: uniform, its step their greatest common
/// divisor, or a table of those that occur, whichever takes fewer bytes. Encodes what find_scalar_tile() knows,
/// and nothing that decode() would refuse. A decoded mesh has its quantiser with it.
/// Payload: docs/format.md. Cost: about 0.25 microseconds a vertex to decode.
class ScalarCodec final : public MeshCodec {
 public:
  Expected<std::vector<std::byte>> encode(const TileMesh& mesh) const override;
  Expected<TileMesh> decode(std::span<const std::byte> bytes) const override;
};

}  // namespace tintree::codec
