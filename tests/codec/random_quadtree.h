#pragma once

#include <random>

#include "codec/tile_mesh.h"

namespace tintree::test {

/// What a made-up restricted quadtree mesh should look like.
struct QuadtreeSpec {
  int levels = 4;          ///< Its square is 2^levels steps wide.
  int splits = 20;         ///< Points that are asked to be split.
  int height_range = 100;  ///< Heights are 0 to this, in multiples of height_unit.
  int height_unit = 1;
  double missing = 0;  ///< Chance of a vertex to be missing, with its triangles: holes.
};

/// One made without the code under test: bisected triangle by triangle, until no side of one has a vertex in its
/// middle. Vertices that several fans share are repeated.
codec::TileMesh random_quadtree(std::mt19937& random, const QuadtreeSpec& spec);

}  // namespace tintree::test
