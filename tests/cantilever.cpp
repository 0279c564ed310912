// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/force.h>
#include <selvedge/tests/cantilever.h>

#include <algorithm>

namespace selvedge::testing {
namespace {

using Vectors = std::vector<Vec3>;

double dot(const Vectors& a, const Vectors& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

/// Solves A u = f in the plane for the vertices that are `free`, by conjugate gradients from u.
Vectors solve_plane(const BlockMatrix& a, Vectors u, const Vectors& f,
                    const std::vector<char>& free) {
  const std::size_t n = u.size();
  const auto keep_free = [&](Vectors& v) {
    for (std::size_t i = 0; i < n; ++i) {
      v[i].z() = 0.0;
      if (free[i] == 0) v[i].setZero();
    }
  };
  Vectors r(n), image(n);
  a.multiply(u, r);
  for (std::size_t i = 0; i < n; ++i) r[i] = f[i] - r[i];
  keep_free(r);
  Vectors d = r;
  constexpr double accuracy = 1e-24;  // of the squared residual
  constexpr int most = 20000;
  double norm = dot(r, r);
  const double enough = accuracy * norm;
  for (int k = 0; k < most && norm > enough; ++k) {
    a.multiply(d, image);
    keep_free(image);
    const double step = norm / dot(d, image);
    for (std::size_t i = 0; i < n; ++i) {
      u[i] += step * d[i];
      r[i] -= step * image[i];
    }
    const double next = dot(r, r);
    for (std::size_t i = 0; i < n; ++i) d[i] = r[i] + next / norm * d[i];
    norm = next;
  }
  return u;
}

}  // namespace

Material Cantilever::material(const std::string& law) const {
  Material m;
  m.stretch_stiffness = stretch;
  m.shear_stiffness = 0.5 * stretch / (1.0 + poisson);
  m.spring_damping = 0.0;
  m.stretch_law = law;
  if (law != "hooke") m.poisson = poisson;
  return m;
}

Vec3 Cantilever::displacement(double x, double y) const {
  const double p = load / (stretch * inertia()), shear = 0.5 * stretch / (1.0 + poisson);
  const double q = load / (shear * inertia());
  return {-0.5 * p * x * x * y - poisson * p * y * y * y / 6.0 + q * y * y * y / 6.0 +
              0.5 * (p * length * length - q * half * half) * y,
          0.5 * poisson * p * x * y * y + p * x * x * x / 6.0 - 0.5 * p * length * length * x +
              p * length * length * length / 3.0,
          0.0};
}

/// The load on the end below y, but for a constant.
double Cantilever::load_below(double y) const {
  return 0.5 * load / inertia() * (half * half * y - y * y * y / 3.0);
}

/// Its moment about the middle, but for a constant.
double Cantilever::moment_below(double y) const {
  return 0.5 * load / inertia() * (0.5 * half * half * y * y - 0.25 * y * y * y * y);
}

Vectors Cantilever::solve(const ClothMesh& cloth, Force& carrier, std::int32_t rows) const {
  const std::size_t n = cloth.mass.size(), row = n / (rows + 1);
  std::vector<Edge> links;
  carrier.add_links(links);
  BlockMatrix a(n, links);
  carrier.bind(a);
  const Vectors &rest = cloth.surface.vertices, still(n, Vec3::Zero());
  carrier.add_jacobian({rest, still, cloth.mass, 0.0}, 1.0, a);
  Vectors u(n, Vec3::Zero()), f(n, Vec3::Zero());
  std::vector<char> free(n, 1);
  for (std::int32_t j = 0; j <= rows; ++j) {
    const std::size_t loaded = j * row, clamped = loaded + row - 1;
    const double y = rest[loaded].y();
    u[clamped] = displacement(length, y);
    free[clamped] = 0;
    if (j == rows) break;
    // The load of this piece of the end, divided between its vertices as their shape functions do.
    const double above = rest[loaded + row].y(), h = above - y;
    const double sum = load_below(above) - load_below(y);
    const double moment = moment_below(above) - moment_below(y);
    f[loaded + row].y() += (moment - y * sum) / h;
    f[loaded].y() += (above * sum - moment) / h;
  }
  return solve_plane(a, std::move(u), f, free);
}

double Cantilever::error(const ClothMesh& cloth, Force& carrier, std::int32_t rows) const {
  const Vectors u = solve(cloth, carrier, rows);
  double largest = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const Vec3& x = cloth.surface.vertices[i];
    largest = std::max(largest, (u[i] - displacement(x.x() + 0.5 * length, x.y())).norm());
  }
  return largest / displacement(0.0, 0.0).norm();
}

}  // namespace selvedge::testing
