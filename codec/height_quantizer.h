#pragma once

#include <cstdint>
#include <vector>

namespace tintree::codec {

/// What a tile's heights are quantised by as its payload says (Fowler et al., section 2): the height of an index, in
/// height steps.
struct HeightQuantizer {
  std::int32_t low = 0;   ///< Uniform: of index 0,
  std::int32_t step = 1;  ///< and from an index to the next.
  /// Lloyd-Max: of every index, rising, equal ones allowed; empty for a uniform quantiser.
  std::vector<std::int32_t> table{};
};

}  // namespace tintree::codec
