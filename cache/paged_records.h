#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cache/scratch_file.h"
#include "codec/error.h"

namespace tintree::cache {

/// Records of one size that are written once and then read over and over. They lie in memory as long as they fit into
/// the share of it that they may take; else in a nameless temporary file that is mapped into memory, and whenever about
/// that share of it has been touched the whole of it is let go again. Thread-safe, but for a record that is being
/// written.
class PagedRecords {
 public:
  /// The file, if there has to be one, is made in `folder`. kIo when it cannot.
  static Expected<PagedRecords> create(std::int64_t count, std::int64_t record_bytes, std::uint64_t resident_bytes,
                                       const std::string& folder);

  PagedRecords(PagedRecords&& other) noexcept;
  PagedRecords& operator=(PagedRecords&&) = delete;
  ~PagedRecords();

  Expected<void> write(std::int64_t index, const void* record);
  /// Stays valid, and what it shows the same.
  const std::byte* at(std::int64_t index) const {
    const std::int64_t place = index * record_bytes_;
    if (file_) {
      touch(place >> kChunkBits);
      touch((place + record_bytes_ - 1) >> kChunkBits);
    }
    return bytes_ + place;
  }

 private:
  /// What the system maps around a place that is touched.
  static constexpr int kChunkBits = 16;

  PagedRecords() = default;
  void touch(std::int64_t chunk) const {
    if (!touched_[static_cast<std::size_t>(chunk)].load(std::memory_order_relaxed)) count(chunk);
  }
  void count(std::int64_t chunk) const;

  std::int64_t record_bytes_ = 0;
  std::int64_t all_bytes_ = 0;
  std::int64_t most_chunks_ = 0;
  std::byte* bytes_ = nullptr;
  std::optional<ScratchFile> file_;
  mutable std::vector<std::atomic<bool>> touched_;
  mutable std::atomic<std::int64_t> touched_count_ = 0;
};

}  // namespace tintree::cache
