#include "tests/support/regular_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "cache/height_blocks.h"
#include "cache/samples_digest.h"
#include "codec/mesh_codec.h"
#include "tests/support/naive_measure.h"

namespace tintree::test {
namespace {

template <typename T>
T value_of(Expected<T> expected) {
  if (!expected) throw std::runtime_error(expected.error().text());
  if constexpr (!std::is_void_v<T>) return std::move(*expected);
}

using Sample = std::pair<std::int64_t, std::int64_t>;

/// Every stride-th sample of [first, last], and the last.
std::vector<std::int64_t> stations(std::int64_t first, std::int64_t last, std::int64_t stride) {
  std::vector<std::int64_t> out;
  for (std::int64_t k = first; k < last; k += stride) out.push_back(k);
  out.push_back(last);
  return out;
}

class MeshMaker {
 public:
  MeshMaker(const HeightGrid& grid, const cache::Manifest& manifest, const RegularTreeOptions& options)
      : grid_(grid), layout_(manifest.layout), options_(options) {
    holes_ = std::ranges::any_of(grid.heights_m, [](double h) { return std::isnan(h); });
  }

  codec::TileMesh make(const codec::TileId& id) {
    cells_ = layout_.cells(id);
    mesh_ = {};
    mesh_.xy_shift = options_.xy_shift;
    step_m_ = layout_.z_step_m[static_cast<std::size_t>(id.level)];
    const std::int64_t stride = options_.coarsen && !holes_ ? layout_.cells_across(id.level) / layout_.tile_cells : 1;
    mesh_.z_offset = lowest();
    index_.clear();
    const auto columns = stations(cells_.column0, cells_.column1, stride);
    const auto rows = stations(cells_.row0, cells_.row1, stride);
    for (std::size_t j = 0; j + 1 < rows.size(); ++j) {
      for (std::size_t i = 0; i + 1 < columns.size(); ++i) {
        add_cell(columns[i], rows[j], columns[i + 1], rows[j + 1]);
      }
    }
    split_pinches();
    return mesh_;
  }

 private:
  std::int64_t lattice(double height) const { return std::llround(height / step_m_); }

  std::int64_t lowest() const {
    std::int64_t low = std::numeric_limits<std::int64_t>::max();
    for (std::int64_t r = cells_.row0; r <= cells_.row1; ++r) {
      for (std::int64_t c = cells_.column0; c <= cells_.column1; ++c) {
        if (!std::isnan(grid_.at(c, r))) low = std::min(low, lattice(grid_.at(c, r)));
      }
    }
    return low;
  }

  std::uint32_t vertex(std::int64_t c, std::int64_t r) {
    const auto [at, added] = index_.try_emplace({c, r}, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (added) {
      const std::int64_t scale = std::int64_t{1} << -options_.xy_shift;
      mesh_.vertices.push_back({static_cast<std::int32_t>((c - cells_.column0) * scale),
                                static_cast<std::int32_t>((r - cells_.row0) * scale),
                                static_cast<std::int32_t>(lattice(grid_.at(c, r)) - mesh_.z_offset)});
    }
    return at->second;
  }

  void add_cell(std::int64_t c0, std::int64_t r0, std::int64_t c1, std::int64_t r1) {
    const bool nw = !std::isnan(grid_.at(c0, r0)) && !std::isnan(grid_.at(c1, r1));
    if (nw && !std::isnan(grid_.at(c0, r1))) {
      mesh_.triangles.push_back({vertex(c0, r0), vertex(c0, r1), vertex(c1, r1)});
    }
    if (nw && !std::isnan(grid_.at(c1, r0))) {
      mesh_.triangles.push_back({vertex(c0, r0), vertex(c1, r1), vertex(c1, r0)});
    }
  }

  /// Gives every fan of triangles around a vertex, but the first, a vertex of its own.
  void split_pinches() {
    std::map<std::uint32_t, std::vector<std::pair<std::size_t, std::size_t>>> corners;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) corners[mesh_.triangles[t][k]].push_back({t, k});
    }
    for (auto& [v, around] : corners) {
      bool first = true;
      while (!around.empty()) {
        const auto fan = take_fan(around);
        if (!first) {
          const auto copy = static_cast<std::uint32_t>(mesh_.vertices.size());
          mesh_.vertices.push_back(mesh_.vertices[v]);
          for (const auto& [t, k] : fan) mesh_.triangles[t][k] = copy;
        }
        first = false;
      }
    }
  }

  using Corners = std::vector<std::pair<std::size_t, std::size_t>>;

  /// Moves one edge-connected fan out of the corners around a vertex.
  Corners take_fan(Corners& around) const {
    const auto neighbours = [this](const auto& corner) {
      const codec::Triangle& t = mesh_.triangles[corner.first];
      return std::pair{t[(corner.second + 1) % 3], t[(corner.second + 2) % 3]};
    };
    Corners fan{around.back()};
    around.pop_back();
    for (std::size_t done = 0; done < fan.size(); ++done) {
      const auto [a, b] = neighbours(fan[done]);
      for (std::size_t i = 0; i < around.size();) {
        const auto [c, d] = neighbours(around[i]);
        if (a == d || b == c) {
          fan.push_back(around[i]);
          around.erase(around.begin() + static_cast<std::ptrdiff_t>(i));
        } else {
          ++i;
        }
      }
    }
    return fan;
  }

  const HeightGrid& grid_;
  codec::TreeLayout layout_;
  RegularTreeOptions options_;
  codec::CellRect cells_;
  codec::TileMesh mesh_;
  double step_m_ = 1;
  bool holes_ = false;
  std::map<Sample, std::uint32_t> index_;
};

std::string samples_digest(const cache::RasterSource& source) {
  cache::HeightBlocks blocks(std::shared_ptr<const cache::RasterSource>(std::shared_ptr<void>(), &source), 0);
  cache::SamplesDigest digest(blocks);
  value_of(blocks.stream([&digest](std::int64_t bx, std::int64_t by, const auto& block) {
    digest.add(bx, by, *block);
    return true;
  }));
  return digest.text();
}

cache::Manifest make_manifest(const cache::RasterSource& source, const RegularTreeOptions& options) {
  const cache::RasterInfo& info = source.info();
  cache::Manifest m;
  m.layout.columns = info.columns;
  m.layout.rows = info.rows;
  m.layout.tile_cells = options.tile_cells;
  m.layout.levels_per_doubling = options.levels_per_doubling;
  m.layout.leaf_level =
      codec::TreeLayout::leaf_level_for(info.columns, info.rows, options.tile_cells, options.levels_per_doubling);
  m.layout.dx_m = info.dx_m;
  m.layout.dy_m = info.dy_m;
  m.layout.axes = info.axes;
  m.layout.leaf_error_m = options.leaf_error_m > 0 ? options.leaf_error_m : 1;
  m.layout.z_step_m.assign(static_cast<std::size_t>(m.layout.leaf_level) + 1, options.z_step_m);
  m.crs_wkt = info.crs_wkt;
  m.geotransform = info.geotransform;
  m.geographic = info.geographic;
  m.height_unit_m = info.height_unit_m;
  m.inputs = info.inputs;
  m.samples_digest = samples_digest(source);
  return m;
}

}  // namespace

cache::StoredTile& TestTree::tile(const codec::TileId& id) {
  const auto at = std::ranges::find_if(tiles, [&](const auto& t) { return t.info.id == id; });
  if (at == tiles.end()) throw std::runtime_error("no tile " + id.text());
  return *at;
}

codec::TileMesh TestTree::mesh(const codec::TileId& id) const {
  return value_of(cache::TileDecoder(manifest, {}).decode(const_cast<TestTree*>(this)->tile(id)));
}

void TestTree::set_mesh(const codec::TileId& id, const codec::TileMesh& mesh) {
  tile(id).payload = value_of(codec::find_codec(manifest.method)->encode(mesh));
}

TestTree make_regular_tree(const cache::RasterSource& source, const RegularTreeOptions& options) {
  const HeightGrid grid = read_grid(source);
  TestTree tree;
  tree.manifest = make_manifest(source, options);
  codec::TreeLayout& layout = tree.manifest.layout;
  MeshMaker maker(grid, tree.manifest, options);
  double needed = 0;
  for (int level = 0; level <= layout.leaf_level; ++level) {
    for (std::uint32_t y = 0; y < layout.tiles_y(level); ++y) {
      for (std::uint32_t x = 0; x < layout.tiles_x(level); ++x) {
        const codec::TileId id{level, x, y};
        const codec::TileMesh made = maker.make(id);
        if (made.triangles.empty()) continue;
        cache::StoredTile tile;
        tile.info.id = id;
        tile.payload = value_of(codec::find_codec("tin")->encode(made));
        const codec::TileMesh mesh = value_of(cache::TileDecoder(tree.manifest, {}).decode(tile));
        const NaiveFigures f = naive_figures(grid, layout, id, mesh);
        tile.info = {id,
                     static_cast<std::uint32_t>(mesh.vertices.size()),
                     static_cast<std::uint32_t>(mesh.triangles.size()),
                     f.z_min_m,
                     f.z_max_m,
                     f.error_m,
                     f.rms_m,
                     f.border_error_m};
        needed = std::max(needed, f.error_m * layout.leaf_error_m / layout.bound_m(level));
        tree.tiles.push_back(std::move(tile));
      }
    }
  }
  std::ranges::sort(tree.tiles, {}, [](const cache::StoredTile& t) { return t.info.id.key(); });
  if (options.leaf_error_m <= 0) layout.leaf_error_m = needed > 0 ? needed : 1;
  return tree;
}

TestTree make_regular_tree(const std::string& raster, const RegularTreeOptions& options) {
  return make_regular_tree(value_of(cache::RasterSource::open(raster)), options);
}

void write_tree(const std::string& path, const TestTree& tree) {
  auto writer = value_of(cache::TileWriter::create(path, tree.manifest));
  for (const cache::StoredTile& tile : tree.tiles) value_of(writer.put(tile));
  value_of(writer.finish());
}

}  // namespace tintree::test
