#include "cache/photo.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <unistd.h>

#include "cache/gdal_message.h"

namespace tintree::cache {
namespace {

bool stored_by_rows(GDALDataset& dataset) {
  int across = 0;
  int down = 0;
  dataset.GetRasterBand(1)->GetBlockSize(&across, &down);
  return across >= dataset.GetRasterXSize();
}

std::uint64_t decoded_bytes(GDALDataset& dataset) {
  return static_cast<std::uint64_t>(dataset.GetRasterXSize()) * static_cast<std::uint64_t>(dataset.GetRasterYSize()) *
         static_cast<std::uint64_t>(dataset.GetRasterCount());
}

}  // namespace

void DatasetCloser::operator()(GDALDataset* dataset) const { GDALClose(GDALDataset::ToHandle(dataset)); }

Expected<Photo> Photo::open(const std::string& path) {
  Photo out(path);
  CPLErrorReset();
  out.dataset_.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR));
  if (!out.dataset_) {
    const bool missing = ::access(path.c_str(), F_OK) != 0 && path.find(':') == std::string::npos;
    if (missing) return fail(ErrorCode::kIo, "no such file", path);
    return fail(ErrorCode::kBadData, "is no picture that GDAL can read (" + last_gdal_message() + ")", path);
  }
  if (out.dataset_->GetRasterCount() < 1) return fail(ErrorCode::kBadData, "holds no raster band", path);
  if (out.dataset_->GetRasterBand(1)->GetColorTable() != nullptr) {
    if (auto expanded = out.expand_palette(); !expanded) return tl::unexpected(expanded.error());
  }
  if (auto described = out.describe_bands(); !described) return tl::unexpected(described.error());
  return out;
}

Expected<void> Photo::expand_palette() {
  std::array<std::string, 4> words{"-of", "VRT", "-expand", "rgba"};
  std::array<char*, 5> arguments{words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  GDALTranslateOptions* options = GDALTranslateOptionsNew(arguments.data(), nullptr);
  GDALDatasetH out = GDALTranslate("", GDALDataset::ToHandle(dataset_.get()), options, nullptr);
  GDALTranslateOptionsFree(options);
  if (out == nullptr)
    return fail(ErrorCode::kBadData, "its colour table cannot be used (" + last_gdal_message() + ")", path_);
  indices_ = std::exchange(dataset_, DatasetPtr(GDALDataset::FromHandle(out)));
  return {};
}

Expected<void> Photo::describe_bands() {
  const int count = dataset_->GetRasterCount();
  for (int b = 1; b <= count; ++b) {
    if (dataset_->GetRasterBand(b)->GetColorInterpretation() == GCI_AlphaBand) alpha_band_ = b;
  }
  const int colors = count - (alpha_band_ > 0 ? 1 : 0);
  if (colors >= 3) {
    bands_ = {1, 2, 3};
    constexpr std::array<GDALColorInterp, 3> kNamed{GCI_RedBand, GCI_GreenBand, GCI_BlueBand};
    std::array<int, 3> named{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (int b = 1; b <= count; ++b) {
        if (dataset_->GetRasterBand(b)->GetColorInterpretation() == kNamed[k]) named[k] = b;
      }
    }
    if (std::ranges::all_of(named, [](int b) { return b > 0; })) bands_ = named;
  }
  for (const int b : bands_) {
    const GDALDataType type = dataset_->GetRasterBand(b)->GetRasterDataType();
    if (type != GDT_Byte) {
      return fail(
          ErrorCode::kBadData,
          fmt::format(
              "holds {} samples, not colours of 8 bits; convert it first, with one range for all bands, which keeps "
              "its colours (gdal_translate -ot Byte -scale LEAST MOST 0 255)",
              GDALGetDataTypeName(type)),
          path_);
    }
  }
  return {};
}

bool Photo::has_place() const {
  std::array<double, 6> transform{};
  return dataset_->GetGeoTransform(transform.data()) == CE_None || dataset_->GetGCPCount() > 0;
}

bool Photo::states_crs() const {
  return dataset_->GetSpatialRef() != nullptr || dataset_->GetGCPSpatialRef() != nullptr;
}

Expected<void> Photo::stage(const std::string& folder, std::uint64_t cache_bytes) {
  if (!stored_by_rows(*dataset_) || decoded_bytes(*dataset_) <= cache_bytes) return {};
  const std::string copy = fmt::format("{}/.tintree-{}-{}.tif", folder, ::getpid(), fmt::ptr(dataset_.get()));
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const char* const options[] = {"TILED=YES", "BIGTIFF=IF_SAFER", nullptr};
  CPLErrorReset();
  DatasetPtr made(
      driver->CreateCopy(copy.c_str(), dataset_.get(), FALSE, const_cast<char**>(options), nullptr, nullptr));
  if (made) made->FlushCache(false);
  const bool whole = made != nullptr && CPLGetLastErrorType() < CE_Failure;
  const std::string reason = last_gdal_message();
  made.reset();
  DatasetPtr opened(whole ? GDALDataset::Open(copy.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY) : nullptr);
  // Open, it needs no name, and leaves nothing behind however the program ends.
  ::unlink(copy.c_str());
  ::unlink((copy + ".aux.xml").c_str());
  if (!opened) return fail(ErrorCode::kIo, "a temporary copy of " + path_ + " cannot be made: " + reason, folder);
  dataset_ = std::move(opened);
  indices_.reset();
  return {};
}

}  // namespace tintree::cache
