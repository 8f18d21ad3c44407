#pragma once

#include <cstdint>

namespace tintree::cache {

/// Bytes of a finished .tintree file, from the sizes of its payloads in key order: follows SQLite's rules for where a
/// row of table `tile` goes (sqlite.org/fileformat2.html, B-tree Pages). Right to a few pages.
class PackedSize {
 public:
  void add(std::uint64_t payload_bytes);
  std::uint64_t bytes() const;

 private:
  std::uint64_t tiles_ = 0;
  std::uint64_t leaf_pages_ = 0;
  std::uint64_t overflow_pages_ = 0;
  std::uint64_t room_ = 0;  // left in the last leaf page
};

}  // namespace tintree::cache
