#pragma once

namespace tintree::simplify {

/// Sum of weighted squared *vertical* distances to planes z = a x + b y + c, as a quadratic form in
/// (x, y, z) (Garland and Heckbert 1997, with normals scaled to n_z = 1). x and y in samples, z in metres;
/// values in metres squared times cells. Kept in double, so that no form needs an origin of its own.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  double x = 0, y = 0, z = 0, one = 0;

  static Quadric of_plane(double a, double b, double c, double weight) {
    return {weight * a * a, weight * a * b, -weight * a,    weight * b * b, -weight * b,
            weight,         weight * a * c, weight * b * c, -weight * c,    weight * c * c};
  }

  Quadric& operator+=(const Quadric& o) {
    xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
    x += o.x, y += o.y, z += o.z, one += o.one;
    return *this;
  }

  /// The height that is best over (px, py).
  double best_height(double px, double py) const { return -(xz * px + yz * py + z) / zz; }

  /// The form with the best height eliminated: q(px, py) = min over pz.
  struct Plan {
    double xx, xy, yy, x, y, one;

    double at(double px, double py) const { return px * (xx * px + 2 * (xy * py + x)) + py * (yy * py + 2 * y) + one; }
    /// Minimises at() plus ridge * squared distance from (mx, my).
    void minimise(double mx, double my, double ridge, double& px, double& py) const {
      const double gx = -(x + xx * mx + xy * my);
      const double gy = -(y + xy * mx + yy * my);
      const double a = xx + ridge;
      const double c = yy + ridge;
      const double det = a * c - xy * xy;
      px = det > 0 ? mx + (c * gx - xy * gy) / det : mx;
      py = det > 0 ? my + (a * gy - xy * gx) / det : my;
    }
  };

  Plan plan() const {
    const double k = 1 / zz;
    return {xx - xz * xz * k, xy - xz * yz * k, yy - yz * yz * k, x - xz * z * k, y - yz * z * k, one - z * z * k};
  }
};

}  // namespace tintree::simplify
