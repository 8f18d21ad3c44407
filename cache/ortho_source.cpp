#include "cache/ortho_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <gdal_utils.h>
#include <gdalwarper.h>
#include <unistd.h>

namespace tintree::cache {
namespace {

/// Nodes beyond the DEM's north and west side that a window may reach.
constexpr std::int64_t kMargin = 1 << 12;
/// How far GDAL may take positions by interpolation, pixels of the warped picture.
constexpr double kPositionTolerance = 0.05;

std::string last_gdal_message() {
  const std::string message = CPLGetLastErrorMsg();
  return message.empty() ? "GDAL gives no reason" : message;
}

struct TransformerCloser {
  void operator()(void* t) const { GDALDestroyTransformer(t); }
};
using Transformer = std::unique_ptr<void, TransformerCloser>;

struct WarpOptionsCloser {
  void operator()(GDALWarpOptions* o) const { GDALDestroyWarpOptions(o); }
};

/// The georeference of a grid of nodes: the DEM's, whose pixels' centres are its samples, with pixels of `step` samples
/// that begin kMargin nodes before the DEM.
GeoTransform node_transform(const GeoTransform& dem, double step) {
  const double corner = 0.5 - step * (0.5 + static_cast<double>(kMargin));
  return {dem[0] + corner * (dem[1] + dem[2]), step * dem[1], step * dem[2],
          dem[3] + corner * (dem[4] + dem[5]), step * dem[4], step * dem[5]};
}

/// One photo.
struct Photo {
  std::string path;
  GDALDatasetUniquePtr dataset;
  std::array<int, 3> bands{1, 1, 1};
  int alpha_band = 0;  // 0: none

  Expected<void> open(const std::string& file);
  Expected<void> describe_bands();
  Expected<void> expand_palette();
  Expected<void> stage(const std::string& folder);
  Expected<Transformer> transformer(const RasterInfo& dem, const GeoTransform& nodes) const;
  Expected<GDALDatasetUniquePtr> warped(const RasterInfo& dem, double step) const;
  bool has_place() const;
  bool stored_by_rows() const;
  std::uint64_t decoded_bytes() const;
};

Expected<void> Photo::open(const std::string& file) {
  path = file;
  CPLErrorReset();
  dataset.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset) {
    const bool missing = ::access(path.c_str(), F_OK) != 0 && path.find(':') == std::string::npos;
    if (missing) return fail(ErrorCode::kIo, "no such file", path);
    return fail(ErrorCode::kBadData, "is no picture that GDAL can read (" + last_gdal_message() + ")", path);
  }
  if (dataset->GetRasterCount() < 1) return fail(ErrorCode::kBadData, "holds no raster band", path);
  if (dataset->GetRasterBand(1)->GetColorTable() != nullptr) {
    if (auto expanded = expand_palette(); !expanded) return expanded;
  }
  return describe_bands();
}

Expected<void> Photo::expand_palette() {
  std::array<std::string, 4> words{"-of", "VRT", "-expand", "rgba"};
  std::array<char*, 5> arguments{words[0].data(), words[1].data(), words[2].data(), words[3].data(), nullptr};
  GDALTranslateOptions* options = GDALTranslateOptionsNew(arguments.data(), nullptr);
  GDALDatasetH out = GDALTranslate("", GDALDataset::ToHandle(dataset.get()), options, nullptr);
  GDALTranslateOptionsFree(options);
  if (out == nullptr)
    return fail(ErrorCode::kBadData, "its colour table cannot be used (" + last_gdal_message() + ")", path);
  // The new dataset keeps the old one alive by its own reference.
  dataset.reset(GDALDataset::FromHandle(out));
  return {};
}

Expected<void> Photo::describe_bands() {
  const int count = dataset->GetRasterCount();
  for (int b = 1; b <= count; ++b) {
    if (dataset->GetRasterBand(b)->GetColorInterpretation() == GCI_AlphaBand) alpha_band = b;
  }
  const int colors = count - (alpha_band > 0 ? 1 : 0);
  if (colors >= 3) {
    bands = {1, 2, 3};
    constexpr std::array<GDALColorInterp, 3> kNamed{GCI_RedBand, GCI_GreenBand, GCI_BlueBand};
    std::array<int, 3> named{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (int b = 1; b <= count; ++b) {
        if (dataset->GetRasterBand(b)->GetColorInterpretation() == kNamed[k]) named[k] = b;
      }
    }
    if (std::ranges::all_of(named, [](int b) { return b > 0; })) bands = named;
  }
  for (const int b : bands) {
    const GDALDataType type = dataset->GetRasterBand(b)->GetRasterDataType();
    if (type != GDT_Byte) {
      return fail(
          ErrorCode::kBadData,
          fmt::format("holds {} samples, not colours of 8 bits; convert it first (gdal_translate -ot Byte -scale)",
                      GDALGetDataTypeName(type)),
          path);
    }
  }
  return {};
}

bool Photo::has_place() const {
  GeoTransform t{};
  return dataset->GetGeoTransform(t.data()) == CE_None || dataset->GetGCPCount() > 0;
}

bool Photo::stored_by_rows() const {
  int across = 0;
  int down = 0;
  dataset->GetRasterBand(1)->GetBlockSize(&across, &down);
  return across >= dataset->GetRasterXSize();
}

std::uint64_t Photo::decoded_bytes() const {
  return static_cast<std::uint64_t>(dataset->GetRasterXSize()) * static_cast<std::uint64_t>(dataset->GetRasterYSize()) *
         static_cast<std::uint64_t>(dataset->GetRasterCount());
}

Expected<void> Photo::stage(const std::string& folder) {
  const std::string copy = fmt::format("{}/.tintree-{}-{}.tif", folder, ::getpid(), fmt::ptr(dataset.get()));
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const char* const options[] = {"TILED=YES", "BIGTIFF=IF_SAFER", nullptr};
  CPLErrorReset();
  GDALDatasetUniquePtr made(
      driver->CreateCopy(copy.c_str(), dataset.get(), FALSE, const_cast<char**>(options), nullptr, nullptr));
  if (made) made->FlushCache(false);
  const bool whole = made != nullptr && CPLGetLastErrorType() < CE_Failure;
  const std::string reason = last_gdal_message();
  made.reset();
  GDALDatasetUniquePtr opened(whole ? GDALDataset::Open(copy.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY) : nullptr);
  // Open, it needs no name, and leaves nothing behind however the program ends.
  ::unlink(copy.c_str());
  ::unlink((copy + ".aux.xml").c_str());
  if (!opened) return fail(ErrorCode::kIo, "a temporary copy of " + path + " cannot be made: " + reason, folder);
  dataset = std::move(opened);
  return {};
}

Expected<Transformer> Photo::transformer(const RasterInfo& dem, const GeoTransform& nodes) const {
  char** options = nullptr;
  // Where either states no CRS, both are taken to have one.
  const OGRSpatialReference* own = dataset->GetSpatialRef();
  if (own == nullptr) own = dataset->GetGCPSpatialRef();
  if (!dem.crs_wkt.empty() && own != nullptr) options = CSLSetNameValue(options, "DST_SRS", dem.crs_wkt.c_str());
  CPLErrorReset();
  Transformer out(GDALCreateGenImgProjTransformer2(GDALDataset::ToHandle(dataset.get()), nullptr, options));
  CSLDestroy(options);
  if (!out) {
    return fail(
        ErrorCode::kBadData,
        "cannot be brought to the coordinates of the DEM (" + last_gdal_message() + "); reproject it first (gdalwarp)",
        path);
  }
  GDALSetGenImgProjTransformerDstGeoTransform(out.get(), nodes.data());
  return out;
}

Expected<GDALDatasetUniquePtr> Photo::warped(const RasterInfo& dem, double step) const {
  const GeoTransform nodes = node_transform(dem.geotransform, step);
  auto exact = transformer(dem, nodes);
  if (!exact) return tl::unexpected(exact.error());
  std::unique_ptr<GDALWarpOptions, WarpOptionsCloser> options(GDALCreateWarpOptions());
  options->hSrcDS = GDALDataset::ToHandle(dataset.get());
  options->eResampleAlg = GRA_Cubic;
  options->eWorkingDataType = GDT_Byte;
  options->nBandCount = 3;
  options->panSrcBands = static_cast<int*>(CPLMalloc(3 * sizeof(int)));
  options->panDstBands = static_cast<int*>(CPLMalloc(3 * sizeof(int)));
  bool has_nodata = true;
  std::array<double, 3> nodata{};
  for (std::size_t k = 0; k < 3; ++k) {
    options->panSrcBands[k] = bands[k];
    options->panDstBands[k] = static_cast<int>(k) + 1;
    int stated = 0;
    nodata[k] = dataset->GetRasterBand(bands[k])->GetNoDataValue(&stated);
    has_nodata = has_nodata && stated != 0;
  }
  options->nSrcAlphaBand = alpha_band;
  options->nDstAlphaBand = 4;
  options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "INIT_DEST", "0");
  if (has_nodata && alpha_band == 0) {
    options->padfSrcNoDataReal = static_cast<double*>(CPLMalloc(sizeof nodata));
    std::ranges::copy(nodata, options->padfSrcNoDataReal);
    options->papszWarpOptions = CSLSetNameValue(options->papszWarpOptions, "UNIFIED_SRC_NODATA", "YES");
  }
  options->pTransformerArg = GDALCreateApproxTransformer(GDALGenImgProjTransform, exact->release(), kPositionTolerance);
  GDALApproxTransformerOwnsSubtransformer(options->pTransformerArg, TRUE);
  options->pfnTransformer = GDALApproxTransform;
  const auto side = [step](std::int64_t samples) {
    // As far again beyond the DEM as the largest tile can reach.
    const double nodes_across = 2 * static_cast<double>(samples) / step + 4.0 * static_cast<double>(kMargin);
    return static_cast<int>(std::min<double>(nodes_across, std::numeric_limits<int>::max()));
  };
  GeoTransform place = nodes;
  GDALDatasetUniquePtr out(GDALDataset::FromHandle(
      GDALCreateWarpedVRT(options->hSrcDS, side(dem.columns), side(dem.rows), place.data(), options.get())));
  if (!out) return fail(ErrorCode::kBadData, "cannot be warped onto the DEM (" + last_gdal_message() + ")", path);
  return out;
}

/// What is known of a photo's place over the DEM.
struct Meeting {
  bool meets = false;
  double pixel_samples = 0;
  /// The columns and rows of the DEM's grid that it lies between.
  std::array<double, 2> low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  std::array<double, 2> high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

  void add(double column, double row) {
    low = {std::min(low[0], column), std::min(low[1], row)};
    high = {std::max(high[0], column), std::max(high[1], row)};
  }
  /// Takes it to lie anywhere.
  void add_everything() {
    add(-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
    add(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
  }
};

Expected<Meeting> meet(const Photo& photo, const RasterInfo& dem) {
  auto to_photo = photo.transformer(dem, node_transform(dem.geotransform, 1));
  if (!to_photo) return tl::unexpected(to_photo.error());
  const double width = photo.dataset->GetRasterXSize();
  const double height = photo.dataset->GetRasterYSize();
  constexpr int kProbes = 17;
  constexpr double kCentre = 0.5 + kMargin;
  const auto move = [&](bool to_dem, double x, double y) -> std::optional<std::array<double, 2>> {
    double z = 0;
    int done = 0;
    const int inverse = to_dem ? FALSE : TRUE;
    if (GDALGenImgProjTransform(to_photo->get(), inverse, 1, &x, &y, &z, &done) == 0 || done == 0) return std::nullopt;
    return std::array{x, y};
  };
  Meeting out;
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

}  // namespace

struct OrthoSource::Impl {
  RasterInfo dem;
  std::vector<InputFile> inputs;
  std::vector<std::string> warnings;
  std::vector<Photo> photos;
  std::vector<Meeting> places;  // of the photos
  double pixel_samples = std::numeric_limits<double>::infinity();
  std::mutex turn;                                             // guards what follows and GDAL
  std::map<double, std::vector<GDALDatasetUniquePtr>> warped;  // by step

  Expected<void> add(const std::string& path);
  Expected<std::vector<GDALDatasetUniquePtr>*> at_step(double step);
};

Expected<void> OrthoSource::Impl::add(const std::string& path) {
  inputs.push_back(describe_input(path));
  Photo photo;
  if (auto opened = photo.open(path); !opened) return opened;
  if (!photo.has_place()) {
    return fail(ErrorCode::kBadData,
                "has no georeference, so its place on the DEM is unknown; state it (gdal_edit.py -a_srs CRS -a_ullr "
                "WEST NORTH EAST SOUTH)",
                path);
  }
  const bool no_crs = photo.dataset->GetSpatialRef() == nullptr && photo.dataset->GetGCPSpatialRef() == nullptr;
  if (no_crs != dem.crs_wkt.empty()) {
    warnings.push_back(path + ": " + (no_crs ? "states" : "the DEM states") +
                       " no coordinate reference system: both are taken to have the same");
  }
  const auto meeting = meet(photo, dem);
  if (!meeting) return tl::unexpected(meeting.error());
  if (!meeting->meets) {
    return fail(ErrorCode::kBadData,
                "does not meet the DEM anywhere; check the coordinate reference systems of both (gdalinfo)", path);
  }
  if (meeting->pixel_samples > 0) pixel_samples = std::min(pixel_samples, meeting->pixel_samples);
  photos.push_back(std::move(photo));
  places.push_back(*meeting);
  return {};
}

Expected<std::vector<GDALDatasetUniquePtr>*> OrthoSource::Impl::at_step(double step) {
  std::vector<GDALDatasetUniquePtr>& out = warped[step];
  while (out.size() < photos.size()) {
    auto next = photos[out.size()].warped(dem, step);
    if (!next) return tl::unexpected(next.error());
    out.push_back(std::move(*next));
  }
  return &out;
}

OrthoSource::OrthoSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OrthoSource::OrthoSource(OrthoSource&&) noexcept = default;
OrthoSource& OrthoSource::operator=(OrthoSource&&) noexcept = default;
OrthoSource::~OrthoSource() = default;

const std::vector<InputFile>& OrthoSource::inputs() const { return impl_->inputs; }
const std::vector<std::string>& OrthoSource::warnings() const { return impl_->warnings; }
double OrthoSource::pixel_samples() const { return impl_->pixel_samples; }

double OrthoSource::pixel_samples_in(const codec::CellRect& cells) const {
  double finest = std::numeric_limits<double>::infinity();
  for (const Meeting& place : impl_->places) {
    const bool reaches =
        place.low[0] < static_cast<double>(cells.column1) && place.low[1] < static_cast<double>(cells.row1) &&
        place.high[0] > static_cast<double>(cells.column0) && place.high[1] > static_cast<double>(cells.row0);
    if (reaches && place.pixel_samples > 0) finest = std::min(finest, place.pixel_samples);
  }
  return finest;
}

Expected<OrthoSource> OrthoSource::open(const std::vector<std::string>& paths, const RasterInfo& dem) {
  register_drivers();
  auto impl = std::make_unique<Impl>();
  impl->dem = dem;
  for (const std::string& path : paths) {
    if (auto added = impl->add(path); !added) return tl::unexpected(added.error());
  }
  return OrthoSource(std::move(impl));
}

Expected<void> OrthoSource::check_unchanged() const {
  for (const InputFile& before : impl_->inputs) {
    const InputFile now = describe_input(before.path);
    if (before.modified_s == 0 || now.modified_s == 0 || now == before) continue;
    return fail(ErrorCode::kIo, "the file was changed while it was being read; restore it", before.path);
  }
  return {};
}

Expected<void> OrthoSource::stage(
    const std::string& folder, std::uint64_t cache_bytes,
    const std::function<bool(const std::string&, std::uint64_t, std::uint64_t)>& progress) {
  for (std::size_t i = 0; i < impl_->photos.size(); ++i) {
    if (!progress("copying photos", i, impl_->photos.size())) return fail(ErrorCode::kStopped, "stopped");
    Photo& photo = impl_->photos[i];
    if (!photo.stored_by_rows() || photo.decoded_bytes() <= cache_bytes) continue;
    if (auto staged = photo.stage(folder); !staged) return staged;
  }
  return {};
}

Expected<ColorWindow> OrthoSource::read(double step, std::int64_t column0, std::int64_t row0, int width,
                                        int height) const {
  const std::size_t nodes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  ColorWindow out{column0, row0, width, height, std::vector<std::uint8_t>(4 * nodes)};
  std::vector<std::uint8_t> one(4 * nodes);
  const std::scoped_lock lock(impl_->turn);
  const auto warped = impl_->at_step(step);
  if (!warped) return tl::unexpected(warped.error());
  for (std::size_t i = 0; i < (*warped)->size(); ++i) {
    GDALDataset& picture = *(**warped)[i];
    CPLErrorReset();
    const CPLErr rc =
        picture.RasterIO(GF_Read, static_cast<int>(column0 + kMargin), static_cast<int>(row0 + kMargin), width, height,
                         one.data(), width, height, GDT_Byte, 4, nullptr, 4, GSpacing{4} * width, 1, nullptr);
    if (rc != CE_None) {
      return fail(ErrorCode::kIo, "cannot be read (" + last_gdal_message() + ")", impl_->photos[i].path);
    }
    for (std::size_t n = 0; n < 4 * nodes; n += 4) {
      if (one[n + 3] < 128) continue;
      std::copy_n(one.begin() + static_cast<std::ptrdiff_t>(n), 3, out.rgba.begin() + static_cast<std::ptrdiff_t>(n));
      out.rgba[n + 3] = 255;
    }
  }
  return out;
}

}  // namespace tintree::cache
