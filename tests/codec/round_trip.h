#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "codec/mesh_codec.h"
#include "tests/codec/random_mesh.h"

namespace tintree::test {

struct RoundTrip {
  std::vector<std::byte> bytes;
  codec::TileMesh back;
};

/// Encodes the mesh, always alike, and decodes it: what comes back holds the same triangles. Nothing where it fails.
inline std::optional<RoundTrip> expect_round_trip(const codec::MeshCodec& encoder, const codec::MeshCodec& decoder,
                                                  const codec::TileMesh& mesh) {
  const auto bytes = encoder.encode(mesh);
  EXPECT_TRUE(bytes.has_value()) << bytes.error().text();
  if (!bytes) return std::nullopt;
  EXPECT_EQ(*encoder.encode(mesh), *bytes) << "encoding is not deterministic";
  const auto back = decoder.decode(*bytes);
  EXPECT_TRUE(back.has_value()) << back.error().text();
  if (!back) return std::nullopt;
  EXPECT_EQ(back->xy_shift, mesh.xy_shift);
  EXPECT_EQ(back->z_offset, mesh.z_offset);
  EXPECT_EQ(triangle_set(*back), triangle_set(mesh));
  return RoundTrip{*bytes, *back};
}

}  // namespace tintree::test
