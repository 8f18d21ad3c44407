#include "cache/packed_size.h"

namespace tintree::cache {
namespace {

constexpr std::uint64_t kPage = 16384;
constexpr std::uint64_t kPageHeader = 8;
/// Key, record header and the columns before the payload.
constexpr std::uint64_t kRowHead = 76;
/// Pointer to the cell in the page's head, length of the cell.
constexpr std::uint64_t kCellHead = 5;
/// An entry of an interior page, with its pointer.
constexpr std::uint64_t kInteriorEntry = 15;
/// The schema, and the root of table `metadata`, which holds the manifest.
constexpr std::uint64_t kOtherPages = 2;
constexpr std::uint64_t kBoundsRecord = 16;
/// Of a larger row of that table all but the least lies in overflow pages.
constexpr std::uint64_t kMetadataMost = (kPage - 12) * 64 / 255 - 23;
constexpr std::uint64_t kLeast = (kPage - 12) * 32 / 255 - 23;
constexpr std::uint64_t kChunk = kPage - 4;

}  // namespace

void PackedSize::add(std::uint64_t payload_bytes) {
  ++tiles_;
  const std::uint64_t row = payload_bytes + kRowHead;
  std::uint64_t local = row;
  if (row > kPage - 35) {
    const std::uint64_t rest = kLeast + (row - kLeast) % kChunk;
    local = rest <= kPage - 35 ? rest : kLeast;
    overflow_pages_ += (row - local + kChunk - 1) / kChunk;
  }
  const std::uint64_t cell = local + kCellHead;
  if (cell > room_) {
    ++leaf_pages_;
    room_ = kPage - kPageHeader;
  }
  room_ -= cell < room_ ? cell : room_;
}

std::uint64_t PackedSize::bytes() const {
  // A leaf that is alone is the table's root.
  const std::uint64_t tree = leaf_pages_ <= 1 ? 1 : 1 + leaf_pages_ + leaf_pages_ * kInteriorEntry / kPage;
  const std::uint64_t bounds = tiles_ * kBoundsRecord;
  const std::uint64_t bounds_pages = bounds > kMetadataMost ? (bounds - kLeast + kChunk - 1) / kChunk : 0;
  return (tree + overflow_pages_ + bounds_pages + kOtherPages) * kPage;
}

}  // namespace tintree::cache
