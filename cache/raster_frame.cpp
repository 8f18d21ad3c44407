#include "cache/raster_frame.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include <ogr_spatialref.h>

namespace tintree::cache {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Metres per degree of longitude and of latitude at `latitude_deg` on the CRS's ellipsoid: the radii of
/// curvature in the prime vertical and in the meridian.
std::array<double, 2> metres_per_degree(const OGRSpatialReference& srs, double latitude_deg) {
  const double a = srs.GetSemiMajor();
  const double b = srs.GetSemiMinor();
  const double e2 = 1 - (b * b) / (a * a);
  const double s = std::sin(latitude_deg * kDegree);
  const double w2 = 1 - e2 * s * s;
  const double meridian = a * (1 - e2) / (w2 * std::sqrt(w2));
  const double prime_vertical = a / std::sqrt(w2);
  return {prime_vertical * std::cos(latitude_deg * kDegree) * kDegree, meridian * kDegree};
}

}  // namespace

Expected<RasterFrame> raster_frame(const std::string& crs_wkt, const GeoTransform& t, std::int64_t columns,
                                   std::int64_t rows) {
  RasterFrame frame;
  std::array<double, 2> unit_m{1, 1};
  OGRSpatialReference srs;
  if (!crs_wkt.empty() && srs.importFromWkt(crs_wkt.c_str()) == OGRERR_NONE) {
    frame.geographic = srs.IsGeographic() != 0;
    if (frame.geographic) {
      const double degrees = srs.GetAngularUnits() / kDegree;
      const double middle = t[3] + (t[4] * static_cast<double>(columns) + t[5] * static_cast<double>(rows)) / 2;
      unit_m = metres_per_degree(srs, middle * degrees);
      for (double& m : unit_m) m *= degrees;
    } else {
      unit_m = {srs.GetLinearUnits(), srs.GetLinearUnits()};
    }
  }
  const std::array<double, 2> column{t[1] * unit_m[0], t[4] * unit_m[1]};
  const std::array<double, 2> row{t[2] * unit_m[0], t[5] * unit_m[1]};
  frame.dx_m = std::hypot(column[0], column[1]);
  frame.dy_m = std::hypot(row[0], row[1]);
  frame.axes.column = {column[0] / frame.dx_m, column[1] / frame.dx_m};
  frame.axes.row = {row[0] / frame.dy_m, row[1] / frame.dy_m};
  const double area = frame.axes.row[0] * frame.axes.column[1] - frame.axes.row[1] * frame.axes.column[0];
  if (!(area > 1e-6) || !std::isfinite(frame.dx_m) || !std::isfinite(frame.dy_m)) {
    return fail(ErrorCode::kBadData,
                "the georeference gives no positive sample spacing; repair it (gdal_edit.py -a_ullr)");
  }
  return frame;
}

bool same_crs(const std::string& wkt_a, const std::string& wkt_b) {
  if (wkt_a == wkt_b) return true;
  OGRSpatialReference a;
  OGRSpatialReference b;
  return a.importFromWkt(wkt_a.c_str()) == OGRERR_NONE && b.importFromWkt(wkt_b.c_str()) == OGRERR_NONE &&
         a.IsSame(&b) != 0;
}

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

}  // namespace tintree::cache
