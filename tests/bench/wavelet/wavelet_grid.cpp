// The grid coder of method `wavelet` alone, without a mesh: a raster as the patches of its layers (Yusov & Turlapov
// 2008, tables 1 to 5). Prints one line of JSON.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "codec/wavelet_patch.h"
#include "simplify/neville_rows.h"
#include "tests/bench/rivals/height_grid.h"

namespace tintree {
namespace {

constexpr const char* kUsage =
    "usage: bench_wavelet HEIGHTS.f64 COLUMNS ROWS PATCH BOUND_M UNIT_M max|rms|lossless|lifted [direct]\n";

struct Job {
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  std::vector<double> heights_m;  // NaN: no sample
  int patch = 256;
  double unit_m = 1;
  codec::PatchSpec spec;
  bool direct = false;
};

struct Result {
  std::vector<double> heights_m;
  std::uint64_t bytes = 0;
  std::uint64_t leaf_bytes = 0;
  int patches = 0;
  int encodes = 0;
  double decode_seconds = 0;
};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Coder {
 public:
  explicit Coder(const Job& job) : job_(&job) {
    while ((std::int64_t{job.patch} << levels_) < std::max(job.columns, job.rows)) ++levels_;
    result_.heights_m.assign(job.heights_m.size(), std::numeric_limits<double>::quiet_NaN());
  }

  Result run() {
    code(levels_, 0, 0, nullptr, 0);
    return std::move(result_);
  }

 private:
  int side() const { return job_->patch + 2 * codec::kPatchMargin; }

  codec::Patch target(int layer, std::int64_t x, std::int64_t y) const {
    const simplify::SampleRows samples = [&](std::int64_t column, std::int64_t row, std::vector<double>& out) {
      for (std::size_t i = 0; i < out.size(); ++i) {
        const std::int64_t c = column + static_cast<std::int64_t>(i);
        const bool inside = c >= 0 && row >= 0 && c < job_->columns && row < job_->rows;
        out[i] = inside ? job_->heights_m[static_cast<std::size_t>(row * job_->columns + c)]
                        : std::numeric_limits<double>::quiet_NaN();
      }
    };
    simplify::NevilleRows rows(samples, layer, x * job_->patch - codec::kPatchMargin,
                               y * job_->patch - codec::kPatchMargin, side());
    codec::Patch out(side(), codec::kNoHeight);
    for (int j = 0; j < side(); ++j) {
      const std::vector<double>& row = rows.next();
      for (int i = 0; i < side(); ++i) {
        const double h = row[static_cast<std::size_t>(i)];
        if (!std::isnan(h)) out.at(i, j) = std::llround(h / job_->unit_m);
      }
    }
    return out;
  }

  void code(int layer, std::int64_t x, std::int64_t y, const codec::Patch* parent, int quadrant) {
    const std::int64_t across = std::int64_t{job_->patch} << layer;
    if (x * across >= job_->columns || y * across >= job_->rows) return;
    codec::PatchSpec spec = job_->spec;
    // Bounds double with every layer up, as a tree's do.
    spec.bound <<= layer;
    const bool alone = parent == nullptr || job_->direct;
    if (alone) spec.bits = std::max(spec.bits, 12);
    const codec::Patch prediction = alone ? codec::Patch(side(), 0) : codec::predict_patch(*parent, quadrant, 1);
    auto coded = codec::encode_patch(target(layer, x, y), prediction, spec);
    if (!coded) {
      std::fputs((coded.error().text() + "\n").c_str(), stderr);
      std::exit(3);
    }
    const double before = cpu_seconds();
    std::span<const std::byte> bytes = coded->bytes;
    const auto decoded = codec::decode_patch(bytes, prediction);
    result_.decode_seconds += cpu_seconds() - before;
    if (!decoded || decoded->heights != coded->reconstruction.heights) {
      std::fputs("decodes to something else\n", stderr);
      std::exit(1);
    }
    result_.bytes += coded->bytes.size();
    if (layer == 0) result_.leaf_bytes += coded->bytes.size();
    ++result_.patches;
    result_.encodes += coded->encodes;
    if (layer == 0) return keep(*decoded, x, y);
    for (int q = 0; q < 4; ++q) code(layer - 1, 2 * x + (q & 1), 2 * y + (q >> 1), &*decoded, q);
  }

  void keep(const codec::Patch& patch, std::int64_t x, std::int64_t y) {
    for (int j = 0; j < job_->patch; ++j) {
      for (int i = 0; i < job_->patch; ++i) {
        const std::int64_t column = x * job_->patch + i;
        const std::int64_t row = y * job_->patch + j;
        if (column >= job_->columns || row >= job_->rows) continue;
        const auto at = static_cast<std::size_t>(row * job_->columns + column);
        result_.heights_m[at] =
            static_cast<double>(patch.at(i + codec::kPatchMargin, j + codec::kPatchMargin)) * job_->unit_m;
      }
    }
  }

  const Job* job_;
  int levels_ = 0;
  Result result_;
};

int run(std::span<char*> arguments) {
  if (arguments.size() < 8) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  Job job;
  auto grid = bench::read_grid(arguments[1],
                               {.columns = std::stoi(arguments[2]), .rows = std::stoi(arguments[3]), .heights_m = {}});
  if (!grid) {
    std::fputs((grid.error().text() + "\n").c_str(), stderr);
    return static_cast<int>(grid.error().code);
  }
  job.columns = grid->columns;
  job.rows = grid->rows;
  job.heights_m = std::move(grid->heights_m);
  job.patch = std::stoi(arguments[4]);
  const double bound_m = std::stod(arguments[5]);
  job.unit_m = std::stod(arguments[6]);
  const std::string mode = arguments[7];
  job.direct = arguments.size() > 8 && std::string(arguments[8]) == "direct";
  job.spec.bound = static_cast<std::int64_t>(std::floor(bound_m / job.unit_m + 1e-9));
  job.spec.criterion = mode == "rms" ? codec::PatchCriterion::kRms : codec::PatchCriterion::kMax;
  job.spec.lifted = mode == "lifted";
  job.spec.lossless = mode == "lossless";
  const double before = cpu_seconds();
  const Result result = Coder(job).run();
  const double seconds = cpu_seconds() - before - result.decode_seconds;
  double max_m = 0;
  double squares = 0;
  std::size_t count = 0;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t i = 0; i < job.heights_m.size(); ++i) {
    const double h = job.heights_m[i];
    if (std::isnan(h)) continue;
    const double off = std::abs(h - result.heights_m[i]);
    max_m = std::max(max_m, off);
    squares += off * off;
    low = std::min(low, h);
    high = std::max(high, h);
    ++count;
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
  const nlohmann::json report = {{"bytes", result.bytes},
                                 {"leaf_bytes", result.leaf_bytes},
                                 {"samples_max_m", max_m},
                                 {"rms_m", rms_m},
                                 {"psnr_db", rms_m > 0 ? 20 * std::log10((high - low) / rms_m) : 0},
                                 {"patches", result.patches},
                                 {"encodes", result.encodes},
                                 {"seconds", seconds},
                                 {"decode_seconds", result.decode_seconds}};
  std::puts(report.dump().c_str());
  return 0;
}

}  // namespace
}  // namespace tintree

int main(int argc, char** argv) { return tintree::run({argv, static_cast<std::size_t>(argc)}); }
