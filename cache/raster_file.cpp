#include "cache/raster_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include <fmt/format.h>
#include <gdal_priv.h>
#include <malloc.h>
#include <ogr_spatialref.h>
#include <sys/stat.h>

#include "cache/gdal_message.h"

namespace tintree::cache {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string wkt_of(const OGRSpatialReference* srs) {
  if (srs == nullptr) return {};
  char* text = nullptr;
  const char* const newer[] = {"FORMAT=WKT2_2019", nullptr};
  if (srs->exportToWkt(&text) != OGRERR_NONE) {
    CPLFree(text);
    text = nullptr;
    srs->exportToWkt(&text, newer);
  }
  std::string wkt = text == nullptr ? "" : text;
  CPLFree(text);
  return wkt;
}

/// How to ask for one of the rasters that a container holds; empty when it is none.
std::string first_subdataset(GDALDataset& dataset) {
  const char* name = dataset.GetMetadataItem("SUBDATASET_1_NAME", "SUBDATASETS");
  return name == nullptr ? "" : name;
}

}  // namespace

void register_drivers() {
  static std::once_flag registered;
  std::call_once(registered, [] {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);
    // Else what is missing of a JPEG is grey, without a word. Who wants it that way may say so.
    constexpr const char* kJpegErrors = "GDAL_ERROR_ON_LIBJPEG_WARNING";
    if (CPLGetConfigOption(kJpegErrors, nullptr) == nullptr) CPLSetConfigOption(kJpegErrors, "YES");
  });
}

InputFile describe_input(const std::string& path) {
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) return {path};
  return {path, static_cast<std::uint64_t>(file.st_size), file.st_mtime};
}

struct RasterFile::Impl {
  RasterFileInfo info;
  GDALDatasetUniquePtr dataset;
  GDALRasterBand* band = nullptr;
  bool has_nodata = false;
  double nodata = 0;
  bool has_mask = false;
  double scale = 1;   // stored value -> metres
  double offset = 0;  // metres
  bool flip_columns = false;
  bool flip_rows = false;

  Expected<void> open_dataset();
  Expected<void> describe();
  void describe_grid();
  void describe_heights();
  void describe_nodata();
  void describe_blocks();
  void to_metres(double* line, std::int64_t width, const unsigned char* mask) const;
};

Expected<void> RasterFile::Impl::open_dataset() {
  const std::string& path = info.input.path;
  struct stat file {};
  const bool is_file = ::stat(path.c_str(), &file) == 0;
  if (is_file && S_ISDIR(file.st_mode)) return fail(ErrorCode::kIo, "is a directory, not a raster", path);
  CPLErrorReset();
  dataset.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset) {
    if (!is_file && path.find(':') == std::string::npos) return fail(ErrorCode::kIo, "no such file", path);
    return fail(ErrorCode::kBadData, "is no raster that GDAL can read (" + last_gdal_message() + ")", path);
  }
  if (dataset->GetRasterCount() < 1) {
    const std::string part = first_subdataset(*dataset);
    return fail(ErrorCode::kBadData,
                part.empty() ? "holds no raster band" : "holds several rasters; name one of them, as in '" + part + "'",
                path);
  }
  band = dataset->GetRasterBand(1);
  return {};
}

Expected<void> RasterFile::Impl::describe() {
  if (GDALDataTypeIsComplex(band->GetRasterDataType()) != 0) {
    return fail(ErrorCode::kBadData, "holds complex numbers, not heights", info.input.path);
  }
  info.columns = dataset->GetRasterXSize();
  info.rows = dataset->GetRasterYSize();
  const bool alpha = dataset->GetRasterCount() == 2 && (band->GetMaskFlags() & GMF_ALPHA) != 0;
  if (dataset->GetRasterCount() > 1 && !alpha) {
    info.warnings.emplace_back("several bands: heights are read from the first");
  }
  describe_grid();
  describe_heights();
  describe_nodata();
  describe_blocks();
  return {};
}

void RasterFile::Impl::describe_grid() {
  info.crs_wkt = wkt_of(dataset->GetSpatialRef());
  GeoTransform& t = info.transform;
  info.georeferenced = dataset->GetGeoTransform(t.data()) == CE_None;
  if (!info.georeferenced) {
    t = {0, 1, 0, 0, 0, -1};
    info.crs_wkt.clear();
    info.warnings.emplace_back("no georeference: sample spacing taken as 1 m");
    return;
  }
  if (info.crs_wkt.empty()) {
    info.warnings.emplace_back(
        "no coordinate reference system: its units are taken as metres; if they are not, state it (gdal_edit.py "
        "-a_srs)");
  }
  // Mirrored west to east, then north to south, as the corner moves to the other end.
  flip_columns = t[1] < 0;
  if (flip_columns) {
    const auto columns = static_cast<double>(info.columns);
    t = {t[0] + columns * t[1], -t[1], t[2], t[3] + columns * t[4], -t[4], t[5]};
  }
  flip_rows = t[1] * t[5] - t[2] * t[4] > 0;
  if (flip_rows) {
    const auto rows = static_cast<double>(info.rows);
    t = {t[0] + rows * t[2], t[1], -t[2], t[3] + rows * t[5], t[4], -t[5]};
  }
}

void RasterFile::Impl::describe_heights() {
  const OGRSpatialReference* srs = info.crs_wkt.empty() ? nullptr : dataset->GetSpatialRef();
  const std::string unit = band->GetUnitType();
  double unit_m = unit.empty() ? 0 : unit_in_metres(unit);
  if (!unit.empty() && unit_m == 0) {
    info.warnings.push_back(fmt::format("height unit '{}' is unknown: taken as metres", unit));
    unit_m = 1;
  }
  if (unit_m == 0 && srs != nullptr && srs->IsCompound() != 0) unit_m = srs->GetTargetLinearUnits("COMPD_CS|VERT_CS");
  if (unit_m == 0 && srs != nullptr && srs->IsProjected() != 0 && srs->GetLinearUnits() != 1) {
    unit_m = srs->GetLinearUnits();
    info.warnings.emplace_back("no height unit stated: taken as the unit of the coordinate reference system");
  }
  info.height_unit_m = unit_m > 0 ? unit_m : 1;
  scale = band->GetScale() * info.height_unit_m;
  offset = band->GetOffset() * info.height_unit_m;
  const GDALDataType type = band->GetRasterDataType();
  const bool float_type = type == GDT_Byte || type == GDT_Int16 || type == GDT_UInt16 || type == GDT_Float32;
  info.float_exact = float_type && scale == 1 && offset == 0;
}

void RasterFile::Impl::describe_nodata() {
  int stated = 0;
  const GDALDataType type = band->GetRasterDataType();
  if (type == GDT_Int64) {
    nodata = static_cast<double>(band->GetNoDataValueAsInt64(&stated));
  } else if (type == GDT_UInt64) {
    nodata = static_cast<double>(band->GetNoDataValueAsUInt64(&stated));
  } else {
    nodata = band->GetNoDataValue(&stated);
  }
  has_nodata = stated != 0;
  // A value that a 32-bit band cannot hold exactly is met there in its rounded form.
  if (has_nodata && type == GDT_Float32) nodata = static_cast<float>(nodata);
  const int flags = band->GetMaskFlags();
  has_mask = (flags & GMF_ALL_VALID) == 0 && !(has_nodata && (flags & GMF_NODATA) != 0);
}

void RasterFile::Impl::describe_blocks() {
  int across = 0;
  int down = 0;
  band->GetBlockSize(&across, &down);
  const auto sample = static_cast<std::uint64_t>(GDALGetDataTypeSizeBytes(band->GetRasterDataType()));
  const auto samples = static_cast<std::uint64_t>(info.columns) * static_cast<std::uint64_t>(info.rows);
  const std::uint64_t block = static_cast<std::uint64_t>(across) * static_cast<std::uint64_t>(down);
  info.decoded_bytes = samples * sample;
  info.stored_by_rows = across >= info.columns;
  const bool tiled = across >= 64 && down >= 64 && across <= 1024 && down <= 1024;
  const std::string driver = dataset->GetDriverName();
  if (tiled && driver == "GTiff") {
    const bool packed = dataset->GetMetadataItem("COMPRESSION", "IMAGE_STRUCTURE") != nullptr;
    info.window_cost = packed ? WindowCost::kDecode : WindowCost::kNone;
  }
  const bool tiny = block < 64 && samples > std::uint64_t{1} << 20;
  const bool huge = block * sample > std::uint64_t{512} << 20;
  if (tiny || huge) {
    info.warnings.push_back(
        fmt::format("is stored in blocks of {} x {} samples, which takes {} to read; convert it first (gdal_translate "
                    "-co TILED=YES)",
                    across, down, tiny ? "long" : "much memory"));
  }
}

RasterFile::RasterFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RasterFile::RasterFile(RasterFile&&) noexcept = default;
RasterFile& RasterFile::operator=(RasterFile&&) noexcept = default;
RasterFile::~RasterFile() = default;

const RasterFileInfo& RasterFile::info() const { return impl_->info; }
bool RasterFile::is_open() const { return impl_->dataset != nullptr; }
void RasterFile::close() { impl_->dataset.reset(); }

Expected<void> RasterFile::check_unchanged() const {
  const InputFile& before = impl_->info.input;
  const InputFile now = describe_input(before.path);
  // Before, it was no file of this name; now, it is one no more.
  if (before.modified_s == 0 || now.modified_s == 0 || now == before) return {};
  return fail(ErrorCode::kIo, "the file was changed while it was being read; restore it", before.path);
}

Expected<RasterFile> RasterFile::open(const std::string& path) {
  register_drivers();
  auto impl = std::make_unique<Impl>();
  impl->info.input = describe_input(path);
  if (auto opened = impl->open_dataset(); !opened) return tl::unexpected(opened.error());
  if (auto described = impl->describe(); !described) return tl::unexpected(described.error());
  return RasterFile(std::move(impl));
}

Expected<void> RasterFile::read(std::int64_t column, std::int64_t row, std::int64_t width, std::int64_t height,
                                double* heights_m, std::int64_t stride) {
  Impl& file = *impl_;
  if (!is_open()) {
    if (auto same = check_unchanged(); !same) return same;
    if (auto opened = file.open_dataset(); !opened) return opened;
  }
  const auto c = static_cast<int>(file.flip_columns ? file.info.columns - column - width : column);
  const auto r = static_cast<int>(file.flip_rows ? file.info.rows - row - height : row);
  const auto w = static_cast<int>(width);
  const auto h = static_cast<int>(height);
  std::vector<unsigned char> mask;
  CPLErrorReset();
  bool ok = file.band->RasterIO(GF_Read, c, r, w, h, heights_m, w, h, GDT_Float64, sizeof(double),
                                stride * GSpacing{sizeof(double)}, nullptr) == CE_None;
  if (ok && file.has_mask) {
    mask.resize(static_cast<std::size_t>(width * height));
    ok = file.band->GetMaskBand()->RasterIO(GF_Read, c, r, w, h, mask.data(), w, h, GDT_Byte, 0, 0, nullptr) == CE_None;
  }
  if (!ok) {
    return fail(ErrorCode::kIo, fmt::format("cannot read rows {} to {} ({})", r, r + h - 1, last_gdal_message()),
                file.info.input.path);
  }
  for (std::int64_t j = 0; j < height; ++j) {
    double* line = heights_m + j * stride;
    file.to_metres(line, width, mask.empty() ? nullptr : mask.data() + j * width);
    if (file.flip_columns) std::reverse(line, line + width);
  }
  for (std::int64_t j = 0; file.flip_rows && j < height / 2; ++j) {
    std::swap_ranges(heights_m + j * stride, heights_m + j * stride + width, heights_m + (height - 1 - j) * stride);
  }
  return {};
}

void RasterFile::Impl::to_metres(double* line, std::int64_t width, const unsigned char* mask) const {
  const bool plain = scale == 1 && offset == 0;
  for (std::int64_t i = 0; i < width; ++i) {
    const double value = line[i];
    const bool valid = !(has_nodata && value == nodata) && std::isfinite(value) && (mask == nullptr || mask[i] != 0);
    line[i] = !valid ? kNaN : plain ? value : value * scale + offset;
  }
}

void set_raster_cache_bytes(std::uint64_t bytes) {
  GDALSetCacheMax64(static_cast<GIntBig>(bytes));
  // Blocks that GDAL has dropped lie between others in the heap, where the C library would keep their room.
  ::malloc_trim(0);
}

}  // namespace tintree::cache
