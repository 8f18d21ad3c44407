#include "cache/warped_photo.h"

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <utility>

#include <gdal_alg.h>
#include <gdal_priv.h>
#include <gdalwarper.h>

#include "cache/gdal_message.h"
#include "cache/photo_place.h"

namespace tintree::cache {
namespace {

/// How far GDAL may take positions by interpolation, pixels of the warped picture.
constexpr double kPositionTolerance = 0.05;

struct WarpOptionsCloser {
  void operator()(GDALWarpOptions* o) const { GDALDestroyWarpOptions(o); }
};

}  // namespace

Expected<WarpedPhoto> WarpedPhoto::make(const Photo& photo, const RasterInfo& dem, double step) {
  GDALDataset& dataset = photo.dataset();
  const GeoTransform nodes = node_transform(dem.geotransform, step);
  auto exact = make_transformer(photo, dem, nodes);
  if (!exact) return tl::unexpected(exact.error());
  std::unique_ptr<GDALWarpOptions, WarpOptionsCloser> options(GDALCreateWarpOptions());
  options->hSrcDS = GDALDataset::ToHandle(&dataset);
  options->eResampleAlg = GRA_Cubic;
  options->eWorkingDataType = GDT_Byte;
  options->nBandCount = 3;
  options->panSrcBands = static_cast<int*>(CPLMalloc(3 * sizeof(int)));
  options->panDstBands = static_cast<int*>(CPLMalloc(3 * sizeof(int)));
  bool has_nodata = true;
  std::array<double, 3> nodata{};
  for (std::size_t k = 0; k < 3; ++k) {
    options->panSrcBands[k] = photo.bands()[k];
    options->panDstBands[k] = static_cast<int>(k) + 1;
    int stated = 0;
    nodata[k] = dataset.GetRasterBand(photo.bands()[k])->GetNoDataValue(&stated);
    has_nodata = has_nodata && stated != 0;
  }
  options->nSrcAlphaBand = photo.alpha_band();
  options->nDstAlphaBand = 4;
  options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "INIT_DEST", "0");
  if (has_nodata && photo.alpha_band() == 0) {
    options->padfSrcNoDataReal = static_cast<double*>(CPLMalloc(sizeof nodata));
    std::ranges::copy(nodata, options->padfSrcNoDataReal);
    options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "UNIFIED_SRC_NODATA", "YES");
  }
  options->pTransformerArg = GDALCreateApproxTransformer(GDALGenImgProjTransform, exact->release(), kPositionTolerance);
  GDALApproxTransformerOwnsSubtransformer(options->pTransformerArg, TRUE);
  options->pfnTransformer = GDALApproxTransform;
  const auto side = [step](std::int64_t samples) {
    // As far again beyond the DEM as the largest tile can reach.
    const double nodes_across = 2 * static_cast<double>(samples) / step + 4.0 * static_cast<double>(kNodesBefore);
    return static_cast<int>(std::min<double>(nodes_across, std::numeric_limits<int>::max()));
  };
  GeoTransform place = nodes;
  DatasetPtr out(GDALDataset::FromHandle(
      GDALCreateWarpedVRT(options->hSrcDS, side(dem.columns), side(dem.rows), place.data(), options.get())));
  if (!out)
    return fail(ErrorCode::kBadData, "cannot be warped onto the DEM (" + last_gdal_message() + ")", photo.path());
  return WarpedPhoto(std::move(out), photo.path());
}

Expected<void> WarpedPhoto::read(std::int64_t column0, std::int64_t row0, int width, int height,
                                 std::span<std::uint8_t> rgba) const {
  CPLErrorReset();
  const CPLErr rc =
      nodes_->RasterIO(GF_Read, static_cast<int>(column0 + kNodesBefore), static_cast<int>(row0 + kNodesBefore), width,
                       height, rgba.data(), width, height, GDT_Byte, 4, nullptr, 4, GSpacing{4} * width, 1, nullptr);
  if (rc != CE_None) return fail(ErrorCode::kIo, "cannot be read (" + last_gdal_message() + ")", path_);
  return {};
}

}  // namespace tintree::cache
