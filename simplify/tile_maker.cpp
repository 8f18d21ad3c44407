#include "simplify/tile_maker.h"

#include "simplify/tin_maker.h"

namespace tintree::simplify {

std::unique_ptr<TileMaker> make_tile_maker(std::string_view method, const ReferenceSurface& surface,
                                           const codec::TreeLayout& layout, Effort effort, const StopFlag* stop) {
  if (method == "tin") return std::make_unique<TinMaker>(surface, layout, effort, stop);
  return nullptr;
}

}  // namespace tintree::simplify
