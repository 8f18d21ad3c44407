#include "codec/draco_stream.h"

#include <random>

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>

#include "tests/codec/random_mesh.h"

namespace tintree::codec {
namespace {

using test::MeshSpec;
using test::random_mesh;

void fill(draco::Mesh& out, const TileMesh& mesh, int components) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  out.set_num_points(count);
  draco::GeometryAttribute format;
  format.Init(draco::GeometryAttribute::POSITION, nullptr, static_cast<std::int8_t>(components), draco::DT_INT32, false,
              components * 4, 0);
  draco::PointAttribute* positions = out.attribute(out.AddAttribute(format, true, count));
  for (std::uint32_t i = 0; i < count; ++i) {
    positions->SetAttributeValue(draco::AttributeValueIndex(i), &mesh.vertices[i]);
  }
  for (const Triangle& t : mesh.triangles) {
    out.AddFace({draco::PointIndex(t[0]), draco::PointIndex(t[1]), draco::PointIndex(t[2])});
  }
}

std::vector<std::byte> encoded(const TileMesh& mesh, int speed, int prediction = -1, int components = 3) {
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(speed, speed);
  if (prediction >= 0) encoder.SetAttributePredictionScheme(draco::GeometryAttribute::POSITION, prediction);
  draco::Mesh source;
  fill(source, mesh, components);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(source, &buffer).ok());
  const auto bytes = std::as_bytes(std::span(buffer.data(), buffer.size()));
  return {bytes.begin(), bytes.end()};
}

/// Packs and unpacks; what packing saves.
std::size_t round_trip(const std::vector<std::byte>& stream) {
  std::vector<std::byte> packed;
  EXPECT_TRUE(pack_draco_stream(stream, packed));
  std::vector<std::byte> back(7);
  EXPECT_TRUE(unpack_draco_stream(packed, back));
  EXPECT_EQ(back, stream);
  return stream.size() - packed.size();
}

TEST(DracoStream, ComesBackToTheLastBit) {
  std::mt19937 random(3);
  for (int i = 0; i < 150; ++i) {
    // Holes, pieces that touch at a corner, sizes on both sides of Draco's own thresholds.
    const TileMesh mesh = random_mesh(random, {.columns = 1 + static_cast<int>(random() % 40),
                                               .rows = 1 + static_cast<int>(random() % 40),
                                               .drop = i % 3 == 0 ? 0.1 : 0,
                                               .split = i % 2 == 0 ? 0.1 : 0,
                                               .height_range = i % 5 == 0 ? 60000 : 30});
    for (const int speed : {0, 1, 2, 5, 7}) {
      SCOPED_TRACE("mesh " + std::to_string(i) + " at speed " + std::to_string(speed));
      round_trip(encoded(mesh, speed));
      if (HasFailure()) return;
    }
  }
}

TEST(DracoStream, ComesBackWithEveryPrediction) {
  std::mt19937 random(4);
  const TileMesh mesh = random_mesh(random, {.columns = 20, .rows = 20});
  for (const int prediction : {0, 1, 4}) round_trip(encoded(mesh, 0, prediction));
}

TEST(DracoStream, LeavesOutMostOfWhatIsAlwaysTheSame) {
  std::mt19937 random(5);
  EXPECT_GE(round_trip(encoded(random_mesh(random, {.columns = 6, .rows = 6}), 5)), 36U);
  // Even where the connectivity is kept as it is.
  const TileMesh holes = random_mesh(random, {.columns = 12, .rows = 12, .drop = 0.3});
  EXPECT_GE(round_trip(encoded(holes, 0)), 25U);
}

TEST(DracoStream, RefusesWhatIsNoSuchStream) {
  std::mt19937 random(6);
  const TileMesh mesh = random_mesh(random, {.columns = 6, .rows = 6});
  std::vector<std::byte> packed;
  EXPECT_FALSE(pack_draco_stream({}, packed));
  EXPECT_FALSE(pack_draco_stream(std::vector<std::byte>(100), packed));
  EXPECT_FALSE(pack_draco_stream(encoded(mesh, 5, -1, 2), packed)) << "two components";
  auto stream = encoded(mesh, 5);
  stream[6] = std::byte{3};
  EXPECT_FALSE(pack_draco_stream(stream, packed)) << "another bit stream version";
  EXPECT_TRUE(packed.empty());
}

TEST(DracoStream, RefusesDamagedHeads) {
  std::mt19937 random(7);
  std::vector<std::byte> packed;
  ASSERT_TRUE(pack_draco_stream(encoded(random_mesh(random, {.columns = 6, .rows = 6}), 5), packed));
  std::vector<std::byte> stream;
  EXPECT_FALSE(unpack_draco_stream({}, stream));
  for (const int form : {12, 32, 255}) {
    auto damaged = packed;
    damaged[0] = static_cast<std::byte>(form);
    EXPECT_FALSE(unpack_draco_stream(damaged, stream)) << form;
  }
  // Lengths beyond the end: of a disk's traversal, of other connectivity.
  for (const std::vector<int>& numbers : {std::vector{16, 5, 5, 0, 9, 1, 2, 3}, std::vector{0, 7, 1, 2, 3}}) {
    std::vector<std::byte> bytes;
    for (const int n : numbers) bytes.push_back(static_cast<std::byte>(n));
    EXPECT_FALSE(unpack_draco_stream(bytes, stream));
  }
  for (std::size_t size = 0; size < 8; ++size) {
    EXPECT_FALSE(unpack_draco_stream(std::span(packed).first(size), stream)) << size;
  }
}

}  // namespace
}  // namespace tintree::codec
