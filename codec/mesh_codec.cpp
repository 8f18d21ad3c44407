#include "codec/mesh_codec.h"

#include <algorithm>
#include <array>

#include "codec/draco_mesh.h"
#include "codec/nested_mesh.h"
#include "codec/scalar_codec.h"
#include "codec/strip_mesh.h"

namespace tintree::codec {

const MeshCodec* find_codec(std::string_view method) {
  struct Method {
    std::string_view name;
    const MeshCodec* codec;
  };
  static const DracoMesh tin;
  static const NestedMesh nested;
  static const StripMesh strip;
  static const ScalarCodec scalar;
  /// One row a method, as in simplify/tile_maker.cpp.
  static const std::array methods{Method{"tin", &tin}, Method{"strip", &strip}, Method{"nested", &nested},
                                  Method{"scalar", &scalar}};
  const auto* found = std::ranges::find(methods, method, &Method::name);
  return found == methods.end() ? nullptr : found->codec;
}

}  // namespace tintree::codec
