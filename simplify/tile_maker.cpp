#include "simplify/tile_maker.h"

#include <algorithm>
#include <array>

#include "simplify/strip_maker.h"
#include "simplify/tin_maker.h"

namespace tintree::simplify {
namespace {

struct Method {
  std::string_view name;
  std::unique_ptr<TileMaker> (*make)(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                                     const StopFlag* stop);
};

template <typename Maker>
std::unique_ptr<TileMaker> make(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                                const StopFlag* stop) {
  return std::make_unique<Maker>(surface, layout, effort, stop);
}

/// One row a method, as in codec/mesh_codec.cpp.
constexpr std::array kMethods{Method{"tin", make<TinMaker>}, Method{"strip", make<StripMaker>},
                              Method{"strip-coded", make<StripMaker>}};

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : kMethods) names.emplace_back(method.name);
  return names;
}

std::unique_ptr<TileMaker> make_tile_maker(std::string_view method, const ReferenceSurface& surface,
                                           const codec::TreeLayout& layout, Effort effort, const StopFlag* stop) {
  const auto* found = std::ranges::find(kMethods, method, &Method::name);
  return found == kMethods.end() ? nullptr : found->make(surface, layout, effort, stop);
}

}  // namespace tintree::simplify
