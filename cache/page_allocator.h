#pragma once

#include <cstddef>
#include <new>

#include <sys/mman.h>

namespace tintree::cache {

/// Bytes of a page, of most systems.
inline constexpr std::size_t kPageBytes = 4096;

/// Gives every array pages of its own, which go back to the system with it. For large arrays that are made on one
/// thread and dropped on another in a long life: in the C library's heap they would fill, and then leave, the holes of
/// whoever was there before, so that what a program keeps would go by its history. Costs two calls of the system, and
/// up to a page more than the array. Thread-safe.
template <typename T>
struct PageAllocator {
  using value_type = T;

  PageAllocator() = default;
  template <typename U>
  explicit PageAllocator(const PageAllocator<U>& /*other*/) {}

  T* allocate(std::size_t count) {
    void* pages = count > static_cast<std::size_t>(-1) / sizeof(T)
                      ? MAP_FAILED
                      : ::mmap(nullptr, count * sizeof(T), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (pages == MAP_FAILED) throw std::bad_alloc();
    return static_cast<T*>(pages);
  }
  /// What an array of so many takes: whole pages.
  static constexpr std::size_t bytes(std::size_t count) {
    return (count * sizeof(T) + kPageBytes - 1) / kPageBytes * kPageBytes;
  }
  void deallocate(T* first, std::size_t count) { ::munmap(first, count * sizeof(T)); }

  friend bool operator==(const PageAllocator& /*a*/, const PageAllocator& /*b*/) { return true; }
};

}  // namespace tintree::cache
