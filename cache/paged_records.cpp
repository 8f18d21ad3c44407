#include "cache/paged_records.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include <sys/mman.h>
#include <unistd.h>

namespace tintree::cache {

Expected<PagedRecords> PagedRecords::create(std::int64_t count, std::int64_t record_bytes, std::uint64_t resident_bytes,
                                            const std::string& folder) {
  PagedRecords out;
  out.record_bytes_ = record_bytes;
  out.all_bytes_ = std::max<std::int64_t>(count * record_bytes, 1);
  const auto bytes = static_cast<std::size_t>(out.all_bytes_);
  const bool fits = static_cast<std::uint64_t>(out.all_bytes_) <= resident_bytes;
  if (!fits) {
    auto file = ScratchFile::create(folder, out.all_bytes_, "a temporary file for the summary of the heights");
    if (!file) return tl::unexpected(file.error());
    if (::ftruncate(file->descriptor(), out.all_bytes_) != 0) {
      return fail(ErrorCode::kIo, std::string("a temporary file cannot be made here: ") + std::strerror(errno), folder);
    }
    out.file_ = std::move(*file);
    const auto chunks = static_cast<std::size_t>((out.all_bytes_ >> kChunkBits) + 1);
    out.touched_ = std::vector<std::atomic<bool>>(chunks);
    out.most_chunks_ = std::max<std::int64_t>(static_cast<std::int64_t>(resident_bytes >> kChunkBits), 1);
  }
  void* mapped = fits ? ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)
                      : ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, out.file_->descriptor(), 0);
  if (mapped == MAP_FAILED) {
    return fail(ErrorCode::kIo, std::string("no memory for the summary of the heights: ") + std::strerror(errno));
  }
  out.bytes_ = static_cast<std::byte*>(mapped);
  return out;
}

PagedRecords::PagedRecords(PagedRecords&& other) noexcept
    : record_bytes_(other.record_bytes_),
      all_bytes_(other.all_bytes_),
      most_chunks_(other.most_chunks_),
      bytes_(std::exchange(other.bytes_, nullptr)),
      file_(std::move(other.file_)),
      touched_(std::move(other.touched_)),
      touched_count_(other.touched_count_.load()) {}

PagedRecords::~PagedRecords() {
  if (bytes_ != nullptr) ::munmap(bytes_, static_cast<std::size_t>(all_bytes_));
}

Expected<void> PagedRecords::write(std::int64_t index, const void* record) {
  const std::int64_t place = index * record_bytes_;
  if (file_) return file_->write(place, record, record_bytes_);
  std::memcpy(bytes_ + place, record, static_cast<std::size_t>(record_bytes_));
  return {};
}

/// Counts a chunk that is used for the first time since all were let go. Letting go while others read is no harm: what
/// they read next is mapped anew.
void PagedRecords::count(std::int64_t chunk) const {
  if (touched_[static_cast<std::size_t>(chunk)].exchange(true, std::memory_order_relaxed)) return;
  if (touched_count_.fetch_add(1, std::memory_order_relaxed) < most_chunks_) return;
  touched_count_.store(0, std::memory_order_relaxed);
  for (auto& t : touched_) t.store(false, std::memory_order_relaxed);
  ::madvise(bytes_, static_cast<std::size_t>(all_bytes_), MADV_DONTNEED);
}

}  // namespace tintree::cache
