#include "simplify/error_meter.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tintree::simplify {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSnap = 1e-9;

/// The part [t0, t1] of the segment a -> b where low <= coordinate <= high; t0 > t1 when there is none.
void clip_axis(double a, double b, double low, double high, double& t0, double& t1) {
  if (a == b) {
    if (a < low || a > high) t1 = -1;
    return;
  }
  const double ta = (low - a) / (b - a);
  const double tb = (high - a) / (b - a);
  t0 = std::max(t0, std::min(ta, tb));
  t1 = std::min(t1, std::max(ta, tb));
}

}  // namespace

MeasuredError& MeasuredError::operator+=(const MeasuredError& other) {
  max_m = std::max(max_m, other.max_m);
  border_max_m = std::max(border_max_m, other.border_max_m);
  sum_of_squares += other.sum_of_squares;
  samples += other.samples;
  return *this;
}

double MeasuredError::rms_m() const {
  return samples == 0 ? 0 : std::sqrt(sum_of_squares / static_cast<double>(samples));
}

MeasuredMesh::MeasuredMesh(const codec::TreeLayout& layout, const codec::TileId& id, const codec::TileMesh& mesh)
    : cells(layout.cells(id)), triangles(mesh.triangles) {
  const codec::GridFrame frame(layout, id, mesh);
  const auto west = static_cast<double>(frame.column0);
  const auto north = static_cast<double>(frame.row0);
  const auto across = static_cast<double>(layout.cells_across(id.level));
  vertices.reserve(mesh.vertices.size());
  for (const codec::GridVertex& v : mesh.vertices) {
    const double column = frame.column(v.x);
    const double row = frame.row(v.y);
    const int sides = (column == west ? 1 : 0) + (row == north ? 2 : 0) + (column == west + across ? 4 : 0) +
                      (row == north + across ? 8 : 0);
    vertices.push_back({column, row, frame.height_m(v.z), static_cast<std::uint8_t>(sides)});
  }
}

void ErrorMeter::set_window(const codec::CellRect& window) {
  window_ = window;
  width_ = window.column1 - window.column0 + 1;
  height_ = window.row1 - window.row0 + 1;
  view_->read_exact(window, surface_);
}

MeasuredError ErrorMeter::measure(const MeasuredMesh& mesh, std::span<const std::uint32_t> which) {
  MeasuredError out;
  painted_.assign(surface_.size(), kNaN);
  for (const std::uint32_t k : which) {
    const codec::Triangle& t = mesh.triangles[k];
    paint(mesh, t);
    for (std::size_t e = 0; e < 3; ++e) {
      const MeasuredMesh::Vertex& a = mesh.vertices[t[e]];
      const MeasuredMesh::Vertex& b = mesh.vertices[t[(e + 1) % 3]];
      const bool border = (a.sides & b.sides) != 0;
      check_vertex(a, out);
      cross_edge(a, b, border, out);
    }
  }
  compare(mesh, out);
  return out;
}

/// Writes the triangle's height at every sample of the window that it covers.
void ErrorMeter::paint(const MeasuredMesh& mesh, const codec::Triangle& t) {
  const MeasuredMesh::Vertex& p = mesh.vertices[t[0]];
  const MeasuredMesh::Vertex& q = mesh.vertices[t[1]];
  const MeasuredMesh::Vertex& r = mesh.vertices[t[2]];
  const auto column0 = static_cast<double>(window_.column0);
  const auto row0 = static_cast<double>(window_.row0);
  const double det = (q.column - p.column) * (r.row - p.row) - (r.column - p.column) * (q.row - p.row);
  const double a = ((q.height_m - p.height_m) * (r.row - p.row) - (r.height_m - p.height_m) * (q.row - p.row)) / det;
  const double b =
      ((q.column - p.column) * (r.height_m - p.height_m) - (r.column - p.column) * (q.height_m - p.height_m)) / det;
  const double top = std::min({p.row, q.row, r.row});
  const double bottom = std::max({p.row, q.row, r.row});
  const auto j0 = static_cast<std::int64_t>(std::ceil(std::max(top - row0, 0.0)));
  const auto j1 = static_cast<std::int64_t>(std::floor(std::min(bottom - row0, static_cast<double>(height_ - 1))));
  for (std::int64_t j = j0; j <= j1; ++j) {
    const double y = row0 + static_cast<double>(j);
    double left = std::numeric_limits<double>::infinity();
    double right = -left;
    const MeasuredMesh::Vertex* corners[4] = {&p, &q, &r, &p};
    for (int e = 0; e < 3; ++e) {
      const MeasuredMesh::Vertex& from = *corners[e];
      const MeasuredMesh::Vertex& to = *corners[e + 1];
      if ((from.row < y && to.row < y) || (from.row > y && to.row > y)) continue;
      const double x0 = from.row == to.row
                            ? from.column
                            : from.column + (y - from.row) * (to.column - from.column) / (to.row - from.row);
      const double x1 = from.row == to.row ? to.column : x0;
      left = std::min({left, x0, x1});
      right = std::max({right, x0, x1});
    }
    const auto i0 = static_cast<std::int64_t>(std::ceil(std::max(left - column0 - kSnap, 0.0)));
    const auto i1 =
        static_cast<std::int64_t>(std::floor(std::min(right - column0 + kSnap, static_cast<double>(width_ - 1))));
    double* line = painted_.data() + j * width_;
    const double start = p.height_m + a * (column0 - p.column) + b * (y - p.row);
    for (std::int64_t i = i0; i <= i1; ++i) line[i] = start + a * static_cast<double>(i);
  }
}

void ErrorMeter::compare(const MeasuredMesh& mesh, MeasuredError& out) const {
  // The window owns its north and west samples, and the others where the tile ends.
  const std::int64_t own_width = window_.column1 == mesh.cells.column1 ? width_ : width_ - 1;
  const std::int64_t own_height = window_.row1 == mesh.cells.row1 ? height_ : height_ - 1;
  double largest = 0;
  for (std::int64_t j = 0; j < height_; ++j) {
    const double* s = surface_.data() + j * width_;
    const double* m = painted_.data() + j * width_;
    for (std::int64_t i = 0; i < width_; ++i) {
      const double gap = std::abs(m[i] - s[i]);
      largest = gap > largest ? gap : largest;
    }
  }
  for (std::int64_t j = 0; j < own_height; ++j) {
    const double* s = surface_.data() + j * width_;
    const double* m = painted_.data() + j * width_;
    double sum = 0;
    std::uint64_t count = 0;
    for (std::int64_t i = 0; i < own_width; ++i) {
      const double gap = m[i] - s[i];
      const bool counts = gap == gap;
      sum += counts ? gap * gap : 0;
      count += counts ? 1 : 0;
    }
    out.sum_of_squares += sum;
    out.samples += count;
  }
  out.max_m = std::max(out.max_m, largest);
}

double ErrorMeter::between(std::int64_t i, std::int64_t j, std::int64_t di, std::int64_t dj, double f) const {
  const auto sample = [this](std::int64_t x, std::int64_t y) {
    return x < 0 || y < 0 || x >= width_ || y >= height_ ? kNaN : surface_[static_cast<std::size_t>(y * width_ + x)];
  };
  // A share of nothing must not touch its sample, which may lie beyond the surface's end.
  if (f < kSnap) return sample(i, j);
  if (f > 1 - kSnap) return sample(i + di, j + dj);
  const double near = sample(i, j);
  return near + f * (sample(i + di, j + dj) - near);
}

void ErrorMeter::cross_edge(const MeasuredMesh::Vertex& a, const MeasuredMesh::Vertex& b, bool border,
                            MeasuredError& out) const {
  const double ax = a.column - static_cast<double>(window_.column0);
  const double ay = a.row - static_cast<double>(window_.row0);
  const double dx = b.column - a.column;
  const double dy = b.row - a.row;
  double t0 = 0;
  double t1 = 1;
  clip_axis(ax, ax + dx, 0, static_cast<double>(width_ - 1), t0, t1);
  clip_axis(ay, ay + dy, 0, static_cast<double>(height_ - 1), t0, t1);
  if (t0 > t1) return;
  double largest = 0;
  const auto note = [&](double t, double surface) {
    const double gap = std::abs(a.height_m + t * (b.height_m - a.height_m) - surface);
    largest = gap > largest ? gap : largest;
  };
  // Walks the whole numbers that a coordinate passes; `surface(t)` is the surface's height there.
  const auto walk = [&](double start, double step, const auto& surface) {
    if (step == 0) return;
    const double v0 = start + t0 * step;
    const double v1 = start + t1 * step;
    const double last = std::floor(std::max(v0, v1) + kSnap);
    for (double k = std::ceil(std::min(v0, v1) - kSnap); k <= last; ++k) {
      const double t = std::clamp((k - start) / step, 0.0, 1.0);
      note(t, surface(k, t));
    }
  };
  const auto cell = [](double v) { return static_cast<std::int64_t>(std::floor(v + kSnap)); };
  walk(ax, dx, [&](double k, double t) {
    const double y = ay + t * dy;
    return between(static_cast<std::int64_t>(k), cell(y), 0, 1, y - static_cast<double>(cell(y)));
  });
  walk(ay, dy, [&](double k, double t) {
    const double x = ax + t * dx;
    return between(cell(x), static_cast<std::int64_t>(k), 1, 0, x - static_cast<double>(cell(x)));
  });
  walk(ax - ay, dx - dy, [&](double k, double t) {
    const double x = ax + t * dx;
    return between(cell(x), cell(x) - static_cast<std::int64_t>(k), 1, 1, x - static_cast<double>(cell(x)));
  });
  out.max_m = std::max(out.max_m, largest);
  if (border) out.border_max_m = std::max(out.border_max_m, largest);
}

double ErrorMeter::surface_at(double x, double y) const {
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const double fx = x - static_cast<double>(i);
  const double fy = y - static_cast<double>(j);
  if (fy == 0) return between(i, j, 1, 0, fx);
  if (fx == 0) return between(i, j, 0, 1, fy);
  if (fx == fy) return between(i, j, 1, 1, fx);
  const double corner = between(i, j, 0, 0, 0);
  const double opposite = between(i + 1, j + 1, 0, 0, 0);
  const double third = fx > fy ? between(i + 1, j, 0, 0, 0) : between(i, j + 1, 0, 0, 0);
  return fx > fy ? corner + fx * (third - corner) + fy * (opposite - third)
                 : corner + fy * (third - corner) + fx * (opposite - third);
}

void ErrorMeter::check_vertex(const MeasuredMesh::Vertex& v, MeasuredError& out) const {
  const double x = v.column - static_cast<double>(window_.column0);
  const double y = v.row - static_cast<double>(window_.row0);
  if (x < 0 || y < 0 || x > static_cast<double>(width_ - 1) || y > static_cast<double>(height_ - 1)) return;
  const double gap = std::abs(v.height_m - surface_at(x, y));
  if (gap > out.max_m) out.max_m = gap;
  if (v.sides != 0 && gap > out.border_max_m) out.border_max_m = gap;
}

}  // namespace tintree::simplify
