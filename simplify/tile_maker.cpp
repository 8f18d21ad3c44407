#include "simplify/tile_maker.h"

#include <algorithm>
#include <array>

#include "simplify/nested_maker.h"
#include "simplify/scalar_maker.h"
#include "simplify/strip_maker.h"
#include "simplify/tin_maker.h"
#include "simplify/wavelet_maker.h"

namespace tintree::simplify {
namespace {

using MakerPtr = std::unique_ptr<TileMaker>;

struct Method {
  std::string_view name;
  MakerPtr (*make)(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop);
};

template <typename Maker>
MakerPtr make(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop) {
  return std::make_unique<Maker>(surface, manifest.layout, effort_named(manifest.effort), stop);
}

MakerPtr make_nested(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop) {
  return std::make_unique<NestedMaker>(surface, manifest.layout, stop);
}

MakerPtr make_wavelet(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop) {
  return std::make_unique<WaveletMaker>(surface, manifest.layout, codec::criterion_named(manifest.criterion), stop);
}

MakerPtr make_scalar(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop) {
  return std::make_unique<ScalarMaker>(surface, manifest.layout, codec::quantizer_named(manifest.quantizer), stop);
}

/// One row a method, as in codec/mesh_codec.cpp.
constexpr std::array kMethods{Method{"tin", make<TinMaker>}, Method{"strip", make<StripMaker>},
                              Method{"nested", make_nested}, Method{"wavelet", make_wavelet},
                              Method{"scalar", make_scalar}};

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names;
  for (const Method& method : kMethods) names.emplace_back(method.name);
  return names;
}

MakerPtr make_tile_maker(const cache::Manifest& manifest, const ReferenceSurface& surface, const StopFlag* stop) {
  const auto* found = std::ranges::find(kMethods, manifest.method, &Method::name);
  return found == kMethods.end() ? nullptr : found->make(manifest, surface, stop);
}

}  // namespace tintree::simplify
