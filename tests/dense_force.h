// SPDX-License-Identifier: MIT
//
// Forces in random states, and their Jacobians as dense matrices.
#pragma once

#include <selvedge/core/cloth/force.h>

#include <Eigen/Core>
#include <random>
#include <vector>

namespace selvedge {

using Vectors = std::vector<Vec3>;

/// A state that owns its arrays.
struct ForceStateOwner {
  Vectors x, v;
  std::vector<double> mass;
  ForceState view() const { return {x, v, mass, 0.0}; }
  operator ForceState() const { return view(); }
};

inline Vectors random_vectors(std::size_t n, double size, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> coordinate(-size, size);
  Vectors out(n);
  for (Vec3& v : out)
    for (int k = 0; k < 3; ++k) v[k] = coordinate(generator);
  return out;
}

inline Eigen::Map<const Eigen::VectorXd> flat(const Vectors& v) {
  return {v.data()->data(), static_cast<Eigen::Index>(3 * v.size())};
}

inline Vectors force_at(const Force& force, const ForceState& state) {
  Vectors f(state.x.size(), Vec3::Zero());
  force.add_force(state, f);
  return f;
}

/// The assembled -h ∂F/∂v - h² ∂F/∂x as a dense matrix.
inline Eigen::MatrixXd assembled(Force& force, const ForceState& state, double h) {
  const std::size_t n = state.x.size();
  std::vector<Edge> links;
  force.add_links(links);
  BlockMatrix a(n, links);
  force.bind(a);
  force.add_jacobian(state, h, a);
  Eigen::MatrixXd dense(3 * n, 3 * n);
  Vectors e(n, Vec3::Zero()), column(n);
  for (std::size_t k = 0; k < 3 * n; ++k) {
    e[k / 3][k % 3] = 1.0;
    a.multiply(e, column);
    e[k / 3][k % 3] = 0.0;
    dense.col(static_cast<Eigen::Index>(k)) = flat(column);
  }
  return dense;
}

}  // namespace selvedge
