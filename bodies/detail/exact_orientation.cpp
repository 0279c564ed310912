// SPDX-License-Identifier: MIT
// Floating-point filter followed, if its result is uncertain, by exact arithmetic on expansions
// (sums of non-overlapping doubles). [Shewchuk1997] Adaptive Precision Floating-Point Arithmetic
// and Fast Robust Geometric Predicates. Deviation: one filter stage and then full precision,
// instead of four stages.
#include <selvedge/bodies/detail/exact_orientation.h>

#include <cmath>
#include <cstddef>
#include <limits>

namespace selvedge::detail {

namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon() / 2.0;  // 2⁻⁵³
// [Shewchuk1997] error bounds A of section 4.3 and 4.2, relative to the sum of absolute products.
constexpr double kOrient3dBound = (7.0 + 56.0 * kRounding) * kRounding;
constexpr double kOrient2dBound = (3.0 + 16.0 * kRounding) * kRounding;

int sign(double value) { return (value > 0.0) - (value < 0.0); }

// A sum of at most N doubles, smallest first, none overlapping another. Its sign is that of the
// last nonzero component.
template <std::size_t N>
struct Expansion {
  double part[N];
  std::size_t size = 0;

  // Grow-Expansion, [Shewchuk1997] figure 6, without zero components.
  void add(double b) {
    double q = b;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double sum = q + part[i];
      const double virtual_b = sum - q;
      const double error = (q - (sum - virtual_b)) + (part[i] - virtual_b);
      if (error != 0.0) part[kept++] = error;
      q = sum;
    }
    if (q != 0.0) part[kept++] = q;
    size = kept;
  }
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  int sign() const { return size == 0 ? 0 : detail::sign(part[size - 1]); }
};

using Difference = Expansion<2>;

Difference difference(double a, double b) {
  Difference d;
  d.add(a);
  d.add(-b);
  return d;
}

template <std::size_t N, std::size_t M>
Expansion<2 * N * M> product(const Expansion<N>& a, const Expansion<M>& b) {
  Expansion<2 * N * M> p;
  for (std::size_t i = 0; i < a.size; ++i)
    for (std::size_t j = 0; j < b.size; ++j) p.add_product(a.part[i], b.part[j]);
  return p;
}

template <std::size_t N, std::size_t M>
Expansion<N + M> sum(const Expansion<N>& a, const Expansion<M>& b, double sign_b) {
  Expansion<N + M> s;
  for (std::size_t i = 0; i < a.size; ++i) s.add(a.part[i]);
  for (std::size_t i = 0; i < b.size; ++i) s.add(sign_b * b.part[i]);
  return s;
}

// p_i q_j - p_j q_i
Expansion<16> minor(const Difference (&p)[3], const Difference (&q)[3], int i, int j) {
  return sum(product(p[i], q[j]), product(p[j], q[i]), -1.0);
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  Difference u[3], v[3], w[3];
  for (int k = 0; k < 3; ++k) {
    u[k] = difference(a[k], d[k]);
    v[k] = difference(b[k], d[k]);
    w[k] = difference(c[k], d[k]);
  }
  const auto x = product(u[0], minor(v, w, 1, 2));
  const auto y = product(u[1], minor(v, w, 2, 0));
  const auto z = product(u[2], minor(v, w, 0, 1));
  return sum(sum(x, y, 1.0), z, 1.0).sign();
}

int exact_orientation(const Vec3& a, const Vec3& b, const Vec3& c, int i, int j) {
  Difference u[3], v[3];
  for (const int k : {i, j}) {
    u[k] = difference(a[k], c[k]);
    v[k] = difference(b[k], c[k]);
  }
  return minor(u, v, i, j).sign();
}

}  // namespace

int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = a - d, v = b - d, w = c - d;
  const double vw_yz = v.y() * w.z(), vw_zy = v.z() * w.y();
  const double vw_zx = v.z() * w.x(), vw_xz = v.x() * w.z();
  const double vw_xy = v.x() * w.y(), vw_yx = v.y() * w.x();
  const double determinant =
      u.x() * (vw_yz - vw_zy) + u.y() * (vw_zx - vw_xz) + u.z() * (vw_xy - vw_yx);
  const double permanent = (std::abs(vw_yz) + std::abs(vw_zy)) * std::abs(u.x()) +
                           (std::abs(vw_zx) + std::abs(vw_xz)) * std::abs(u.y()) +
                           (std::abs(vw_xy) + std::abs(vw_yx)) * std::abs(u.z());
  if (std::abs(determinant) > kOrient3dBound * permanent) return sign(determinant);
  if (permanent == 0.0) return 0;  // every product is 0, which is common on flat faces
  return exact_orientation(a, b, c, d);
}

int exact_side(const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const double left = (a[i] - c[i]) * (b[j] - c[j]), right = (a[j] - c[j]) * (b[i] - c[i]);
  const double determinant = left - right;
  if (std::abs(determinant) > kOrient2dBound * (std::abs(left) + std::abs(right)))
    return sign(determinant);
  return exact_orientation(a, b, c, i, j);
}

}  // namespace selvedge::detail
