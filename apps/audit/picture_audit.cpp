#include "apps/audit/picture_audit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "apps/audit/picture_match.h"
#include "codec/normal_codec.h"
#include "codec/texture_codec.h"

namespace tintree::audit {
namespace {

using cache::PictureKind;
using codec::TileId;

/// Differences beyond which a picture shows something else, however it lies: a share of the whole range of colours,
/// and of a unit vector.
constexpr double kColorLimit = 0.16;
constexpr double kNormalLimit = 0.25;
/// Photos whose pixels are so many times smaller than a leaf's texels ask for finer textures.
constexpr double kFinerPhoto = 1.25;

/// sRGB as linear light, IEC 61966-2-1.
float light_of(std::uint8_t srgb) {
  const double s = srgb / 255.0;
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

/// Light, in which pictures are filtered, or the stored steps, in which they are compared.
enum class Scale { kLight, kSteps };

TexelGrid grid_of(const std::vector<std::uint8_t>& rgba, int size, Scale scale) {
  static const std::array<float, 256> light = [] {
    std::array<float, 256> out{};
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = light_of(static_cast<std::uint8_t>(i));
    return out;
  }();
  TexelGrid grid(size);
  for (std::size_t i = 0; i < grid.values.size(); ++i) {
    grid.valid[i] = rgba[4 * i + 3] >= 128;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint8_t step = rgba[4 * i + k];
      grid.values[i][k] = scale == Scale::kLight ? light[step] : static_cast<float>(step) / 255;
    }
  }
  return grid;
}

class PictureExamination {
 public:
  PictureExamination(const AuditContext& context, const cache::OrthoSource* photos, std::vector<Violation>& violations)
      : context_(context),
        store_(context.store),
        manifest_(store_.manifest()),
        photos_(photos),
        violations_(violations) {}

  Expected<PictureReport> run() {
    for (const PictureKind kind : cache::kPictureKinds) {
      if (manifest_.picture_size(kind) == 0) continue;
      if (auto done = compare_keys(kind); !done) return tl::unexpected(done.error());
      const auto nodes = store_.bounds().nodes();
      tbb::parallel_for(std::size_t{0}, nodes.size(), [&](std::size_t i) {
        if (!has_error() && nodes[i].id == manifest_.layout.picture_tile(nodes[i].id)) examine(kind, nodes[i].id);
      });
      if (error_) return tl::unexpected(*error_);
    }
    const auto rms = [](double squares, double count) { return count > 0 ? std::sqrt(squares / count) : 0; };
    report_.photo_rms = 255 * rms(photo_squares_ / 3, photo_texels_);
    report_.normal_rms = rms(normal_squares_, normal_texels_);
    return report_;
  }

 private:
  bool has_error() {
    const std::scoped_lock lock(turn_);
    return error_.has_value();
  }
  void stop_with(const Error& error) {
    const std::scoped_lock lock(turn_);
    if (!error_) error_ = error;
  }
  void blame(const std::optional<TileId>& tile, std::string message) {
    const std::scoped_lock lock(turn_);
    violations_.push_back({tile, ViolationKind::kPicture, std::move(message), kStructural / 4});
  }

  Expected<void> compare_keys(PictureKind kind) {
    const auto keys = store_.picture_keys(kind);
    if (!keys) return tl::unexpected(keys.error());
    for (const std::int64_t key : *keys) {
      const TileId id = TileId::from_key(key);
      if (lies_on_a_tile(kind, id) && id == manifest_.layout.picture_tile(id)) continue;
      blame(std::nullopt,
            fmt::format("there is a {} in row {}, which is none of the hierarchy's tiles, or has its parent's",
                        cache::picture_name(kind), key));
    }
    return {};
  }

  /// On a tile's square, or on one in a leaf's where there may be finer pictures.
  bool lies_on_a_tile(PictureKind kind, TileId id) const {
    const codec::TreeLayout squares = manifest_.picture_layout(kind);
    if (id.level > squares.leaf_level || squares.cells(id).empty()) return false;
    while (id.level > manifest_.layout.leaf_level) id = squares.parent(id);
    return store_.bounds().find(id) >= 0;
  }

  /// The tile's picture in the scale that is filtered; nothing where there is none or it is damaged, which is
  /// `reported` once.
  std::optional<TexelGrid> decoded(PictureKind kind, const TileId& id, Scale scale, bool reported) {
    const auto payload = store_.read_picture(kind, id);
    if (!payload) {
      if (payload.error().code != ErrorCode::kBadData) {
        stop_with(payload.error());
      } else if (reported) {
        blame(id, payload.error().message);
      }
      return std::nullopt;
    }
    if (!*payload) {
      if (reported && kind == PictureKind::kNormal) blame(id, "has no normal map");
      return std::nullopt;
    }
    auto grid = kind == PictureKind::kTexture ? decoded_colors(**payload, scale) : decoded_normals(**payload);
    if (grid) return std::move(*grid);
    if (reported) blame(id, fmt::format("its {} {}", cache::picture_name(kind), grid.error().message));
    return std::nullopt;
  }

  Expected<TexelGrid> decoded_colors(std::span<const std::byte> payload, Scale scale) const {
    const codec::TextureCodec* codec = codec::find_texture_codec(manifest_.texture_codec);
    if (codec == nullptr)
      return fail(ErrorCode::kBadData, "is coded as '" + manifest_.texture_codec + "', which is unknown");
    const auto image = codec->decode(payload, manifest_.picture_size(PictureKind::kTexture));
    if (!image) return tl::unexpected(image.error());
    return grid_of(image->rgba, image->size, scale);
  }

  Expected<TexelGrid> decoded_normals(std::span<const std::byte> payload) const {
    auto image = codec::decode_normals(payload, manifest_.picture_size(PictureKind::kNormal));
    if (!image) return tl::unexpected(image.error());
    TexelGrid grid(image->size);
    grid.values = std::move(image->vectors);
    grid.valid.assign(grid.values.size(), true);
    return grid;
  }

  /// A picture against the finer ones on the quadrants of its square or, without any, what it was made from; and those
  /// on smaller squares in a leaf.
  void examine(PictureKind kind, const TileId& id) {
    if (!context_.advance(0)) return stop_with(stopped_error());
    const auto own = decoded(kind, id, Scale::kLight, true);
    if (own) {
      const std::scoped_lock lock(turn_);
      ++(kind == PictureKind::kTexture ? report_.textures : report_.normal_maps);
    }
    const codec::TreeLayout squares = manifest_.picture_layout(kind);
    const bool in_leaf = manifest_.layout.is_leaf_square(id.level) || id.level > manifest_.layout.leaf_level;
    bool finer_ones = false;
    for (const TileId& child : quadrants(squares, id)) {
      if (!in_leaf && store_.bounds().find(child) < 0) continue;
      if (in_leaf && !is_stored(kind, child)) continue;
      finer_ones = true;
      const auto finer = decoded(kind, child, Scale::kLight, false);
      if (own && finer) {
        judge(kind, child, match_parent(*finer, *own, quadrant_of(child)), "its parent's, tile " + id.text());
      }
      if (in_leaf) examine(kind, child);
    }
    if (!own || finer_ones || !in_leaf) return;
    if (kind == PictureKind::kNormal) return compare_heights(id, *own);
    if (photos_ == nullptr) return;
    compare_photo(id);
    if (lacks_finer(squares, id, *own)) blame(id, "lacks the finer textures that the photos are good for");
  }

  static std::vector<TileId> quadrants(const codec::TreeLayout& squares, const TileId& id) {
    std::vector<TileId> out;
    if (squares.is_leaf_square(id.level)) return out;
    // The last tile on this square is the one whose children lie on its quadrants.
    const TileId last{squares.coarsest_level(squares.halvings(id.level) + 1) - 1, id.x, id.y};
    for (int q = 0; q < 4; ++q) out.push_back(squares.child(last, q));
    return out;
  }
  static int quadrant_of(const TileId& id) { return static_cast<int>((id.x & 1U) | (id.y & 1U) << 1U); }

  /// Whether there is a row, damaged or not.
  bool is_stored(PictureKind kind, const TileId& id) {
    const auto payload = store_.read_picture(kind, id);
    if (!payload && payload.error().code != ErrorCode::kBadData) stop_with(payload.error());
    return !payload || *payload;
  }

  bool lacks_finer(const codec::TreeLayout& squares, const TileId& id, const TexelGrid& own) const {
    const auto covered = static_cast<std::size_t>(std::ranges::count(own.valid, true));
    const double texel = static_cast<double>(squares.cells_across(id.level)) / manifest_.texture_size;
    return !squares.is_leaf_square(id.level) && covered > own.valid.size() / 100 &&
           texel > kFinerPhoto * photos_->pixel_samples_in(squares.cells(id));
  }

  void judge(PictureKind kind, const TileId& id, const PictureMatch& match, const std::string& of) {
    const char* name = cache::picture_name(kind);
    if (match.shift_x != 0 || match.shift_y != 0) {
      blame(id,
            fmt::format("its {} lies {} columns and {} rows of texels off {}", name, match.shift_x, match.shift_y, of));
    } else if (match.rms > std::sqrt(3.0) * (kind == PictureKind::kTexture ? kColorLimit : kNormalLimit)) {
      blame(id, fmt::format("its {} shows something else than {}", name, of));
    }
  }

  void compare_photo(const TileId& id) {
    const auto own = decoded(PictureKind::kTexture, id, Scale::kSteps, false);
    if (!own) return;
    const std::int64_t across = manifest_.texture_size;
    const double step = static_cast<double>(manifest_.picture_layout(PictureKind::kTexture).cells_across(id.level)) /
                        manifest_.texture_size;
    const auto window = photos_->read(step, id.x * across, id.y * across, own->size, own->size);
    if (!window) return stop_with(window.error());
    const PictureMatch match = match_pictures(*own, grid_of(window->rgba, own->size, Scale::kSteps));
    judge(PictureKind::kTexture, id, match, "the photo");
    const std::scoped_lock lock(turn_);
    photo_squares_ += match.rms * match.rms * static_cast<double>(match.texels);
    photo_texels_ += static_cast<double>(match.texels);
  }

  /// Against normals by central differences from the samples themselves.
  void compare_heights(const TileId& id, const TexelGrid& own) {
    const codec::TreeLayout& layout = manifest_.layout;
    const int side = own.size + 2;
    std::vector<double> heights(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    const auto read = context_.source.read(std::int64_t{id.x} * layout.tile_cells - 1,
                                           std::int64_t{id.y} * layout.tile_cells - 1, side, side, heights.data());
    if (!read) return stop_with(read.error());
    const auto at = [&](int x, int y) {
      return heights[static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(side) +
                     static_cast<std::size_t>(x + 1)];
    };
    TexelGrid expected(own.size);
    for (int y = 0; y < own.size; ++y) {
      for (int x = 0; x < own.size; ++x) {
        // The cross product of the two central differences, in world coordinates.
        const auto a = layout.axes.world(2 * layout.dx_m, 0);
        const auto b = layout.axes.world(0, 2 * layout.dy_m);
        const double za = at(x + 1, y) - at(x - 1, y);
        const double zb = at(x, y + 1) - at(x, y - 1);
        const std::array<double, 3> n{b[1] * za - a[1] * zb, a[0] * zb - b[0] * za, b[0] * a[1] - b[1] * a[0]};
        const double length = std::hypot(n[0], n[1], n[2]);
        const std::size_t i = expected.index(x, y);
        expected.valid[i] = std::isfinite(length);
        for (std::size_t k = 0; k < 3; ++k) expected.values[i][k] = static_cast<float>(n[k] / length);
      }
    }
    const PictureMatch match = match_pictures(own, expected);
    judge(PictureKind::kNormal, id, match, "the DEM");
    const std::scoped_lock lock(turn_);
    normal_squares_ += match.rms * match.rms * static_cast<double>(match.texels);
    normal_texels_ += static_cast<double>(match.texels);
  }

  const AuditContext& context_;
  const cache::TileStore& store_;
  const cache::Manifest& manifest_;
  const cache::OrthoSource* photos_;
  std::mutex turn_;  ///< Guards all that follows.
  std::vector<Violation>& violations_;
  std::optional<Error> error_;
  PictureReport report_;
  double photo_squares_ = 0;
  double photo_texels_ = 0;
  double normal_squares_ = 0;
  double normal_texels_ = 0;
};

}  // namespace

Expected<PictureReport> audit_pictures(const AuditContext& context, const cache::OrthoSource* photos,
                                       std::vector<Violation>& violations) {
  return PictureExamination(context, photos, violations).run();
}

}  // namespace tintree::audit
