#include "cache/tile_bounds.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "codec/float_rounding.h"

namespace tintree::cache {
namespace {

constexpr std::size_t kRecordBytes = 16;

std::size_t child_count(const TileNode& node) { return static_cast<std::size_t>(std::popcount(node.child_mask)); }

/// Which of its parent's children a tile is.
unsigned child_index(const codec::TreeLayout& layout, const codec::TileId& id) {
  return layout.child_count(id.level - 1) == 4 ? (id.x & 1U) | ((id.y & 1U) << 1U) : 0;
}

}  // namespace

TileBounds::TileBounds(const codec::TreeLayout& layout, std::span<const TileInfo> tiles) : layout_(layout) {
  nodes_.reserve(tiles.size());
  for (const TileInfo& t : tiles) {
    nodes_.push_back(
        {t.id, codec::round_down(t.z_min_m), codec::round_up(t.z_max_m), codec::round_up(t.lod_error_m()), 0, 0});
  }
  // From the leaves up: a box has to hold all that is drawn in its place, or a walk that stops at it misses peaks.
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    if (node->id.level == 0) continue;
    const std::int64_t found = find(layout.parent(node->id));
    if (found < 0) continue;
    TileNode& parent = nodes_[static_cast<std::size_t>(found)];
    parent.child_mask |= static_cast<std::uint8_t>(1U << child_index(layout, node->id));
    parent.z_min_m = std::min(parent.z_min_m, node->z_min_m);
    parent.z_max_m = std::max(parent.z_max_m, node->z_max_m);
  }
  link_children();
}

/// In key order the children of one node follow those of the node before it.
void TileBounds::link_children() {
  std::size_t next = 1;
  for (TileNode& node : nodes_) {
    node.first_child = static_cast<std::uint32_t>(next);
    next += child_count(node);
  }
}

void TileBounds::raise_errors() {
  for (TileNode& node : nodes_) node.lod_error_m = codec::round_up(layout_.bound_m(node.id.level));
}

TileBounds TileBounds::placed(const codec::TreeLayout& layout) const {
  TileBounds out = *this;
  out.layout_ = layout;
  return out;
}

std::vector<std::byte> TileBounds::to_bytes() const {
  std::vector<std::byte> out(nodes_.size() * kRecordBytes);
  std::byte* record = out.data();
  for (const TileNode& node : nodes_) {
    std::memcpy(record, &node.z_min_m, 4);
    std::memcpy(record + 4, &node.z_max_m, 4);
    std::memcpy(record + 8, &node.lod_error_m, 4);
    record[12] = static_cast<std::byte>(node.child_mask);
    record += kRecordBytes;
  }
  return out;
}

Expected<TileBounds> TileBounds::from_bytes(const codec::TreeLayout& layout, std::span<const std::byte> bytes) {
  const auto bad = [] { return fail(ErrorCode::kBadData, "the bounding-box hierarchy is damaged"); };
  if (bytes.empty() || bytes.size() % kRecordBytes != 0) return bad();
  TileBounds out;
  out.layout_ = layout;
  out.nodes_.resize(bytes.size() / kRecordBytes);
  const std::byte* record = bytes.data();
  for (TileNode& node : out.nodes_) {
    std::memcpy(&node.z_min_m, record, 4);
    std::memcpy(&node.z_max_m, record + 4, 4);
    std::memcpy(&node.lod_error_m, record + 8, 4);
    node.child_mask = static_cast<std::uint8_t>(record[12]);
    if (!(node.z_min_m <= node.z_max_m) || !(node.lod_error_m >= 0) || node.child_mask > 15) return bad();
    record += kRecordBytes;
  }
  out.link_children();
  std::size_t next = 1;
  for (std::size_t i = 0; i < out.nodes_.size(); ++i) {
    const TileNode parent = out.nodes_[i];
    if (parent.child_mask != 0 && parent.id.level >= layout.leaf_level) return bad();
    const int most = layout.child_count(parent.id.level);
    if (parent.child_mask >> most != 0) return bad();
    for (int q = 0; q < most; ++q) {
      if ((parent.child_mask >> q & 1) == 0) continue;
      if (next >= out.nodes_.size()) return bad();
      const codec::TileId id = layout.child(parent.id, q);
      if (layout.cells(id).empty()) return bad();
      out.nodes_[next++].id = id;
    }
    if (next == i + 1 && next < out.nodes_.size()) return bad();
  }
  return out;
}

std::int64_t TileBounds::find(const codec::TileId& id) const {
  const auto at = std::ranges::lower_bound(nodes_, id.key(), {}, [](const TileNode& n) { return n.id.key(); });
  return at != nodes_.end() && at->id == id ? at - nodes_.begin() : -1;
}

Box TileBounds::box(const TileNode& node) const {
  const codec::CellRect c = layout_.cells(node.id);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{{kFar, kFar, node.z_min_m}, {-kFar, -kFar, node.z_max_m}};
  for (const std::int64_t column : {c.column0, c.column1}) {
    for (const std::int64_t row : {c.row0, c.row1}) {
      const auto corner = layout_.world(static_cast<double>(column), static_cast<double>(row));
      for (std::size_t axis = 0; axis < 2; ++axis) {
        box.min[axis] = std::min(box.min[axis], corner[axis]);
        box.max[axis] = std::max(box.max[axis], corner[axis]);
      }
    }
  }
  return box;
}

}  // namespace tintree::cache
