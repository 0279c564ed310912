// SPDX-License-Identifier: MIT
//
// A crumpled piece of cloth, the forces on it and their Jacobians, as dense matrices.
#pragma once

#include <selvedge/core/block_matrix.h>
#include <selvedge/core/cloth_mesh.h>
#include <selvedge/core/force.h>

#include <Eigen/Geometry>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace selvedge {

using Vectors = std::vector<Vec3>;

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

/// A crumpled piece of cloth: rest shape plus noise of `noise` metres.
struct Crumple {
  ClothMesh cloth;
  Vectors x, v;
  explicit Crumple(double noise, unsigned seed = 7, double shear = 100.0) {
    Material material;
    material.bending_stiffness = 1e-3;
    material.shear_stiffness = shear;
    cloth = make_rectangular({0.5, 0.4, 5, 4}, material);
    const std::size_t n = cloth.mass.size();
    x = random_vectors(n, noise, seed);
    v = random_vectors(n, 1.0, seed + 1);
    for (std::size_t i = 0; i < n; ++i) x[i] += cloth.surface.vertices[i];
  }
  ForceState state() const { return {x, v, cloth.mass, 0.0}; }
  std::vector<double> areas() const {
    std::vector<double> a;
    for (const Triangle& t : cloth.surface.triangles) {
      const auto& r = cloth.surface.vertices;
      a.push_back(0.5 * (r[t[1]] - r[t[0]]).cross(r[t[2]] - r[t[0]]).norm());
    }
    return a;
  }
};

struct NamedForce {
  std::string name;
  std::unique_ptr<Force> force;
};

inline ClothMesh with_damping(ClothMesh cloth, double damping) {
  for (Spring& s : cloth.springs) s.damping = damping;
  for (Hinge& h : cloth.hinges) h.damping = damping;
  return cloth;
}

/// Springs and hinges of one, two and three times `damping` by turns.
inline std::vector<NamedForce> internal_forces(const Crumple& c, double damping) {
  ClothMesh cloth = c.cloth;
  for (std::size_t i = 0; i < cloth.springs.size(); ++i)
    cloth.springs[i].damping = (1.0 + i % 3) * damping;
  for (std::size_t i = 0; i < cloth.hinges.size(); ++i)
    cloth.hinges[i].damping = (1.0 + i % 3) * damping;
  std::vector<NamedForce> forces;
  forces.push_back({"hooke", make_hooke_force(cloth.springs, c.x.size())});
  forces.push_back({"bending", make_bending_force(cloth.hinges, c.x.size())});
  return forces;
}

inline std::vector<NamedForce> all_forces(const Crumple& c, double damping) {
  std::vector<NamedForce> forces = internal_forces(c, damping);
  forces.push_back({"gravity", make_gravity({1.0, 2.0, -9.81})});
  forces.push_back({"air", make_air_force({{1.0, 2.0, 3.0}, 0.5, 0.2}, c.cloth.surface.triangles,
                                          c.areas(), c.x.size())});
  return forces;
}

inline Vectors force_at(const Force& force, const ForceState& state) {
  Vectors f(state.x.size(), Vec3::Zero());
  force.add_force(state, f);
  return f;
}

/// The assembled -h ∂F/∂v - h² ∂F/∂x as a dense matrix.
inline Eigen::MatrixXd dense_jacobian(Force& force, const ForceState& state, double h) {
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
    dense.col(k) = flat(column);
  }
  return dense;
}

/// ∂F/∂x (or ∂F/∂v) by central differences.
inline Eigen::MatrixXd difference_jacobian(const Force& force, Crumple c, bool velocity) {
  constexpr double step = 1e-6;
  const std::size_t n = c.x.size();
  Eigen::MatrixXd dense(3 * n, 3 * n);
  Vectors& u = velocity ? c.v : c.x;
  for (std::size_t k = 0; k < 3 * n; ++k) {
    const double old = u[k / 3][k % 3];
    u[k / 3][k % 3] = old + step;
    const Vectors up = force_at(force, c.state());
    u[k / 3][k % 3] = old - step;
    const Vectors down = force_at(force, c.state());
    u[k / 3][k % 3] = old;
    dense.col(k) = (flat(up) - flat(down)) / (2.0 * step);
  }
  return dense;
}

}  // namespace selvedge
