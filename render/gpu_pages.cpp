#include "render/gpu_pages.h"

#include <algorithm>
#include <utility>

#include "render/scalar_vertices.h"

namespace tintree::render {
namespace {

using cache::DrawVertex;
using cache::MorphVertex;

static_assert(GpuPages::kUnit == 3 * sizeof(std::uint32_t), "a unit has room for a strip's triangle");
constexpr std::size_t kPages = 8;  ///< Of a budget that is not large.

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

/// Locations as in shaders/terrain.vert.glsl.
void describe_vertex(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(DrawVertex);
  gl.VertexAttribIPointer(0, 4, GL_UNSIGNED_SHORT, kStride, offset(0));
  gl.VertexAttribPointer(1, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(DrawVertex, normal_x)));
  for (GLuint location = 0; location < 2; ++location) gl.EnableVertexAttribArray(location);
}

/// The vertices between a tile's surface and its parent's.
void describe_morph_vertex(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(MorphVertex);
  gl.VertexAttribPointer(2, 4, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MorphVertex, x)));
  gl.VertexAttribPointer(3, 4, GL_SHORT, GL_TRUE, kStride, offset(offsetof(MorphVertex, normal_x)));
  gl.VertexAttribIPointer(4, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(MorphVertex, skirt)));
  for (GLuint location = 2; location < 5; ++location) gl.EnableVertexAttribArray(location);
}

/// As in shaders/scalar_word.glsl and scalar_draw.vert.glsl.
void describe_lit_word(const GlFunctions& gl) {
  constexpr GLsizei kStride = sizeof(LitWord);
  gl.VertexAttribIPointer(0, 1, GL_UNSIGNED_INT, kStride, offset(0));
  gl.VertexAttribPointer(1, 2, GL_SHORT, GL_TRUE, kStride, offset(offsetof(LitWord, normal_x)));
  for (GLuint location = 0; location < 2; ++location) gl.EnableVertexAttribArray(location);
}

/// A word of a strip is an index by itself.
void describe_nothing(const GlFunctions&) {}

}  // namespace

GpuPages::~GpuPages() {
  for (const GpuPage& page : pages_) free_page(page);
}

std::optional<PageRange> GpuPages::take(std::size_t length) {
  if (const auto range = find_gap(length)) return range;
  return add_page(length) ? find_gap(length) : std::nullopt;
}

std::optional<PageRange> GpuPages::find_gap(std::size_t length) {
  for (std::size_t i = 0; i < pages_.size(); ++i) {
    if (const auto begin = pages_[i].free.take(length)) return PageRange{i, *begin, length};
  }
  return std::nullopt;
}

bool GpuPages::add_page(std::size_t length) {
  const std::size_t taken = std::min(reserved_bytes_ + aside_bytes_, budget_bytes_);
  const std::size_t left = budget_bytes_ - taken;
  const std::size_t usual = std::clamp(budget_bytes_ / kPages, std::size_t{1} << 20, kLargestPage) / kUnit;
  const std::size_t units = std::min(std::max(usual, length), left / kUnit);
  if (units < length) return false;
  GpuPage page{0, 0, 0, 0, 0, RangeAllocator(units), units * kUnit};
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  gl_->GenBuffers(1, &page.buffer);
  gl_->BindBuffer(GL_ARRAY_BUFFER, page.buffer);
  gl_->BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(units * kUnit), nullptr, GL_STATIC_DRAW);
  page.vertex_array = make_vertex_array(page.buffer, describe_vertex);
  page.morph_vertex_array = make_vertex_array(page.buffer, describe_morph_vertex);
  page.lit_vertex_array = make_vertex_array(page.buffer, describe_lit_word);
  page.strip_vertex_array = make_vertex_array(page.buffer, describe_nothing);
  if (gl_->GetError() != GL_NO_ERROR) {
    // The card has less than the budget: what there is has to do.
    free_page(page);
    budget_bytes_ = taken;
    return false;
  }
  reserved_bytes_ += page.bytes;
  const auto freed = std::ranges::find(pages_, GLuint{0}, &GpuPage::buffer);
  if (freed != pages_.end()) {
    *freed = std::move(page);
  } else {
    pages_.push_back(std::move(page));
  }
  return true;
}

bool GpuPages::set_aside(std::size_t bytes) {
  const bool fits = bytes <= budget_bytes_ && reserved_bytes_ <= budget_bytes_ - bytes;
  aside_bytes_ = fits ? bytes : 0;
  return fits;
}

std::optional<std::size_t> GpuPages::find_page(const std::vector<bool>& kept) const {
  for (std::size_t i = 0; i < pages_.size(); ++i) {
    if (!kept[i] && pages_[i].buffer != 0) return i;
  }
  return std::nullopt;
}

void GpuPages::drop(std::size_t page) {
  free_page(pages_[page]);
  reserved_bytes_ -= pages_[page].bytes;
  pages_[page] = {0, 0, 0, 0, 0, RangeAllocator(0), 0};
}

void GpuPages::free_page(const GpuPage& page) {
  for (const GLuint array :
       {page.vertex_array, page.morph_vertex_array, page.lit_vertex_array, page.strip_vertex_array})
    gl_->DeleteVertexArrays(1, &array);
  gl_->DeleteBuffers(1, &page.buffer);
}

GLuint GpuPages::make_vertex_array(GLuint buffer, void (*describe)(const GlFunctions&)) {
  GLuint out = 0;
  gl_->GenVertexArrays(1, &out);
  gl_->BindVertexArray(out);
  gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffer);
  describe(*gl_);
  gl_->BindVertexArray(0);
  return out;
}

}  // namespace tintree::render
