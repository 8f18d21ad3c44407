#include "codec/mesh_codec.h"

#include "codec/draco_mesh.h"

namespace tintree::codec {

const MeshCodec* find_codec(std::string_view method) {
  static const DracoMesh tin;
  return method == "tin" ? &tin : nullptr;
}

}  // namespace tintree::codec
