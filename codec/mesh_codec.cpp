#include "codec/mesh_codec.h"

#include <algorithm>
#include <array>

#include "codec/coded_strip_mesh.h"
#include "codec/draco_mesh.h"
#include "codec/strip_mesh.h"

namespace tintree::codec {

const MeshCodec* find_codec(std::string_view method) {
  struct Method {
    std::string_view name;
    const MeshCodec* codec;
  };
  static const DracoMesh tin;
  static const StripMesh strip;
  static const CodedStripMesh coded_strip;
  /// One row a method, as in simplify/tile_maker.cpp.
  static const std::array methods{Method{"tin", &tin}, Method{"strip", &strip}, Method{"strip-coded", &coded_strip}};
  const auto* found = std::ranges::find(methods, method, &Method::name);
  return found == methods.end() ? nullptr : found->codec;
}

}  // namespace tintree::codec
