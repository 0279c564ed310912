// SPDX-License-Identifier: MIT
//
// A crumpled piece of cloth, the forces on it and their Jacobians, as dense matrices.
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/patterns/make_cloth.h>

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dense_force.h"

namespace selvedge {

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

/// Springs and hinges; their damping is one, two and three times `damping` in turn.
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
