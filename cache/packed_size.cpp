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
/// The schema, and the root of table `metadata`.
constexpr std::uint64_t kOtherPages = 2;
constexpr std::uint64_t kManifestBytes = 1100;
constexpr std::uint64_t kBoundsRecord = 16;

/// What of a row lies in its leaf, if that may be `most` at most; the rest lies in overflow pages.
std::uint64_t local_bytes(std::uint64_t row, std::uint64_t most, std::uint64_t page_bytes) {
  if (row <= most) return row;
  const std::uint64_t least = (page_bytes - 12) * 32 / 255 - 23;
  const std::uint64_t rest = least + (row - least) % (page_bytes - 4);
  return rest <= most ? rest : least;
}

std::uint64_t overflow_pages(std::uint64_t bytes, std::uint64_t page_bytes) {
  return (bytes + page_bytes - 5) / (page_bytes - 4);
}

/// Of a row of table `metadata`, which has no row ids and so is an index.
std::uint64_t metadata_overflow(std::uint64_t row, std::uint64_t page_bytes) {
  return overflow_pages(row - local_bytes(row, (page_bytes - 12) * 64 / 255 - 23, page_bytes), page_bytes);
}

}  // namespace

std::uint64_t PackedSize::Pages::all(std::uint64_t page_bytes) const {
  const std::uint64_t interior = leaves <= 1 ? 0 : 1 + leaves * kInteriorEntry / page_bytes;  // or the leaf is the root
  return other_tables + interior + std::max<std::uint64_t>(leaves, 1) + overflow;
}

void PackedSize::add(Pages& pages, std::uint64_t page_bytes, std::uint64_t payload_bytes) {
  const std::uint64_t row = payload_bytes + kRowHead;
  const std::uint64_t local = local_bytes(row, page_bytes - 35, page_bytes);
  pages.overflow += overflow_pages(row - local, page_bytes);
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
  if (other.rows_ == 0) return *this;
  rows_ += other.rows_;
  for (std::size_t i = 0; i < kPageBytes.size(); ++i) {
    pages_[i].other_tables += other.pages_[i].all(kPageBytes[i]);
  }
  return *this;
}

std::uint64_t PackedSize::bytes_at(std::size_t size) const {
  const std::uint64_t page = kPageBytes[size];
  const std::uint64_t metadata =
      metadata_overflow(rows_ * kBoundsRecord, page) + metadata_overflow(kManifestBytes, page);
  return (pages_[size].all(page) + metadata + kOtherPages) * page;
}

std::size_t PackedSize::best() const {
  std::array<std::size_t, kPageBytes.size()> sizes;
  std::iota(sizes.begin(), sizes.end(), 0);
  return *std::ranges::min_element(sizes, {}, [this](std::size_t size) { return bytes_at(size); });
}

std::uint64_t PackedSize::bytes() const { return bytes_at(best()); }

int PackedSize::page_bytes() const { return static_cast<int>(kPageBytes[best()]); }

}  // namespace tintree::cache
