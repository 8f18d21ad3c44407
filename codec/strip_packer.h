#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "codec/bit_pack.h"
#include "codec/strip_payload.h"

namespace tintree::codec {

/// Writes a payload of version 1, triangle by triangle.
class StripPacker {
 public:
  /// `first` and `second`: the heights of the first entering edge's vertices.
  StripPacker(const StripHead& head, std::uint32_t first, std::uint32_t second)
      : head_(head), layout_(StripHeaderLayout::of(head.levels)) {
    put_strip_head(out_, kStripPacked, head_);
    header_at_ = out_.size();
    out_.resize(out_.size() + head_.sub_strips() * layout_.bytes);
    entry(StripType::kA, first);
    entry(StripType::kA, second);
  }
  StripPacker(const StripPacker&) = delete;
  StripPacker& operator=(const StripPacker&) = delete;

  /// Before the first triangle of every sub-strip.
  void header(const StripHeader& header) {
    const std::uint64_t packed = layout_.pack(header);
    std::memcpy(out_.data() + header_at_, &packed, layout_.bytes);
    header_at_ += layout_.bytes;
  }
  /// A triangle, by its type and the height of its third vertex.
  void entry(StripType type, std::uint32_t height) {
    entries_.put(height << 2 | static_cast<std::uint32_t>(type), head_.height_bits + 2);
  }
  std::vector<std::byte> finish() {
    entries_.finish();
    return std::move(out_);
  }

 private:
  StripHead head_;
  StripHeaderLayout layout_;
  std::vector<std::byte> out_;
  BitWriter entries_{out_};
  std::size_t header_at_ = 0;
};

}  // namespace tintree::codec
