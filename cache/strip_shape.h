#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "codec/grid_frame.h"
#include "codec/strip_list.h"
#include "codec/strip_payload.h"
#include "codec/tile_id.h"
#include "codec/tile_mesh.h"

namespace tintree::cache {

/// A tile of method `strip` ready for a graphics card that unpacks it (Dick et al. 2009, sections 5 and 6): its headers
/// and entries as they are stored, which StripMesh::decode() has accepted, and what the card is not to find out itself.
/// Immutable once made.
class StripShape {
 public:
  StripShape(std::vector<std::byte> packed, codec::StripPayload strip, codec::StripBorders borders);
  StripShape(const StripShape&) = delete;
  StripShape& operator=(const StripShape&) = delete;

  const codec::StripPayload& strip() const { return strip_; }
  /// Behind which the ground goes on, in strip steps.
  const codec::StripBorders& borders() const { return borders_; }
  std::uint32_t triangle_words() const { return 3 * strip_.triangles; }
  std::uint32_t skirt_words() const { return skirt_words_; }
  /// The surface's triangles, three words each; those of a hole are three zeros. Cost: 1 ms for 2 MB of words.
  std::vector<std::uint32_t> words() const;
  std::size_t bytes() const { return sizeof *this + packed_.size(); }

 private:
  std::vector<std::byte> packed_;
  codec::StripPayload strip_;  // of packed_
  codec::StripBorders borders_;
  std::uint32_t skirt_words_;
};

struct DrawableTile;

/// Of a payload of either version that has been decoded to `mesh`: a tile without vertices and indices of its own,
/// whose frame takes a word's x, y and height times 2^z_shift to metres. `joined_sides` as make_drawable() takes them.
/// Null for a tile that no card unpacks (codec::unpacks_on_card()). Cost: the occluder's.
std::unique_ptr<DrawableTile> make_drawable_strip(const codec::TreeLayout& layout, const codec::TileId& id,
                                                  std::vector<std::byte> packed, const codec::TileMesh& mesh,
                                                  std::uint16_t joined_sides);

}  // namespace tintree::cache
