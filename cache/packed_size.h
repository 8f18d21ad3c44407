#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace tintree::cache {

/// Bytes of a finished .tintree file for each size that its pages may have, from the sizes of its payloads: follows
/// SQLite's rules for where a row goes (sqlite.org/fileformat2.html, B-tree Pages). Right to a few pages.
class PackedSize {
 public:
  /// Adds a table's next payload, in key order.
  void add(std::uint64_t payload_bytes);
  /// Adds the rows of another table.
  PackedSize& operator+=(const PackedSize& other);

  /// With the pages that make the file the smallest.
  std::uint64_t bytes() const;
  /// Their size: a power of two from 1024 to 16384.
  int page_bytes() const;

 private:
  static constexpr std::array<std::uint64_t, 5> kPageBytes{1024, 2048, 4096, 8192, 16384};

  struct Pages {
    std::uint64_t leaves = 0;
    std::uint64_t overflow = 0;
    std::uint64_t room = 0;  // left in the last leaf
    std::uint64_t other_tables = 0;

    std::uint64_t all(std::uint64_t page_bytes) const;
  };

  static void add(Pages& pages, std::uint64_t page_bytes, std::uint64_t payload_bytes);
  std::uint64_t bytes_at(std::size_t size) const;
  std::size_t best() const;

  std::uint64_t rows_ = 0;
  std::array<Pages, kPageBytes.size()> pages_;
};

}  // namespace tintree::cache
