#include "apps/build/plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "apps/build/input.h"
#include "apps/common/json_file.h"
#include "apps/common/program.h"
#include "apps/common/progress.h"
#include "apps/common/stop_deadline.h"
#include "apps/common/whole_file.h"
#include "cache/packed_size.h"
#include "simplify/sample_tiles.h"
#include "simplify/stored_tile.h"

namespace tintree::app {
namespace {

using Clock = std::chrono::steady_clock;
using simplify::LevelSample;
using simplify::LevelSummary;
using simplify::SampledTile;

double seconds_since(Clock::time_point begun) { return std::chrono::duration<double>(Clock::now() - begun).count(); }

/// Wall time to read the DEM once and summarise its blocks, judged by the row of blocks in its middle.
Expected<double> estimate_reading(const Input& input) {
  const cache::HeightBlocks& blocks = *input.blocks;
  constexpr std::int64_t kMostBlocks = 64;
  const std::int64_t width = std::min(blocks.blocks_x(), kMostBlocks) * cache::kBlockCells + 1;
  std::vector<double> band(static_cast<std::size_t>(width * cache::kBlockSamples));
  const auto begun = Clock::now();
  const std::int64_t row = blocks.blocks_y() / 2 * cache::kBlockCells;
  if (auto read = blocks.source().read(0, row, width, cache::kBlockSamples, band.data()); !read) {
    return tl::unexpected(read.error());
  }
  const double share = static_cast<double>(blocks.columns()) * static_cast<double>(blocks.rows()) /
                       static_cast<double>(std::min(width, blocks.columns())) /
                       static_cast<double>(std::min<std::int64_t>(cache::kBlockSamples, blocks.rows() - row));
  return seconds_since(begun) * share;
}

/// Sums of the sample's tiles, scaled to all cells of the level.
LevelSummary scaled(const LevelSample& sample, double bound_m) {
  LevelSummary sum{.level = sample.level, .tiles = sample.tiles, .bound_m = bound_m};
  const double factor = static_cast<double>(sample.cells) / static_cast<double>(sample.sampled_cells);
  double vertices = 0;
  double triangles = 0;
  double bytes = 0;
  for (const SampledTile& tile : sample.sample) {
    vertices += static_cast<double>(tile.vertices);
    triangles += static_cast<double>(tile.triangles);
    bytes += static_cast<double>(tile.bytes);
    sum.make_seconds += tile.make_seconds * factor;
  }
  sum.vertices = static_cast<std::uint64_t>(vertices * factor);
  sum.triangles = static_cast<std::uint64_t>(triangles * factor);
  sum.bytes = static_cast<std::uint64_t>(bytes * factor);
  return sum;
}

/// Judges a level without a sample: from level to level its figures change as they do, on average, between the sampled
/// levels from `top` to the leaves.
LevelSummary extrapolated(const LevelSample& sample, const std::vector<LevelSummary>& levels, std::size_t top,
                          double bound_m) {
  const auto steps = static_cast<double>(levels.size() - 1 - top);
  const double up = static_cast<double>(top) - sample.level;
  const auto follow = [&](auto figure) {
    const auto first = static_cast<double>(figure(levels[top]));
    const auto last = static_cast<double>(figure(levels.back()));
    return first <= 0 || last <= 0 || steps == 0 ? first : first * std::pow(first / last, up / steps);
  };
  const auto count = [&](auto figure) { return static_cast<std::uint64_t>(follow(figure)); };
  LevelSummary out{.level = sample.level, .tiles = sample.tiles, .bound_m = bound_m};
  out.vertices = count([](const LevelSummary& l) { return l.vertices; });
  out.triangles = count([](const LevelSummary& l) { return l.triangles; });
  out.bytes = count([](const LevelSummary& l) { return l.bytes; });
  out.make_seconds = follow([](const LevelSummary& l) { return l.make_seconds; });
  return out;
}

/// Wall time of the tiles, taken one after the other by the thread that is free first.
double schedule(const codec::TreeLayout& layout, const std::vector<LevelSummary>& levels, int threads) {
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (int t = 0; t < threads; ++t) free_at.push(0);
  double end = 0;
  for (const codec::TileId& id : simplify::list_tiles(layout)) {
    const LevelSummary& level = levels[static_cast<std::size_t>(id.level)];
    const double done = free_at.top() + level.make_seconds / static_cast<double>(level.tiles);
    free_at.pop();
    free_at.push(done);
    end = std::max(end, done);
  }
  return end;
}

/// What the tiles come to in the file: each level's have the sizes of its sample, or all the same size.
cache::PackedSize tiles_size(const std::vector<LevelSample>& samples, const std::vector<LevelSummary>& levels) {
  cache::PackedSize size;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const std::vector<SampledTile>& sample = samples[l].sample;
    double sampled = 0;
    for (const SampledTile& tile : sample) sampled += static_cast<double>(tile.bytes);
    const double mean = static_cast<double>(levels[l].bytes) / static_cast<double>(levels[l].tiles);
    const double scale = sampled > 0 ? mean * static_cast<double>(sample.size()) / sampled : 0;
    for (std::uint64_t i = 0; i < levels[l].tiles; ++i) {
      const double bytes = sample.empty() ? mean : scale * static_cast<double>(sample[i % sample.size()].bytes);
      if (bytes > 0) size.add(static_cast<std::uint64_t>(bytes));
    }
  }
  return size;
}

/// Processor time of the measuring pass: every leaf's window is loaded once and every level measured in it.
double measuring_seconds(const LevelSample& leaves, std::size_t levels) {
  double seconds = 0;
  for (const SampledTile& tile : leaves.sample) {
    seconds += tile.load_seconds + static_cast<double>(levels) * tile.measure_seconds;
  }
  return seconds * static_cast<double>(leaves.cells) / static_cast<double>(leaves.sampled_cells);
}

/// Vertices of the `threads` largest tiles together, of so many tiles of so many vertices.
double largest_at_once(std::vector<std::pair<double, std::uint64_t>> vertices_and_count, int threads) {
  std::ranges::sort(vertices_and_count, std::greater<>());
  double sum = 0;
  auto left = static_cast<std::uint64_t>(threads);
  for (const auto& [vertices, count] : vertices_and_count) {
    const std::uint64_t taken = std::min(left, count);
    sum += vertices * static_cast<double>(taken);
    left -= taken;
  }
  return sum;
}

/// Peak memory: what the process had before the sample, the whole cache, the residual pyramid, and the work on tiles.
/// That grew by `sampled_bytes` under the sample, and goes with the tiles' vertices.
std::uint64_t estimate_memory(const Input& input, std::uint64_t before_bytes, std::uint64_t sampled_bytes,
                              const TreePlan& plan) {
  std::vector<std::pair<double, std::uint64_t>> in_sample;
  std::vector<std::pair<double, std::uint64_t>> in_tree;
  for (const TreePlan::Level& level : plan.levels) {
    const double mean = static_cast<double>(level.estimate.vertices) / static_cast<double>(level.estimate.tiles);
    in_sample.emplace_back(mean, level.sampled);
    in_tree.emplace_back(mean, level.estimate.tiles);
  }
  const double sampled = largest_at_once(std::move(in_sample), plan.threads);
  const double ratio = sampled > 0 ? largest_at_once(std::move(in_tree), plan.threads) / sampled : 1;
  const auto all = static_cast<std::uint64_t>(input.blocks->blocks_x() * input.blocks->blocks_y()) *
                   cache::kBlockStride * cache::kBlockSamples * sizeof(float);
  return before_bytes + std::min(all, input.memory.blocks_bytes) + input.memory.pyramid_bytes +
         static_cast<std::uint64_t>(static_cast<double>(sampled_bytes) * std::max(ratio, 1.0));
}

/// Whether all leaves have been made, and none has a triangle: a build refuses such a DEM.
bool holds_no_surface(const std::vector<LevelSample>& samples) {
  const LevelSample& leaves = samples.back();
  return leaves.sampled_cells == leaves.cells &&
         std::ranges::all_of(leaves.sample, [](const SampledTile& tile) { return tile.triangles == 0; });
}

Expected<TreePlan> plan_in_arena(const BuildOptions& options) {
  const auto begun = Clock::now();
  Progress line(options.quiet);
  const auto progress = [&](const std::string& step, std::uint64_t done, std::uint64_t total) {
    line.report(step, done, total);
    return !stop_requested();
  };
  if (!options.output.empty()) {
    if (auto writable = check_output_file(options.output); !writable) return tl::unexpected(writable.error());
  }
  auto input = open_input(options, progress);
  if (!input) return tl::unexpected(input.error());
  const double opening_seconds = seconds_since(begun);
  const auto photos = open_photos(options, input->info, progress);
  if (!photos) return tl::unexpected(photos.error());
  cache::Manifest manifest = describe_tree(options, input->info, *photos);
  TreePlan plan;
  plan.threads = thread_count(options);
  plan.samples = static_cast<std::uint64_t>(input->info.columns) * static_cast<std::uint64_t>(input->info.rows);
  auto reading = estimate_reading(*input);
  if (!reading) return tl::unexpected(reading.error());
  plan.read_seconds = opening_seconds + *reading;
  const std::uint64_t before = peak_rss_bytes();
  auto samples = simplify::sample_tiles(input->blocks, manifest, stop_flag());
  if (!samples) {
    if (samples.error().where.empty()) samples.error().where = input->info.path;
    return tl::unexpected(samples.error());
  }
  const std::uint64_t grown = peak_rss_bytes() - before;
  if (holds_no_surface(*samples)) {
    return fail(ErrorCode::kBadData, "holds no surface: nowhere do three samples of a cell have heights",
                input->info.path);
  }

  const auto top = static_cast<std::size_t>(
      std::ranges::find_if(*samples, [](const LevelSample& s) { return !s.sample.empty(); }) - samples->begin());
  std::vector<LevelSummary> levels(samples->size());
  for (std::size_t l = samples->size(); l-- > 0;) {
    const double bound_m = manifest.layout.bound_m(static_cast<int>(l));
    levels[l] = l >= top ? scaled((*samples)[l], bound_m) : extrapolated((*samples)[l], levels, top, bound_m);
    plan.total.tiles += levels[l].tiles;
    plan.total.vertices += levels[l].vertices;
    plan.total.triangles += levels[l].triangles;
    plan.total.bytes += levels[l].bytes;
    plan.total.make_seconds += levels[l].make_seconds;
  }
  for (std::size_t l = 0; l < levels.size(); ++l) plan.levels.push_back({levels[l], (*samples)[l].sample.size()});
  plan.make_seconds = schedule(manifest.layout, levels, plan.threads);
  plan.measure_seconds = measuring_seconds(samples->back(), levels.size()) / plan.threads;
  auto textures = plan_textures(manifest, *photos);
  if (!textures) return tl::unexpected(textures.error());
  auto normals = plan_normals(manifest, input->blocks, stop_flag());
  if (!normals) return tl::unexpected(normals.error());
  plan.textures = *textures;
  plan.texture_depth = manifest.texture_depth;
  plan.normals = *normals;
  plan.picture_seconds = (textures->make_seconds + normals->make_seconds) / plan.threads;
  plan.seconds = plan.read_seconds + plan.make_seconds + plan.picture_seconds + plan.measure_seconds;
  plan.bytes = (tiles_size(*samples, levels) += textures->size += normals->size).bytes();
  const std::uint64_t cached = std::min(input->blocks->cached_bytes(), grown);
  plan.peak_rss_bytes = estimate_memory(*input, before, grown - cached, plan);
  plan.plan_seconds = seconds_since(begun);
  return plan;
}

}  // namespace

Expected<TreePlan> plan_tree(const BuildOptions& options) {
  const Error stopped{ErrorCode::kStopped, "stopped; a plan writes nothing", options.dems.front()};
  const StopDeadline deadline("tintree-build", stopped);
  const int threads = thread_count(options);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  auto plan = arena.execute([&] { return plan_in_arena(options); });
  if (!plan && plan.error().code == ErrorCode::kStopped) return tl::unexpected(stopped);
  return plan;
}

}  // namespace tintree::app
