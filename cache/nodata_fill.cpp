#include "cache/nodata_fill.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

#include <gdal_alg.h>
#include <gdal_priv.h>

#include "cache/gdal_message.h"
#include "cache/raster_source.h"

namespace tintree::cache {
namespace {

using StepProgress = std::function<bool(const std::string&, std::uint64_t, std::uint64_t)>;

/// A directory of its own for GDAL's work files, removed with everything in it.
class WorkFolder {
 public:
  static Expected<WorkFolder> create(const std::string& parent) {
    std::string name = parent + "/tintree-fill-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) {
      return fail(ErrorCode::kIo, std::string("a temporary folder cannot be made here: ") + std::strerror(errno),
                  parent);
    }
    return WorkFolder(name);
  }
  WorkFolder(WorkFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  WorkFolder& operator=(WorkFolder&&) = delete;
  ~WorkFolder() {
    std::error_code ec;
    if (!path_.empty()) std::filesystem::remove_all(path_, ec);
  }
  const std::string& path() const { return path_; }

 private:
  explicit WorkFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

/// Sends GDAL's own temporary files to a folder while it lives.
class TemporaryFilesIn {
 public:
  explicit TemporaryFilesIn(const std::string& folder) { CPLSetThreadLocalConfigOption("CPL_TMPDIR", folder.c_str()); }
  TemporaryFilesIn(const TemporaryFilesIn&) = delete;
  TemporaryFilesIn& operator=(const TemporaryFilesIn&) = delete;
  ~TemporaryFilesIn() { CPLSetThreadLocalConfigOption("CPL_TMPDIR", nullptr); }
};

/// Rows handled at once, of all columns.
std::int64_t rows_at_once(std::int64_t columns) {
  return std::clamp<std::int64_t>((std::int64_t{1} << 19) / columns, 1, 256);
}

Error stopped() { return {ErrorCode::kStopped, "stopped while filling holes", {}}; }

Error gdal_failure(const std::string& folder) {
  return {ErrorCode::kIo, "holes cannot be filled (" + last_gdal_message() + ")", folder};
}

/// Reports rows done of a copy; fails when the build is to stop. A sudden end would leave the work folder behind.
Expected<void> report_rows(const StepProgress& progress, const char* step, std::int64_t done, std::int64_t rows) {
  if (!progress || progress(step, static_cast<std::uint64_t>(done), static_cast<std::uint64_t>(rows))) return {};
  return tl::unexpected(stopped());
}

Expected<GDALDatasetUniquePtr> copy_out(const ScratchRaster& heights, std::int64_t columns, std::int64_t rows,
                                        const std::string& folder, const StepProgress& progress) {
  const char* const options[] = {"BIGTIFF=IF_SAFER", nullptr};
  const std::string path = folder + "/heights.tif";
  GDALDatasetUniquePtr out(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), static_cast<int>(columns), static_cast<int>(rows), 1, GDT_Float32, const_cast<char**>(options)));
  if (!out) return tl::unexpected(gdal_failure(folder));
  GDALRasterBand* band = out->GetRasterBand(1);
  band->SetNoDataValue(std::numeric_limits<double>::quiet_NaN());
  const std::int64_t step = rows_at_once(columns);
  std::vector<double> lines(static_cast<std::size_t>(columns * step));
  for (std::int64_t row = 0; row < rows; row += step) {
    const std::int64_t height = std::min(step, rows - row);
    if (auto read = heights.read(0, row, columns, height, lines.data(), columns); !read) {
      return tl::unexpected(read.error());
    }
    if (band->RasterIO(GF_Write, 0, static_cast<int>(row), static_cast<int>(columns), static_cast<int>(height),
                       lines.data(), static_cast<int>(columns), static_cast<int>(height), GDT_Float64, 0, 0,
                       nullptr) != CE_None) {
      return tl::unexpected(gdal_failure(folder));
    }
    if (auto go_on = report_rows(progress, "copying rows to fill", row + height, rows); !go_on) {
      return tl::unexpected(go_on.error());
    }
  }
  return out;
}

/// Takes the filled samples over, and only where there were none.
Expected<void> copy_in(GDALRasterBand& filled, ScratchRaster& heights, std::int64_t columns, std::int64_t rows,
                       const std::string& folder, const StepProgress& progress) {
  const std::int64_t step = rows_at_once(columns);
  std::vector<double> lines(static_cast<std::size_t>(columns * step));
  std::vector<double> fills(lines.size());
  for (std::int64_t row = 0; row < rows; row += step) {
    const std::int64_t height = std::min(step, rows - row);
    if (auto read = heights.read(0, row, columns, height, lines.data(), columns); !read) return read;
    if (filled.RasterIO(GF_Read, 0, static_cast<int>(row), static_cast<int>(columns), static_cast<int>(height),
                        fills.data(), static_cast<int>(columns), static_cast<int>(height), GDT_Float64, 0, 0,
                        nullptr) != CE_None) {
      return tl::unexpected(gdal_failure(folder));
    }
    std::ranges::transform(lines, fills, lines.begin(), [](double h, double f) { return std::isnan(h) ? f : h; });
    if (auto written = heights.write(0, row, columns, height, lines.data(), columns); !written) return written;
    if (auto go_on = report_rows(progress, "copying filled rows", row + height, rows); !go_on) return go_on;
  }
  return {};
}

struct FillProgress {
  const StepProgress* report;
  bool stopped = false;
};

int on_progress(double share, const char* /*message*/, void* state) {
  auto& progress = *static_cast<FillProgress*>(state);
  constexpr double kSteps = 1000;
  if (*progress.report)
    progress.stopped = !(*progress.report)("filling holes", static_cast<std::uint64_t>(share * kSteps), 1000);
  return progress.stopped ? 0 : 1;
}

}  // namespace

Expected<void> fill_nodata(ScratchRaster& heights, std::int64_t columns, std::int64_t rows, const std::string& folder,
                           const StepProgress& progress) {
  if (columns > std::numeric_limits<int>::max() || rows > std::numeric_limits<int>::max()) {
    return fail(ErrorCode::kBadData, "the raster is too large for --nodata fill");
  }
  const auto work = WorkFolder::create(folder);
  if (!work) return tl::unexpected(work.error());
  const TemporaryFilesIn in_work_folder(work->path());
  CPLErrorReset();
  auto filled = copy_out(heights, columns, rows, work->path(), progress);
  if (!filled) return tl::unexpected(filled.error());
  GDALRasterBand* band = (*filled)->GetRasterBand(1);
  FillProgress state{&progress};
  const CPLErr done = GDALFillNodata(band, nullptr, kFillDistance, 0, 0, nullptr, on_progress, &state);
  if (state.stopped) return tl::unexpected(stopped());
  if (done != CE_None || band->FlushCache(false) != CE_None) return tl::unexpected(gdal_failure(folder));
  return copy_in(*band, heights, columns, rows, folder, progress);
}

}  // namespace tintree::cache
