#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cache/scratch_raster.h"
#include "codec/error.h"

namespace tintree::cache {

/// Gives the missing samples (NaN) of `heights` a height by GDALFillNodata: inverse distance weighting of the
/// nearest heights within kFillDistance samples, no smoothing, as gdal_fillnodata does unless told otherwise.
/// Samples farther from any height stay missing; those that exist stay as they are, to the last bit.
/// Memory: a few rows and GDAL's block cache. Temporary files in `folder`: about 13 bytes a sample.
Expected<void> fill_nodata(ScratchRaster& heights, std::int64_t columns, std::int64_t rows, const std::string& folder,
                           const std::function<bool(const std::string&, std::uint64_t, std::uint64_t)>& progress);

}  // namespace tintree::cache
