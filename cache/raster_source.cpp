#include "cache/raster_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "cache/nodata_fill.h"
#include "cache/scratch_raster.h"

namespace tintree::cache {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// Files that stay open at once; the one unused for longest is closed for another.
constexpr std::size_t kOpenFiles = 64;
/// Samples read at once while copying.
constexpr std::int64_t kCopySamples = std::int64_t{1} << 20;
constexpr std::int64_t kCopyRows = 256;
/// How far, in samples, a file may lie off the grid of the first one.
constexpr double kGridTolerance = 0.02;

/// A file and where its first sample lies on the grid of them all.
struct Part {
  RasterFile file;
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;

  std::int64_t column1() const { return column0 + file.info().columns; }
  std::int64_t row1() const { return row0 + file.info().rows; }
};

/// The grid address of a point in CRS coordinates.
std::array<double, 2> grid_address(const GeoTransform& t, double x, double y) {
  const double area = t[1] * t[5] - t[2] * t[4];
  return {((x - t[0]) * t[5] - (y - t[3]) * t[2]) / area, ((y - t[3]) * t[1] - (x - t[0]) * t[4]) / area};
}

/// Puts a part on the grid of the first one: its corners must fall on whole samples.
Expected<void> place(const RasterFileInfo& first, Part& part) {
  const RasterFileInfo& info = part.file.info();
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    return fail(ErrorCode::kBadData, what + " " + first.input.path + "; " + remedy, info.input.path);
  };
  if (!first.georeferenced || !info.georeferenced) {
    return refuse("several DEMs need a georeference each; one is missing here or in", "add it (gdal_edit.py -a_ullr)");
  }
  if (!same_crs(first.crs_wkt, info.crs_wkt)) {
    return refuse("has another coordinate reference system than", "warp it to the same one (gdalwarp -t_srs)");
  }
  const GeoTransform& t = info.transform;
  const std::array<std::int64_t, 2> size{info.columns, info.rows};
  std::array<double, 2> corner = grid_address(first.transform, t[0], t[3]);
  part.column0 = std::llround(corner[0]);
  part.row0 = std::llround(corner[1]);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto next = grid_address(first.transform, t[0] + t[1 + axis], t[3] + t[4 + axis]);
    const double spacing = std::hypot(next[0] - corner[0], next[1] - corner[1]);
    if (!(std::abs(spacing - 1) * static_cast<double>(size[axis]) <= 2 * kGridTolerance)) {
      return refuse(fmt::format("its samples lie {:.4g} times as far apart as those of", spacing),
                    "bring them onto one grid (gdalwarp -tr X Y -tap)");
    }
  }
  for (int i = 0; i < 4; ++i) {
    const double across = (i & 1) != 0 ? static_cast<double>(size[0]) : 0;
    const double down = (i & 2) != 0 ? static_cast<double>(size[1]) : 0;
    corner = grid_address(first.transform, t[0] + across * t[1] + down * t[2], t[3] + across * t[4] + down * t[5]);
    const double off = std::max(std::abs(corner[0] - static_cast<double>(part.column0) - across),
                                std::abs(corner[1] - static_cast<double>(part.row0) - down));
    if (!(off <= kGridTolerance)) {
      return refuse(fmt::format("its samples lie up to {:.3g} samples off those of", off),
                    "bring them onto one grid (gdalwarp -tr X Y -tap)");
    }
  }
  return {};
}

std::string name_of(const std::vector<Part>& parts) {
  const std::string& first = parts.front().file.info().input.path;
  return parts.size() == 1 ? first : fmt::format("{} and {} more", first, parts.size() - 1);
}

}  // namespace

struct RasterSource::Impl {
  RasterInfo info;
  std::vector<Part> parts;
  std::list<std::size_t> open;  // of parts, the one used last in front
  std::mutex turn;
  std::optional<ScratchRaster> copy;

  Expected<void> lay_out();
  void gather_warnings();
  void use(std::size_t part);
  Expected<void> read_parts(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                            double* heights_m, std::int64_t stride);
  Expected<void> read_part(Part& part, std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                           double* heights_m, std::int64_t stride);
  bool needs_copy(const StageOptions& options) const;
  Expected<void> make_copy(const StageOptions& options);
};

/// Finds the grid that holds all parts and describes it.
Expected<void> RasterSource::Impl::lay_out() {
  const RasterFileInfo& first = parts.front().file.info();
  std::int64_t column0 = 0;
  std::int64_t row0 = 0;
  std::int64_t column1 = first.columns;
  std::int64_t row1 = first.rows;
  for (Part& part : parts) {
    info.inputs.push_back(part.file.info().input);
    if (&part != &parts.front()) {
      if (auto placed = place(first, part); !placed) return placed;
    }
    column0 = std::min(column0, part.column0);
    row0 = std::min(row0, part.row0);
    column1 = std::max(column1, part.column1());
    row1 = std::max(row1, part.row1());
  }
  for (Part& part : parts) {
    part.column0 -= column0;
    part.row0 -= row0;
  }
  info.path = name_of(parts);
  info.columns = column1 - column0;
  info.rows = row1 - row0;
  if (info.columns < 2 || info.rows < 2) {
    return fail(ErrorCode::kBadData,
                fmt::format("is {} x {} samples, and a surface needs at least 2 x 2; give it together with the DEMs "
                            "beside it",
                            info.columns, info.rows),
                info.path);
  }
  const GeoTransform& t = first.transform;
  const auto c = static_cast<double>(column0);
  const auto r = static_cast<double>(row0);
  info.geotransform = {t[0] + c * t[1] + r * t[2], t[1], t[2], t[3] + c * t[4] + r * t[5], t[4], t[5]};
  info.crs_wkt = first.crs_wkt;
  info.height_unit_m = first.height_unit_m;
  const auto frame = raster_frame(info.crs_wkt, info.geotransform, info.columns, info.rows);
  if (!frame) return fail(frame.error().code, frame.error().message, info.path);
  info.dx_m = frame->dx_m;
  info.dy_m = frame->dy_m;
  info.axes = frame->axes;
  info.geographic = frame->geographic;
  return {};
}

/// Every warning once, however many files it holds for.
void RasterSource::Impl::gather_warnings() {
  std::vector<std::string> seen;
  for (const Part& part : parts) {
    for (const std::string& warning : part.file.info().warnings) {
      if (std::ranges::find(seen, warning) != seen.end()) continue;
      seen.push_back(warning);
      info.warnings.push_back(parts.size() == 1 ? warning : part.file.info().input.path + ": " + warning);
    }
  }
}

/// Notes that a part is about to be read, and closes the one unused for longest when too many are open.
void RasterSource::Impl::use(std::size_t part) {
  const auto at = std::ranges::find(open, part);
  if (at != open.end()) open.erase(at);
  open.push_front(part);
  if (open.size() <= kOpenFiles) return;
  parts[open.back()].file.close();
  open.pop_back();
}

Expected<void> RasterSource::Impl::read_parts(std::int64_t column, std::int64_t row, std::int64_t width,
                                              std::int64_t height, double* heights_m, std::int64_t stride) {
  const std::scoped_lock lock(turn);
  if (parts.size() == 1) return parts.front().file.read(column, row, width, height, heights_m, stride);
  for (std::int64_t j = 0; j < height; ++j) std::fill_n(heights_m + j * stride, width, kNaN);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    Part& part = parts[i];
    const std::int64_t c0 = std::max(column, part.column0);
    const std::int64_t r0 = std::max(row, part.row0);
    const std::int64_t c1 = std::min(column + width, part.column1());
    const std::int64_t r1 = std::min(row + height, part.row1());
    if (c0 >= c1 || r0 >= r1) continue;
    use(i);
    double* first = heights_m + (r0 - row) * stride + (c0 - column);
    if (auto read = read_part(part, c0, r0, c1 - c0, r1 - r0, first, stride); !read) return read;
  }
  return {};
}

/// Lays a window of one part over what is there already.
Expected<void> RasterSource::Impl::read_part(Part& part, std::int64_t column, std::int64_t row, std::int64_t width,
                                             std::int64_t height, double* heights_m, std::int64_t stride) {
  std::vector<double> over(static_cast<std::size_t>(width * height));
  if (auto read = part.file.read(column - part.column0, row - part.row0, width, height, over.data(), width); !read) {
    return read;
  }
  for (std::int64_t j = 0; j < height; ++j) {
    for (std::int64_t i = 0; i < width; ++i) {
      const double height_m = over[static_cast<std::size_t>(j * width + i)];
      if (!std::isnan(height_m)) heights_m[j * stride + i] = height_m;
    }
  }
  return {};
}

bool RasterSource::Impl::needs_copy(const StageOptions& options) const {
  if (options.nodata == NodataPolicy::kFill) return true;
  WindowCost cost = WindowCost::kNone;
  std::uint64_t decoded_bytes = 0;
  for (const Part& part : parts) {
    cost = std::max(cost, part.file.info().window_cost);
    decoded_bytes += part.file.info().decoded_bytes;
  }
  if (cost == WindowCost::kScan && decoded_bytes > options.raster_cache_bytes) return true;
  return cost != WindowCost::kNone &&
         sizeof(float) * static_cast<double>(info.columns) * static_cast<double>(info.rows) >
             static_cast<double>(options.block_cache_bytes);
}

/// Reads everything once, in windows that follow the way the file is stored.
Expected<void> RasterSource::Impl::make_copy(const StageOptions& options) {
  const bool exact = std::ranges::all_of(parts, [](const Part& p) { return p.file.info().float_exact; });
  const bool by_rows = std::ranges::any_of(parts, [](const Part& p) { return p.file.info().stored_by_rows; });
  auto scratch = ScratchRaster::create(options.folder, info.columns, info.rows,
                                       exact ? ScratchSample::kFloat : ScratchSample::kDouble);
  if (!scratch) return tl::unexpected(scratch.error());
  const std::int64_t height = by_rows ? std::clamp<std::int64_t>(kCopySamples / info.columns, 1, kCopyRows) : kCopyRows;
  const std::int64_t width = by_rows ? info.columns : kCopySamples / kCopyRows;
  std::vector<double> window(static_cast<std::size_t>(std::min(width, info.columns) * height));
  for (std::int64_t row = 0; row < info.rows; row += height) {
    const std::int64_t h = std::min(height, info.rows - row);
    for (std::int64_t column = 0; column < info.columns; column += width) {
      const std::int64_t w = std::min(width, info.columns - column);
      auto done = read_parts(column, row, w, h, window.data(), w);
      if (done) done = scratch->write(column, row, w, h, window.data(), w);
      if (!done) return done;
    }
    if (options.progress &&
        !options.progress("copying rows", static_cast<std::uint64_t>(row + h), static_cast<std::uint64_t>(info.rows))) {
      return fail(ErrorCode::kStopped, "stopped while reading the DEM");
    }
  }
  for (Part& part : parts) {
    if (auto same = part.file.check_unchanged(); !same) return same;
    part.file.close();
  }
  copy = std::move(*scratch);
  open.clear();
  return {};
}

RasterSource::RasterSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RasterSource::RasterSource(RasterSource&&) noexcept = default;
RasterSource& RasterSource::operator=(RasterSource&&) noexcept = default;
RasterSource::~RasterSource() = default;

const RasterInfo& RasterSource::info() const { return impl_->info; }
bool RasterSource::is_copied() const { return impl_->copy.has_value(); }

Expected<void> RasterSource::check_unchanged() const {
  if (is_copied()) return {};
  for (const Part& part : impl_->parts) {
    if (auto same = part.file.check_unchanged(); !same) return same;
  }
  return {};
}

Expected<RasterSource> RasterSource::open(const std::vector<std::string>& paths) {
  if (paths.empty()) return fail(ErrorCode::kUsage, "no DEM is given");
  auto impl = std::make_unique<Impl>();
  for (const std::string& path : paths) {
    auto file = RasterFile::open(path);
    if (!file) return tl::unexpected(file.error());
    impl->parts.push_back({std::move(*file)});
    impl->use(impl->parts.size() - 1);
  }
  if (auto laid = impl->lay_out(); !laid) return tl::unexpected(laid.error());
  impl->gather_warnings();
  return RasterSource(std::move(impl));
}

Expected<void> RasterSource::stage(const StageOptions& options) {
  if (!impl_->needs_copy(options)) return {};
  if (auto copied = impl_->make_copy(options); !copied) return copied;
  if (options.nodata == NodataPolicy::kHole) return {};
  return fill_nodata(*impl_->copy, impl_->info.columns, impl_->info.rows, options.folder, options.progress);
}

Expected<void> RasterSource::read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                                  double* heights_m) const {
  const RasterInfo& info = impl_->info;
  const std::int64_t c0 = std::max<std::int64_t>(column, 0);
  const std::int64_t r0 = std::max<std::int64_t>(row, 0);
  const std::int64_t c1 = std::min(column + width, info.columns);
  const std::int64_t r1 = std::min(row + height, info.rows);
  if (c0 != column || r0 != row || c1 != column + width || r1 != row + height) {
    std::fill_n(heights_m, width * height, kNaN);
  }
  if (c0 >= c1 || r0 >= r1) return {};
  double* first = heights_m + (r0 - row) * width + (c0 - column);
  if (impl_->copy) return impl_->copy->read(c0, r0, c1 - c0, r1 - r0, first, width);
  return impl_->read_parts(c0, r0, c1 - c0, r1 - r0, first, width);
}

}  // namespace tintree::cache
