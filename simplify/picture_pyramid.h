#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "cache/manifest.h"
#include "cache/picture_rows.h"
#include "cache/tile_store.h"
#include "codec/error.h"
#include "codec/stop_flag.h"
#include "codec/tile_id.h"
#include "simplify/picture_layer.h"
#include "simplify/tree_builder.h"

namespace tintree::simplify {

/// What the pictures of a kind come to.
struct PictureSummary {
  std::uint64_t pictures = 0;
  std::uint64_t bytes = 0;  ///< Payloads.
  std::uint64_t made = 0;   ///< In this run, not in one that it went on with.
  double make_seconds = 0;  ///< Spent on them by all threads together.
};

/// The squares with pictures, level by level from the root's: those of the tiles, which alone are handed in, and those
/// that leaves are halved to while the layer has finer ones.
std::vector<std::vector<codec::TileId>> list_pictures(cache::PictureKind kind, const cache::Manifest& manifest,
                                                      const PictureLayer& layer, std::vector<codec::TileId> tiles);

/// Makes the layer of a thread.
using MakeLayer = std::function<std::unique_ptr<PictureLayer>()>;

/// Gives every tile of `writer` its picture of this kind (Wahl et al. 2004, section 4, Textures), and leaves the finer
/// ones on smaller squares that their photos are good for, level by level from the finest, over all threads of the
/// current oneTBB arena, and commits each. A coarser picture is filtered from the finer ones as they are stored, its
/// children and what of their neighbours the filter reaches, so that pictures are the same at any number of threads and
/// after any stop, and neighbours agree on the nodes that they share. Memory a thread: 16 bytes for each of about four
/// pictures' texels. kStopped soon after `stop` is set (null: never).
Expected<PictureSummary> make_pictures(cache::PictureKind kind, const MakeLayer& make_layer,
                                       const cache::Manifest& manifest, cache::TileWriter& writer,
                                       const ProgressFn& progress, const StopFlag* stop = nullptr);

}  // namespace tintree::simplify
