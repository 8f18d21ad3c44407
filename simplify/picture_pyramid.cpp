#include "simplify/picture_pyramid.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <ranges>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace tintree::simplify {
namespace {

using codec::TileId;
using Payload = std::vector<std::byte>;

struct MadePicture {
  TileId id;
  Expected<Payload> payload;
  double seconds = 0;
};

class Pyramid {
 public:
  Pyramid(cache::PictureKind kind, const MakeLayer& make_layer, const cache::Manifest& manifest,
          cache::TileWriter& writer, const ProgressFn& progress, const StopFlag* stop)
      : kind_(kind),
        manifest_(&manifest),
        squares_(manifest.picture_layout(kind)),
        writer_(&writer),
        progress_(&progress),
        stop_(stop),
        across_(manifest.picture_size(kind) - 1),
        layers_(make_layer) {}

  Expected<PictureSummary> run() {
    const auto tiles = writer_->keys();
    if (!tiles) return tl::unexpected(tiles.error());
    const auto present = writer_->picture_keys(kind_);
    if (!present) return tl::unexpected(present.error());
    const std::unordered_set<std::int64_t> done_before(present->begin(), present->end());
    std::vector<TileId> ids;
    for (const std::int64_t key : *tiles) ids.push_back(TileId::from_key(key));
    auto levels = list_pictures(kind_, *manifest_, *layers_.local(), std::move(ids));
    for (const auto& level : levels) total_ += level.size();
    done_ = done_before.size();
    for (auto& todo : levels | std::views::reverse) {
      std::erase_if(todo, [&](const TileId& id) { return done_before.contains(id.key()); });
      if (auto made = make_level(todo); !made) return tl::unexpected(made.error());
    }
    if (auto counted = count(); !counted) return tl::unexpected(counted.error());
    return summary_;
  }

 private:
  Expected<void> make_level(const std::vector<TileId>& todo);
  MadePicture make(const TileId& id, PictureLayer& layer);
  Expected<NodeValues> make_parent(const TileId& id, const PictureLayer& layer);
  Expected<void> keep(const MadePicture& made);
  Expected<std::optional<Payload>> read(const TileId& id) {
    const std::scoped_lock lock(turn_);
    return writer_->read_picture(kind_, id);
  }
  Expected<void> count();

  cache::PictureKind kind_;
  const cache::Manifest* manifest_;
  const codec::TreeLayout squares_;
  cache::TileWriter* writer_;
  const ProgressFn* progress_;
  const StopFlag* stop_;
  int across_;  ///< Nodes from a tile to the next.
  tbb::enumerable_thread_specific<std::unique_ptr<PictureLayer>> layers_;
  std::mutex turn_;  ///< Guards the writer.
  PictureSummary summary_;
  std::uint64_t done_ = 0;
  std::uint64_t total_ = 0;
};

Expected<void> Pyramid::make_level(const std::vector<TileId>& todo) {
  std::size_t next = 0;
  std::size_t left = todo.size();
  std::atomic<bool> halt = false;
  std::optional<Error> error;
  const auto tokens = static_cast<std::size_t>(2 * tbb::this_task_arena::max_concurrency());
  tbb::parallel_pipeline(
      tokens,
      tbb::make_filter<void, TileId>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
        if (halt || is_set(stop_) || next == todo.size()) {
          control.stop();
          return TileId{};
        }
        return todo[next++];
      }) & tbb::make_filter<TileId, MadePicture>(tbb::filter_mode::parallel, [&](const TileId& id) {
        return make(id, *layers_.local());
      }) & tbb::make_filter<MadePicture, void>(tbb::filter_mode::serial_out_of_order, [&](const MadePicture& made) {
        if (auto kept = keep(made); !kept) {
          if (!error) error = kept.error();
          halt = true;
          return;
        }
        --left;
        const std::string step = std::string(cache::picture_name(kind_)) + "s";
        if (!(*progress_)(step, ++done_, total_)) halt = true;
      }));
  if (error) return tl::unexpected(*error);
  if (left > 0) return fail(ErrorCode::kStopped, "stopped");
  return {};
}

MadePicture Pyramid::make(const TileId& id, PictureLayer& layer) {
  const auto begun = std::chrono::steady_clock::now();
  auto values = layer.has_finer(id) ? make_parent(id, layer) : layer.make_leaf(id);
  MadePicture out{id, values ? layer.encode(*values) : tl::unexpected(values.error())};
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return out;
}

/// Filters the finer level round the tile. Where several tiles hold a node, it has the mean of what they say.
Expected<NodeValues> Pyramid::make_parent(const TileId& id, const PictureLayer& layer) {
  const int reach = layer.filter().reach;
  const int side = 2 * across_ + 1 + 2 * reach;
  const int level = squares_.coarsest_level(squares_.halvings(id.level) + 1);
  NodeValues fine(side, side);
  std::vector<std::uint8_t> holders(fine.values.size());
  for (int ty = -1; ty <= 2; ++ty) {
    for (int tx = -1; tx <= 2; ++tx) {
      const std::int64_t x = 2 * std::int64_t{id.x} + tx;
      const std::int64_t y = 2 * std::int64_t{id.y} + ty;
      if (x < 0 || y < 0 || x >= squares_.tiles_x(level) || y >= squares_.tiles_y(level)) continue;
      const TileId child{level, static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
      const auto payload = read(child);
      if (!payload) return tl::unexpected(payload.error());
      if (!*payload) continue;
      const auto values = layer.decode(**payload);
      if (!values) {
        return fail(values.error().code, values.error().message,
                    fmt::format("{} of tile {}", cache::picture_name(kind_), child.text()));
      }
      // The child's first node in the window, and which of its nodes lie there.
      const int x0 = tx * across_ + reach;
      const int y0 = ty * across_ + reach;
      for (int v = std::max(0, -y0); v <= across_ && y0 + v < side; ++v) {
        for (int u = std::max(0, -x0); u <= across_ && x0 + u < side; ++u) {
          const auto& from = values->at(u, v);
          auto& to = fine.at(x0 + u, y0 + v);
          for (std::size_t k = 0; k < 3; ++k) to[k] += from[k] * from[3];
          to[3] += from[3];
          ++holders[static_cast<std::size_t>(y0 + v) * static_cast<std::size_t>(side) +
                    static_cast<std::size_t>(x0 + u)];
        }
      }
    }
  }
  for (std::size_t i = 0; i < fine.values.size(); ++i) {
    auto& v = fine.values[i];
    if (v[3] <= 0) continue;
    for (std::size_t k = 0; k < 3; ++k) v[k] /= v[3];
    v[3] /= holders[i];
  }
  return halve(fine, layer.filter());
}

Expected<void> Pyramid::keep(const MadePicture& made) {
  if (!made.payload) return tl::unexpected(made.payload.error());
  summary_.make_seconds += made.seconds;
  if (made.payload->empty()) return {};
  ++summary_.made;
  const std::scoped_lock lock(turn_);
  auto done = writer_->put_picture(kind_, made.id, *made.payload);
  return done ? writer_->commit() : done;
}

Expected<void> Pyramid::count() {
  const auto keys = writer_->picture_keys(kind_);
  if (!keys) return tl::unexpected(keys.error());
  summary_.pictures = keys->size();
  const auto bytes = writer_->picture_bytes(kind_);
  if (!bytes) return tl::unexpected(bytes.error());
  summary_.bytes = *bytes;
  return {};
}

}  // namespace

std::vector<std::vector<TileId>> list_pictures(cache::PictureKind kind, const cache::Manifest& manifest,
                                               const PictureLayer& layer, std::vector<TileId> tiles) {
  const codec::TreeLayout squares = manifest.picture_layout(kind);
  std::erase_if(tiles, [&squares](const TileId& id) { return id != squares.picture_tile(id); });
  std::vector<std::vector<TileId>> levels(static_cast<std::size_t>(squares.leaf_level) + 1);
  for (const TileId& id : tiles) levels[static_cast<std::size_t>(id.level)].push_back(id);
  int halvings = squares.halvings(manifest.layout.leaf_level);
  for (; halvings < squares.halvings(squares.leaf_level); ++halvings) {
    const int finer = squares.coarsest_level(halvings + 1);
    for (const TileId& id : levels[static_cast<std::size_t>(squares.coarsest_level(halvings))]) {
      if (!layer.has_finer(id)) continue;
      for (int q = 0; q < 4; ++q) {
        const TileId child = squares.child({finer - 1, id.x, id.y}, q);
        if (!squares.cells(child).empty()) levels[static_cast<std::size_t>(finer)].push_back(child);
      }
    }
  }
  return levels;
}

Expected<PictureSummary> make_pictures(cache::PictureKind kind, const MakeLayer& make_layer,
                                       const cache::Manifest& manifest, cache::TileWriter& writer,
                                       const ProgressFn& progress, const StopFlag* stop) {
  return Pyramid(kind, make_layer, manifest, writer, progress, stop).run();
}

}  // namespace tintree::simplify
