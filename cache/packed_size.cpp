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
/// Schema, the manifest, and the two tables' roots.
constexpr std::uint64_t kOtherPages = 4;
constexpr std::uint64_t kBoundsRecord = 16;

}  // namespace

void PackedSize::add(std::uint64_t payload_bytes) {
  ++tiles_;
  const std::uint64_t row = payload_bytes + kRowHead;
  std::uint64_t local = row;
  if (row > kPage - 35) {
    constexpr std::uint64_t kChunk = kPage - 4;
    constexpr std::uint64_t kLeast = (kPage - 12) * 32 / 255 - 23;
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
  const std::uint64_t interior = leaf_pages_ * kInteriorEntry / kPage;
  const std::uint64_t bounds = tiles_ * kBoundsRecord / kPage;
  return (leaf_pages_ + overflow_pages_ + interior + bounds + kOtherPages) * kPage;
}

}  // namespace tintree::cache
