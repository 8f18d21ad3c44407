#pragma once

#include "cache/occluder.h"
#include "cache/tile_bounds.h"
#include "render/camera.h"
#include "render/frustum.h"
#include "render/occlusion.h"

namespace tintree::render {

/// What a cut of one tree has drawn so far, and which of the tree's nodes that hides: a Horizon together with the
/// eye's place over the tree and the tree's holes. lod_cut tells it of every node that its walk ends at, front to
/// back. Copying it is how a walk takes back what it has added; bounds, camera and frustum must outlive it.
class TreeHorizon {
 public:
  /// One that hides nothing.
  TreeHorizon() = default;
  /// `morph`: tiles are drawn on their way to their parents (render/morph.h). `off_px`: CutOptions::off_px.
  TreeHorizon(const cache::TileBounds& bounds, const Camera& camera, const Frustum& frustum, bool morph, double off_px);

  /// A node is hidden with its box, or with the boxes of those below it, which fit closer.
  bool hides(const cache::TileNode& node) const;

  /// `node` is outside the picture.
  void pass_unseen(const cache::TileNode& node);
  /// The raster has samples in this quadrant of `node`, or none, but the tree no tile.
  void pass_missing(const cache::TileNode& node, int quadrant);
  /// A tile is lost. Where it leaves a hole for good, what comes behind hides nothing; where an ancestor stands in,
  /// the walk takes this back.
  void pass_lost() { horizon_.place_eye(false); }
  /// A tile is drawn, `morph` of the way to its parent. Without an occluder it hides nothing.
  void add(const cache::TileNode& node, const cache::Occluder* occluder, double morph);

 private:
  bool hides(const cache::TileNode& node, const cache::Box& box, double error_m, int look_below) const;
  cache::Box box_of(const cache::TileNode& node) const;
  bool holds_eye(const codec::CellRect& cells) const;
  bool is_hole(const cache::TileNode& node, int quadrant) const;

  const cache::TileBounds* bounds_ = nullptr;
  const Camera* camera_ = nullptr;
  const Frustum* frustum_ = nullptr;
  bool morph_ = false;
  double eye_column_ = 0;
  double eye_row_ = 0;
  Horizon horizon_;
};

}  // namespace tintree::render
