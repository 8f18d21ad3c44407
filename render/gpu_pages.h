#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cache/drawable_tile.h"
#include "render/gl_functions.h"
#include "render/range_allocator.h"

namespace tintree::render {

/// A part of one of the pages; none when its length is 0.
struct PageRange {
  std::size_t page = 0;
  std::size_t begin = 0;  ///< In units of GpuPages::kUnit bytes, as is the length.
  std::size_t length = 0;

  std::size_t bytes() const;
};

/// A large buffer for vertices and indices, or words, of many tiles.
struct GpuPage {
  GLuint vertex_array = 0;        ///< Of cache::DrawVertex,
  GLuint morph_vertex_array = 0;  ///< of cache::MorphVertex,
  GLuint lit_vertex_array = 0;    ///< of LitWord,
  GLuint strip_vertex_array = 0;  ///< and of nothing, for words.
  GLuint buffer = 0;
  RangeAllocator free;  ///< In units.
  std::size_t bytes = 0;
};

/// A few large buffers on the card, in ranges that are taken and given back; never more bytes than its budget. What
/// lies in them, and who has to leave, is for its user to know. Lives and dies while its context is current; not
/// thread-safe.
class GpuPages {
 public:
  /// Ranges begin at multiples of a vertex, so that both vertices and indices (4 divides 12) lie where GL wants them.
  static constexpr std::size_t kUnit = sizeof(cache::DrawVertex);
  /// Of a buffer, but for a range that needs more.
  static constexpr std::size_t kLargestPage = std::size_t{64} << 20;

  GpuPages(const GlFunctions& gl, std::size_t budget_bytes) : gl_(&gl), budget_bytes_(budget_bytes) {}
  ~GpuPages();
  GpuPages(const GpuPages&) = delete;
  GpuPages& operator=(const GpuPages&) = delete;

  /// A range of so many units, in another buffer where the gaps are too short and the budget allows one.
  std::optional<PageRange> take(std::size_t length);
  void give_back(const PageRange& range) { pages_[range.page].free.give(range.begin, range.length); }
  /// The buffer that a range lies in.
  const GpuPage& page(const PageRange& range) const { return pages_[range.page]; }

  /// Keeps that much of the budget free of buffers. False, and nothing is kept, when they take too much of it.
  bool set_aside(std::size_t bytes);
  /// The first page with a buffer that is none of `kept`, which has a value for each of count() pages.
  std::optional<std::size_t> find_page(const std::vector<bool>& kept) const;
  /// Frees a page's buffer, in which no range is taken any more.
  void drop(std::size_t page);

  /// Those whose buffers were freed count too.
  std::size_t count() const { return pages_.size(); }
  std::size_t budget_bytes() const { return budget_bytes_; }
  std::size_t reserved_bytes() const { return reserved_bytes_; }

 private:
  std::optional<PageRange> find_gap(std::size_t length);
  bool add_page(std::size_t length);
  void free_page(const GpuPage& page);
  /// Makes a vertex array over the buffer that is bound.
  GLuint make_vertex_array(GLuint buffer, void (*describe)(const GlFunctions&));

  const GlFunctions* gl_;
  std::size_t budget_bytes_;  ///< Less, once the card has refused more.
  std::size_t aside_bytes_ = 0;
  std::size_t reserved_bytes_ = 0;
  std::vector<GpuPage> pages_;  ///< Those that were freed stay, without a buffer.
};

inline std::size_t PageRange::bytes() const { return length * GpuPages::kUnit; }

}  // namespace tintree::render
