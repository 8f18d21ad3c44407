#include "render/fine_textures.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <span>

#include "render/pixel_store.h"

namespace tintree::render {
namespace {

/// More are of no use to any view, and a number in the table has 13 bits for them.
constexpr std::size_t kMostLayers = 1024;
constexpr int kLayerBits = 13;
/// What is kept in mind, textures or not.
constexpr std::size_t kMostEntries = 16384;
/// Every card's textures are as high.
constexpr int kMostRows = 1024;
/// Units of the ground's shaders.
constexpr GLint kArrayUnit = 3;
constexpr GLint kTableUnit = 4;

void bind(const GlFunctions& gl, GLint unit, GLenum target, GLuint texture) {
  gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl.BindTexture(target, texture);
}

/// Writes a number into the cells of a square, the leaf's being `1 << depth` a side.
void fill(std::span<std::uint16_t> row, int depth, const TexturePart& part, std::uint16_t number) {
  const auto across = std::size_t{1} << depth;
  const auto side = std::size_t{1} << (depth - part.depth);
  for (std::size_t y = part.y * side; y < (part.y + 1) * side; ++y) {
    std::ranges::fill(row.subspan(y * across + part.x * side, side), number);
  }
}

}  // namespace

FineTextures::FineTextures(const GlFunctions& gl, std::size_t bytes, std::size_t kinds)
    : gl_(&gl), share_bytes_(kinds > 0 ? bytes / kinds : 0) {}

FineTextures::~FineTextures() {
  for (const auto& [kind, array] : arrays_) gl_->DeleteTextures(1, &array.texture);
  gl_->DeleteTextures(1, &table_);
}

std::optional<bool> FineTextures::find(const cache::TileRef& square) const {
  const auto at = by_square_.find(square);
  return at != by_square_.end() ? std::optional(at->second->array != nullptr) : std::nullopt;
}

std::optional<bool> FineTextures::use(const cache::TileRef& square) {
  const auto at = by_square_.find(square);
  if (at == by_square_.end()) return std::nullopt;
  at->second->frame = frame_;
  entries_.splice(entries_.begin(), entries_, at->second);
  return at->second->array != nullptr;
}

bool FineTextures::upload(const cache::TileRef& square, const codec::PixelArray& pixels) {
  if (use(square)) return true;
  while (entries_.size() >= kMostEntries && entries_.back().frame != frame_) evict(std::prev(entries_.end()));
  Entry entry{square, nullptr, 0, frame_};
  if (pixels.size > 0) {
    Array& array = array_of(pixels);
    if (!find_layer(array)) return false;
    entry.array = &array;
    entry.layer = array.free.back();
    array.free.pop_back();
    copy(pixels, array, entry.layer);
    bytes_ += array.layer_bytes;
    ++textures_;
    array_of_tree_[square.tree] = array.texture;
  }
  entries_.push_front(entry);
  by_square_[square] = entries_.begin();
  return true;
}

FineTextures::Array& FineTextures::array_of(const codec::PixelArray& pixels) {
  const auto [at, anew] = arrays_.try_emplace({pixels.format, pixels.size});
  if (anew) allocate(pixels, at->second);
  return at->second;
}

void FineTextures::allocate(const codec::PixelArray& pixels, Array& out) {
  out.layer_bytes = pixels.bytes.size();
  GLint most = 0;
  gl_->GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
  const std::size_t count =
      std::min({kMostLayers, static_cast<std::size_t>(std::max(most, 0)), share_bytes_ / out.layer_bytes});
  if (count == 0) return;
  while (gl_->GetError() != GL_NO_ERROR) {
  }
  const GLenum format = stored_as(pixels.format);
  const auto layers = static_cast<GLsizei>(count);
  gl_->GenTextures(1, &out.texture);
  bind(*gl_, kArrayUnit, GL_TEXTURE_2D_ARRAY, out.texture);
  set_filter(*gl_, GL_TEXTURE_2D_ARRAY, true);
  if (pixels.format == codec::PixelFormat::kRgba8) {
    gl_->TexImage3D(GL_TEXTURE_2D_ARRAY, 0, static_cast<GLint>(format), pixels.size, pixels.size, layers, 0, GL_RGBA,
                    GL_UNSIGNED_BYTE, nullptr);
  } else {
    gl_->CompressedTexImage3D(GL_TEXTURE_2D_ARRAY, 0, format, pixels.size, pixels.size, layers, 0,
                              static_cast<GLsizei>(count * out.layer_bytes), nullptr);
  }
  if (gl_->GetError() != GL_NO_ERROR) {
    // The card has less than the budget.
    gl_->DeleteTextures(1, &out.texture);
    out.texture = 0;
    return;
  }
  for (int layer = layers; layer-- > 0;) out.free.push_back(layer);
  reserved_bytes_ += count * out.layer_bytes;
}

bool FineTextures::find_layer(Array& array) {
  if (array.texture == 0) return false;
  auto entry = entries_.end();
  while (array.free.empty() && entry != entries_.begin()) {
    --entry;
    if (entry->frame == frame_) return false;
    if (entry->array != nullptr && entry->array != &array) continue;
    const auto oldest = entry++;
    evict(oldest);
  }
  return !array.free.empty();
}

void FineTextures::evict(Entries::iterator entry) {
  if (entry->array != nullptr) {
    entry->array->free.push_back(entry->layer);
    bytes_ -= entry->array->layer_bytes;
    --textures_;
  }
  by_square_.erase(entry->square);
  entries_.erase(entry);
}

void FineTextures::copy(const codec::PixelArray& pixels, const Array& array, int layer) const {
  bind(*gl_, kArrayUnit, GL_TEXTURE_2D_ARRAY, array.texture);
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (pixels.format == codec::PixelFormat::kRgba8) {
    gl_->TexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, pixels.size, pixels.size, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                       pixels.bytes.data());
  } else {
    gl_->CompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, pixels.size, pixels.size, 1,
                                 stored_as(pixels.format), static_cast<GLsizei>(pixels.bytes.size()),
                                 pixels.bytes.data());
  }
}

void FineTextures::prepare(Trees trees, const LodCut& cut) {
  rows_ = 0;
  if (cut.parts.empty()) return;
  depths_.clear();
  for (const cache::TileBounds* tree : trees) depths_.push_back(tree->texture_depth());
  for (const DrawTile& d : cut.draws) rows_ = std::max(rows_, std::min(d.part_row + 1, kMostRows));
  const int width = 1 << (2 * std::ranges::max(depths_));
  std::vector<std::uint16_t> numbers(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(width));
  for (const DrawTile& d : cut.draws) {
    if (d.part_row < 0 || d.part_row >= rows_) continue;
    const auto row = std::span(numbers).subspan(static_cast<std::size_t>(d.part_row) * static_cast<std::size_t>(width),
                                                static_cast<std::size_t>(width));
    // The finer ones come later.
    for (const TexturePart& part : std::span(cut.parts).subspan(d.first_part, d.parts)) {
      const auto at = by_square_.find({part.texture, d.tree});
      if (at == by_square_.end() || at->second->array == nullptr) continue;
      fill(row, depths_[d.tree], part, static_cast<std::uint16_t>(part.depth << kLayerBits | at->second->layer));
    }
  }
  if (table_ == 0) gl_->GenTextures(1, &table_);
  bind(*gl_, kTableUnit, GL_TEXTURE_2D, table_);
  gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl_->TexImage2D(GL_TEXTURE_2D, 0, GL_R16UI, width, rows_, 0, GL_RED_INTEGER, GL_UNSIGNED_SHORT, numbers.data());
}

void FineTextures::set_look(const ShaderProgram& program, const DrawTile& drawn) const {
  const bool has = drawn.part_row >= 0 && drawn.part_row < rows_;
  gl_->Uniform1i(program.uniform("fine_row"), has ? drawn.part_row : -1);
  if (!has) return;
  gl_->Uniform1i(program.uniform("fine_depth"), depths_[drawn.tree]);
  bind(*gl_, kArrayUnit, GL_TEXTURE_2D_ARRAY, array_of_tree_.at(drawn.tree));
  bind(*gl_, kTableUnit, GL_TEXTURE_2D, table_);
}

void FineTextures::begin(const GlFunctions& gl, const ShaderProgram& program) {
  gl.Uniform1i(program.uniform("fine_row"), -1);
  gl.Uniform1i(program.uniform("fine_photos"), kArrayUnit);
  gl.Uniform1i(program.uniform("fine_table"), kTableUnit);
}

}  // namespace tintree::render
