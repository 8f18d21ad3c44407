#include "cache/photo_place.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <gdal_alg.h>
#include <gdal_priv.h>

#include "cache/gdal_message.h"

namespace tintree::cache {

void TransformerCloser::operator()(void* transformer) const { GDALDestroyTransformer(transformer); }

GeoTransform node_transform(const GeoTransform& dem, double step) {
  const double corner = 0.5 - step * (0.5 + static_cast<double>(kNodesBefore));
  return {dem[0] + corner * (dem[1] + dem[2]), step * dem[1], step * dem[2],
          dem[3] + corner * (dem[4] + dem[5]), step * dem[4], step * dem[5]};
}

Expected<Transformer> make_transformer(const Photo& photo, const RasterInfo& dem, const GeoTransform& nodes) {
  GDALDataset& dataset = photo.dataset();
  char** options = nullptr;
  // Where either states no CRS, both are taken to have one.
  const OGRSpatialReference* own = dataset.GetSpatialRef();
  if (own == nullptr) own = dataset.GetGCPSpatialRef();
  if (!dem.crs_wkt.empty() && own != nullptr) options = CSLSetNameValue(options, "DST_SRS", dem.crs_wkt.c_str());
  CPLErrorReset();
  Transformer out(GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(&dataset), nullptr, options));
  CSLDestroy(options);
  if (!out && own != nullptr && own->IsLocal()) {
    return fail(
        ErrorCode::kBadData,
        "has a local coordinate system, which nothing can be brought from to the coordinates of the DEM; give it "
        "its true one first (gdal_translate -a_srs)",
        photo.path());
  }
  if (!out) {
    return fail(
        ErrorCode::kBadData,
        "cannot be brought to the coordinates of the DEM (" + last_gdal_message() + "); reproject it first (gdalwarp)",
        photo.path());
  }
  GDALSetGenImgProjTransformerDstGeoTransform(out.get(), nodes.data());
  return out;
}

bool PhotoPlace::reaches(const codec::CellRect& cells) const {
  return low[0] < static_cast<double>(cells.column1) && low[1] < static_cast<double>(cells.row1) &&
         high[0] > static_cast<double>(cells.column0) && high[1] > static_cast<double>(cells.row0);
}

void PhotoPlace::add(double column, double row) {
  low = {std::min(low[0], column), std::min(low[1], row)};
  high = {std::max(high[0], column), std::max(high[1], row)};
}

void PhotoPlace::add_everything() {
  add(-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
  add(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
}

Expected<PhotoPlace> place_photo(const Photo& photo, const RasterInfo& dem) {
  auto to_photo = make_transformer(photo, dem, node_transform(dem.geotransform, 1));
  if (!to_photo) return tl::unexpected(to_photo.error());
  const double width = photo.dataset().GetRasterXSize();
  const double height = photo.dataset().GetRasterYSize();
  constexpr int kProbes = 17;
  constexpr double kCentre = 0.5 + kNodesBefore;
  const auto move = [&](bool to_dem, double x, double y) -> std::optional<std::array<double, 2>> {
    double z = 0;
    int done = 0;
    const int inverse = to_dem ? FALSE : TRUE;
    if (GDALGenImgProjTransform(to_photo->get(), inverse, 1, &x, &y, &z, &done) == 0 || done == 0) return std::nullopt;
    return std::array{x, y};
  };
  PhotoPlace out;
  for (int k = 0; k < kProbes * kProbes; ++k) {
    const double u = static_cast<double>(k % kProbes) / (kProbes - 1);
    const double v = static_cast<double>(k / kProbes) / (kProbes - 1);
    const auto columns = static_cast<double>(dem.columns - 1);
    const auto rows = static_cast<double>(dem.rows - 1);
    const auto there = move(false, kCentre + u * columns, kCentre + v * rows);
    out.meets |= there && (*there)[0] >= 0 && (*there)[0] <= width && (*there)[1] >= 0 && (*there)[1] <= height;
    const auto here = move(true, u * width, v * height);
    if (here) {
      out.add((*here)[0] - kCentre, (*here)[1] - kCentre);
    } else {
      out.add_everything();
    }
    out.meets |= here && (*here)[0] >= kCentre && (*here)[0] <= kCentre + columns && (*here)[1] >= kCentre &&
                 (*here)[1] <= kCentre + rows;
  }
  const auto a = move(true, width / 2, height / 2);
  const auto b = move(true, width / 2 + 1, height / 2);
  const auto c = move(true, width / 2, height / 2 + 1);
  if (a && b && c) {
    const double area = ((*b)[0] - (*a)[0]) * ((*c)[1] - (*a)[1]) - ((*b)[1] - (*a)[1]) * ((*c)[0] - (*a)[0]);
    out.pixel_samples = std::sqrt(std::abs(area));
  }
  return out;
}

}  // namespace tintree::cache
