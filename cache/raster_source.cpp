#include "cache/raster_source.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <sys/stat.h>

namespace tintree::cache {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Metres per degree of latitude and of longitude at `latitude_deg` on the CRS's ellipsoid: the radii of
/// curvature in the meridian and in the prime vertical.
std::array<double, 2> metres_per_degree(const OGRSpatialReference& srs, double latitude_deg) {
  const double a = srs.GetSemiMajor();
  const double b = srs.GetSemiMinor();
  const double e2 = 1 - (b * b) / (a * a);
  const double s = std::sin(latitude_deg * kDegree);
  const double w2 = 1 - e2 * s * s;
  const double meridian = a * (1 - e2) / (w2 * std::sqrt(w2));
  const double prime_vertical = a / std::sqrt(w2);
  return {meridian * kDegree, prime_vertical * std::cos(latitude_deg * kDegree) * kDegree};
}

/// Metres per unit for the unit names that drivers write, or 0 for one we do not know.
double unit_in_metres(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name == "m" || name == "metre" || name == "meter" || name == "metres" || name == "meters") return 1;
  if (name == "ft" || name == "foot" || name == "feet" || name == "international foot") return 0.3048;
  if (name == "us-ft" || name == "ftus" || name == "us survey foot" || name == "us_survey_foot" || name == "foot_us") {
    return 1200.0 / 3937.0;
  }
  if (name == "cm" || name == "centimetre" || name == "centimeter") return 0.01;
  if (name == "mm" || name == "millimetre" || name == "millimeter") return 0.001;
  if (name == "km" || name == "kilometre" || name == "kilometer") return 1000;
  return 0;
}

std::string last_gdal_message() {
  const std::string message = CPLGetLastErrorMsg();
  return message.empty() ? "GDAL gives no reason" : message;
}

}  // namespace

struct RasterSource::Impl {
  GDALDatasetUniquePtr dataset;
  GDALRasterBand* band = nullptr;
  bool has_nodata = false;
  double nodata = 0;
  bool has_mask = false;
  double scale = 1;   // stored value -> metres
  double offset = 0;  // metres
  RasterInfo info;
  mutable std::mutex turn;

  Expected<void> describe_grid();
  void describe_heights();
};

Expected<void> RasterSource::Impl::describe_grid() {
  if (dataset->GetGeoTransform(info.geotransform.data()) != CE_None) {
    info.geotransform = {0, 1, 0, 0, 0, -1};
    info.warnings.emplace_back("no georeference: sample spacing taken as 1 m");
    return {};
  }
  const auto& gt = info.geotransform;
  if (gt[2] != 0 || gt[4] != 0 || gt[1] <= 0 || gt[5] >= 0) {
    return fail(ErrorCode::kBadData, "the raster is rotated or not north-up; warp it first (gdalwarp)", info.path);
  }
  const OGRSpatialReference* srs = dataset->GetSpatialRef();
  if (srs == nullptr) {
    info.dx_m = gt[1];
    info.dy_m = -gt[5];
    info.warnings.emplace_back("no coordinate reference system: its units are taken as metres");
    return {};
  }
  char* wkt = nullptr;
  if (srs->exportToWkt(&wkt) == OGRERR_NONE) info.crs_wkt = wkt;
  CPLFree(wkt);
  info.geographic = srs->IsGeographic() != 0;
  if (info.geographic) {
    const double degrees = srs->GetAngularUnits() / kDegree;
    const double middle = gt[3] + gt[5] * static_cast<double>(info.rows) / 2;
    const auto [per_latitude, per_longitude] = metres_per_degree(*srs, middle * degrees);
    info.dx_m = gt[1] * degrees * per_longitude;
    info.dy_m = -gt[5] * degrees * per_latitude;
  } else {
    info.dx_m = gt[1] * srs->GetLinearUnits();
    info.dy_m = -gt[5] * srs->GetLinearUnits();
  }
  if (!(info.dx_m > 0) || !(info.dy_m > 0) || !std::isfinite(info.dx_m) || !std::isfinite(info.dy_m)) {
    return fail(ErrorCode::kBadData,
                "the georeference gives no positive sample spacing; repair it (gdal_edit.py -a_ullr)", info.path);
  }
  return {};
}

void RasterSource::Impl::describe_heights() {
  const OGRSpatialReference* srs = dataset->GetSpatialRef();
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

  int stated = 0;
  nodata = band->GetNoDataValue(&stated);
  has_nodata = stated != 0;
  // A value that a 32-bit band cannot hold exactly is met there in its rounded form.
  if (has_nodata && band->GetRasterDataType() == GDT_Float32) nodata = static_cast<float>(nodata);
  has_mask = (band->GetMaskFlags() & (GMF_ALL_VALID | GMF_NODATA)) == 0;
}

RasterSource::RasterSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RasterSource::RasterSource(RasterSource&&) noexcept = default;
RasterSource& RasterSource::operator=(RasterSource&&) noexcept = default;
RasterSource::~RasterSource() = default;

const RasterInfo& RasterSource::info() const { return impl_->info; }

Expected<RasterSource> RasterSource::open(const std::string& path) {
  static std::once_flag registered;
  std::call_once(registered, [] {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);
  });
  struct stat file {};
  const bool is_file = ::stat(path.c_str(), &file) == 0;
  if (is_file && S_ISDIR(file.st_mode)) return fail(ErrorCode::kIo, "is a directory, not a raster", path);

  CPLErrorReset();
  auto impl = std::make_unique<Impl>();
  impl->dataset.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!impl->dataset) {
    if (!is_file) return fail(ErrorCode::kIo, "no such file", path);
    return fail(ErrorCode::kBadData, "is no raster that GDAL can read (" + last_gdal_message() + ")", path);
  }
  if (impl->dataset->GetRasterCount() < 1) return fail(ErrorCode::kBadData, "holds no raster band", path);
  impl->band = impl->dataset->GetRasterBand(1);
  if (GDALDataTypeIsComplex(impl->band->GetRasterDataType()) != 0) {
    return fail(ErrorCode::kBadData, "holds complex numbers, not heights", path);
  }
  RasterInfo& info = impl->info;
  info.path = path;
  info.columns = impl->dataset->GetRasterXSize();
  info.rows = impl->dataset->GetRasterYSize();
  info.file_bytes = is_file ? static_cast<std::uint64_t>(file.st_size) : 0;
  info.modified_s = is_file ? file.st_mtime : 0;
  if (info.columns < 2 || info.rows < 2) {
    return fail(ErrorCode::kBadData,
                fmt::format("is {} x {} samples; a surface needs at least 2 x 2", info.columns, info.rows), path);
  }
  if (impl->dataset->GetRasterCount() > 1) info.warnings.emplace_back("several bands: heights are read from the first");
  if (auto described = impl->describe_grid(); !described) return tl::unexpected(described.error());
  impl->describe_heights();
  return RasterSource(std::move(impl));
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

  const auto w = static_cast<int>(c1 - c0);
  const auto h = static_cast<int>(r1 - r0);
  double* first = heights_m + (r0 - row) * width + (c0 - column);
  std::vector<unsigned char> mask;
  {
    const std::scoped_lock lock(impl_->turn);
    CPLErrorReset();
    bool ok = impl_->band->RasterIO(GF_Read, static_cast<int>(c0), static_cast<int>(r0), w, h, first, w, h, GDT_Float64,
                                    sizeof(double), static_cast<GSpacing>(width) * GSpacing{sizeof(double)},
                                    nullptr) == CE_None;
    if (ok && impl_->has_mask) {
      mask.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
      ok = impl_->band->GetMaskBand()->RasterIO(GF_Read, static_cast<int>(c0), static_cast<int>(r0), w, h, mask.data(),
                                                w, h, GDT_Byte, 0, 0, nullptr) == CE_None;
    }
    if (!ok) {
      return fail(ErrorCode::kIo, fmt::format("cannot read rows {} to {} ({})", r0, r1 - 1, last_gdal_message()),
                  info.path);
    }
  }
  const bool plain = impl_->scale == 1 && impl_->offset == 0;
  for (std::int64_t j = 0; j < h; ++j) {
    double* line = first + j * width;
    for (std::int64_t i = 0; i < w; ++i) {
      const double value = line[i];
      const bool valid = !(impl_->has_nodata && value == impl_->nodata) && std::isfinite(value) &&
                         (mask.empty() || mask[static_cast<std::size_t>(j * w + i)] != 0);
      line[i] = !valid ? kNaN : plain ? value : value * impl_->scale + impl_->offset;
    }
  }
  return {};
}

void set_raster_cache_bytes(std::uint64_t bytes) { GDALSetCacheMax64(static_cast<GIntBig>(bytes)); }

}  // namespace tintree::cache
