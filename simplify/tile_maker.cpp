#include "simplify/tile_maker.h"

#include <algorithm>
#include <array>

#include "simplify/nested_maker.h"
#include "simplify/scalar_maker.h"
#include "simplify/strip_maker.h"
#include "simplify/tin_maker.h"

namespace tintree::simplify {
namespace {

struct Method {
  std::string_view name;
  std::unique_ptr<TileMaker> (*make)(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                                     const StopFlag* stop, codec::QuantizerKind quantizer);
};

template <typename Maker>
std::unique_ptr<TileMaker> make(const ReferenceSurface& surface, const codec::TreeLayout& layout, Effort effort,
                                const StopFlag* stop, codec::QuantizerKind /*quantizer*/) {
  return std::make_unique<Maker>(surface, layout, effort, stop);
}

std::unique_ptr<TileMaker> make_scalar(const ReferenceSurface& surface, const codec::TreeLayout& layout,
                                       Effort /*effort*/, const StopFlag* stop, codec::QuantizerKind quantizer) {
  return std::make_unique<ScalarMaker>(surface, layout, quantizer, stop);
}

/// One row a method, as in codec/mesh_codec.cpp.
constexpr std::array kMethods{Method{"tin", make<TinMaker>}, Method{"strip", make<StripMaker>},
                              Method{"nested", make<NestedMaker>}, Method{"scalar", make_scalar}};

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : kMethods) names.emplace_back(method.name);
  return names;
}

std::unique_ptr<TileMaker> make_tile_maker(std::string_view method, const ReferenceSurface& surface,
                                           const codec::TreeLayout& layout, Effort effort, const StopFlag* stop,
                                           codec::QuantizerKind quantizer) {
  const auto* found = std::ranges::find(kMethods, method, &Method::name);
  return found == kMethods.end() ? nullptr : found->make(surface, layout, effort, stop, quantizer);
}

}  // namespace tintree::simplify
