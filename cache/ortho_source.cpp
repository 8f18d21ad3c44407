#include "cache/ortho_source.h"

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "cache/photo.h"
#include "cache/photo_place.h"
#include "cache/warped_photo.h"

namespace tintree::cache {

struct OrthoSource::Impl {
  RasterInfo dem;
  std::vector<InputFile> inputs;
  std::vector<std::string> warnings;
  std::vector<Photo> photos;
  std::vector<PhotoPlace> places;  // of the photos
  double pixel_samples = std::numeric_limits<double>::infinity();
  std::mutex turn;                                    // guards what follows and GDAL
  std::map<double, std::vector<WarpedPhoto>> warped;  // by step

  Expected<void> add(const std::string& path);
  Expected<std::vector<WarpedPhoto>*> at_step(double step);
};

Expected<void> OrthoSource::Impl::add(const std::string& path) {
  inputs.push_back(describe_input(path));
  auto photo = Photo::open(path);
  if (!photo) return tl::unexpected(photo.error());
  if (!photo->has_place()) {
    return fail(ErrorCode::kBadData,
                "has no georeference, so its place on the DEM is unknown; state it (gdal_edit.py -a_srs CRS -a_ullr "
                "WEST NORTH EAST SOUTH)",
                path);
  }
  const bool no_crs = !photo->states_crs();
  if (no_crs != dem.crs_wkt.empty()) {
    warnings.push_back(path + ": " + (no_crs ? "states" : "the DEM states") +
                       " no coordinate reference system: both are taken to have the same");
  }
  const auto place = place_photo(*photo, dem);
  if (!place) return tl::unexpected(place.error());
  if (!place->meets) {
    return fail(ErrorCode::kBadData,
                "does not meet the DEM anywhere; check the coordinate reference systems of both (gdalinfo)", path);
  }
  if (place->pixel_samples > 0) pixel_samples = std::min(pixel_samples, place->pixel_samples);
  photos.push_back(std::move(*photo));
  places.push_back(*place);
  return {};
}

Expected<std::vector<WarpedPhoto>*> OrthoSource::Impl::at_step(double step) {
  std::vector<WarpedPhoto>& out = warped[step];
  while (out.size() < photos.size()) {
    auto next = WarpedPhoto::make(photos[out.size()], dem, step);
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
  for (const PhotoPlace& place : impl_->places) {
    if (place.reaches(cells) && place.pixel_samples > 0) finest = std::min(finest, place.pixel_samples);
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
  impl_->warped.clear();  // They read what is replaced here.
  for (std::size_t i = 0; i < impl_->photos.size(); ++i) {
    if (!progress("copying photos", i, impl_->photos.size())) return fail(ErrorCode::kStopped, "stopped");
    if (auto staged = impl_->photos[i].stage(folder, cache_bytes); !staged) return staged;
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
  for (const WarpedPhoto& photo : **warped) {
    if (auto read = photo.read(column0, row0, width, height, one); !read) return tl::unexpected(read.error());
    for (std::size_t n = 0; n < 4 * nodes; n += 4) {
      if (one[n + 3] < 128) continue;
      std::copy_n(one.begin() + static_cast<std::ptrdiff_t>(n), 3, out.rgba.begin() + static_cast<std::ptrdiff_t>(n));
      out.rgba[n + 3] = 255;
    }
  }
  return out;
}

}  // namespace tintree::cache
