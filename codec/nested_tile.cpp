#include "codec/nested_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codec/nested_payload.h"
#include "codec/triangle_fans.h"

namespace tintree::codec {
namespace {

using LevelHeights = std::array<float, NestedTile::kMostLevels - 1>;

/// How far above each point the coarser meshes are. A point is the middle of a side that lies in one triangle of every
/// level that lacks the point, so each of these meshes is there at the mean of its heights at the side's ends.
std::vector<LevelHeights> rises(const NestedPoints& points) {
  std::vector<LevelHeights> out(points.points().size(), LevelHeights{});
  for (std::size_t i = 0; i < out.size(); ++i) {
    const NestedPoint& p = points.points()[i];
    if (p.gap || p.end_a == NestedPoints::kNone) continue;
    const NestedPoint& a = points.point(p.end_a);
    const NestedPoint& b = points.point(p.end_b);
    if (a.gap || b.gap) continue;
    const float middle = static_cast<float>(a.z + b.z) / 2 - static_cast<float>(p.z);
    for (std::size_t k = 0; k < p.level; ++k) {
      out[i][k] = middle + (out[static_cast<std::size_t>(p.end_a)][k] + out[static_cast<std::size_t>(p.end_b)][k]) / 2;
    }
  }
  return out;
}

/// The exponent of a level's unit: that of a 64th of its tolerance, or of what a byte needs for `largest`.
int exponent_for(int level, int levels, float largest) {
  int exponent = levels - 1 - level - 4;
  while (std::ldexp(largest, -exponent) > 127.5F) ++exponent;
  return exponent;
}

/// Numbers the vertices of a hierarchy and orders its levels' triangles.
class FanMaker {
 public:
  explicit FanMaker(const NestedPoints& points) : points_(points), number_(points.points().size()) {
    for (std::size_t i = 0; i < number_.size(); ++i) {
      const NestedPoint& p = points.points()[i];
      if (p.gap) continue;
      number_[i] = static_cast<std::uint32_t>(out.vertex_points.size());
      out.vertex_points.push_back(static_cast<std::int32_t>(i));
      out.level_vertices.resize(p.level, number_[i]);
    }
  }

  void add_level(int level) {
    std::vector<Triangle> triangles;
    points_.for_each_triangle(level, [&](std::int32_t a, std::int32_t b, std::int32_t c) {
      triangles.push_back({number(a), number(b), number(c)});
    });
    out.level_triangles.push_back(static_cast<std::uint32_t>(triangles.size()));
    const std::size_t vertices = out.level_vertices[static_cast<std::size_t>(level)];
    out.fans.push_back(triangle_fans(triangles, hubs(triangles), vertices, NestedFans::kRestart));
  }

  NestedFans out;

 private:
  std::uint32_t number(std::int32_t point) const { return number_[static_cast<std::size_t>(point)]; }

  /// Centres of squares, small ones first, then all the rest, each in the triangles' order: where squares are whole,
  /// their centres' fans are all there is.
  std::vector<std::uint32_t> hubs(const std::vector<Triangle>& triangles) const {
    const auto unit = [this](std::uint32_t v) {
      const NestedPoint& p = points_.point(out.vertex_points[v]);
      const std::int32_t u = (p.x | p.y) & -(p.x | p.y);
      return (p.x & p.y & u) != 0 ? u : std::numeric_limits<std::int32_t>::max();
    };
    std::vector<std::uint32_t> hubs;
    std::vector<bool> listed(out.vertex_points.size());
    for (const Triangle& t : triangles) {
      for (const std::uint32_t v : {t[2], t[0], t[1]}) {
        if (!listed[v]) hubs.push_back(v);
        listed[v] = true;
      }
    }
    std::ranges::stable_sort(hubs, {}, unit);
    return hubs;
  }

  const NestedPoints& points_;
  std::vector<std::uint32_t> number_;
};

/// `all_levels`: of the payload, read or not.
void add_vertices(const NestedPoints& points, const std::vector<std::int32_t>& vertex_points, int all_levels,
                  NestedTile& tile) {
  const std::vector<LevelHeights> all = rises(points);
  LevelHeights largest{};
  for (const std::int32_t i : vertex_points) {
    const NestedPoint& p = points.point(i);
    tile.vertices.push_back({p.x, p.y, p.z});
    const LevelHeights& own = all[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < largest.size(); ++k) largest[k] = std::max(largest[k], std::abs(own[k]));
  }
  for (std::size_t k = 0; k < largest.size(); ++k) {
    tile.morph_exponent[k] = static_cast<std::int8_t>(exponent_for(static_cast<int>(k), all_levels, largest[k]));
  }
  for (const std::int32_t i : vertex_points) {
    auto& morph = tile.morphs.emplace_back();
    for (std::size_t k = 0; k < morph.size(); ++k) {
      const float rise = all[static_cast<std::size_t>(i)][k];
      morph[k] = static_cast<std::int8_t>(std::lround(std::ldexp(rise, -tile.morph_exponent[k])));
    }
  }
}

}  // namespace

double NestedTile::height(std::size_t v, int i) const {
  const auto k = static_cast<std::size_t>(i);
  const double rise = i >= levels - 1 ? 0 : std::ldexp(static_cast<double>(morphs[v][k]), morph_exponent[k]);
  return static_cast<double>(vertices[v].z) + rise;
}

NestedFans nested_fans(const NestedPoints& points, int levels) {
  FanMaker maker(points);
  maker.out.level_vertices.resize(static_cast<std::size_t>(levels),
                                  static_cast<std::uint32_t>(maker.out.vertex_points.size()));
  for (int level = 0; level < levels; ++level) maker.add_level(level);
  return std::move(maker.out);
}

Expected<NestedTile> decode_nested(std::span<const std::byte> bytes, int levels) {
  const auto payload = parse_nested(bytes, levels);
  if (!payload) return tl::unexpected(payload.error());
  const auto points = read_points(*payload, levels);
  if (!points) return tl::unexpected(points.error());
  NestedTile tile;
  tile.xy_shift = payload->xy_shift;
  tile.z_offset = payload->z_offset;
  tile.levels = std::min(levels, static_cast<int>(payload->blocks.size()));
  NestedFans made = nested_fans(*points, tile.levels);
  add_vertices(*points, made.vertex_points, static_cast<int>(payload->blocks.size()), tile);
  tile.level_vertices = std::move(made.level_vertices);
  tile.fans = std::move(made.fans);
  tile.level_triangles = std::move(made.level_triangles);
  return tile;
}

Expected<std::vector<std::size_t>> nested_prefix_bytes(std::span<const std::byte> bytes) {
  const auto payload = parse_nested(bytes, NestedTile::kMostLevels);
  if (!payload) return tl::unexpected(payload.error());
  std::vector<std::size_t> out;
  std::size_t sum = payload->header_bytes;
  for (const std::size_t length : payload->block_bytes) out.push_back(sum += length);
  return out;
}

}  // namespace tintree::codec
