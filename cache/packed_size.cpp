#include "cache/packed_size.h"

#include <algorithm>
#include <numeric>

namespace tintree::cache {
namespace {

constexpr std::uint64_t kPageHeader = 8;
/// Key, record header and the columns before the payload.
constexpr std::uint64_t kRowHead = 76;
/// Pointer to the cell in the page's head, length of the cell.
constexpr std::uint64_t kCellHead = 5;
/// An entry of an interior page, with its pointer.
constexpr std::uint64_t kInteriorEntry = 15;
/// Schema, the roots of two tables, and what the manifest begins on.
constexpr std::uint64_t kOtherPages = 4;
constexpr std::uint64_t kManifestBytes = 1024;
constexpr std::uint64_t kBoundsRecord = 16;

}  // namespace

void PackedSize::add(Pages& pages, std::uint64_t page_bytes, std::uint64_t payload_bytes) {
  const std::uint64_t row = payload_bytes + kRowHead;
  std::uint64_t local = row;
  if (row > page_bytes - 35) {
    const std::uint64_t chunk = page_bytes - 4;
    const std::uint64_t least = (page_bytes - 12) * 32 / 255 - 23;
    const std::uint64_t rest = least + (row - least) % chunk;
    local = rest <= page_bytes - 35 ? rest : least;
    pages.overflow += (row - local + chunk - 1) / chunk;
  }
  const std::uint64_t cell = local + kCellHead;
  if (cell > pages.room) {
    ++pages.leaves;
    pages.room = page_bytes - kPageHeader;
  }
  pages.room -= std::min(cell, pages.room);
}

void PackedSize::add(std::uint64_t payload_bytes) {
  ++rows_;
  for (std::size_t i = 0; i < kPageBytes.size(); ++i) add(pages_[i], kPageBytes[i], payload_bytes);
}

PackedSize& PackedSize::operator+=(const PackedSize& other) {
  rows_ += other.rows_;
  for (std::size_t i = 0; i < kPageBytes.size(); ++i) {
    pages_[i].leaves += other.pages_[i].leaves;
    pages_[i].overflow += other.pages_[i].overflow;
  }
  return *this;
}

std::uint64_t PackedSize::bytes_at(std::size_t size) const {
  const std::uint64_t page = kPageBytes[size];
  const std::uint64_t interior = pages_[size].leaves * kInteriorEntry / page;
  const std::uint64_t metadata = (rows_ * kBoundsRecord + kManifestBytes) / page;
  return (pages_[size].leaves + pages_[size].overflow + interior + metadata + kOtherPages) * page;
}

std::size_t PackedSize::best() const {
  std::array<std::size_t, kPageBytes.size()> sizes;
  std::iota(sizes.begin(), sizes.end(), 0);
  return *std::ranges::min_element(sizes, {}, [this](std::size_t size) { return bytes_at(size); });
}

std::uint64_t PackedSize::bytes() const { return bytes_at(best()); }

int PackedSize::page_bytes() const { return static_cast<int>(kPageBytes[best()]); }

}  // namespace tintree::cache
