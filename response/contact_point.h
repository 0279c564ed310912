// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/core/types.h>

#include <array>
#include <cstdint>
#include <span>

namespace selvedge {

/// A contact in the index space of the response: cloth particles first, [0, particles), then body
/// vertices. Σ weight·x is the vector from the second primitive's point to the first one's; its
/// product with `normal` is the gap. Weights sum to 0.
struct ContactPoint {
  std::array<std::int32_t, 4> vertex;
  std::array<double, 4> weight;
  Vec3 normal;
  double gap = 0.0;       ///< m at t = 0, measured along `normal`
  double rest_gap = 0.0;  ///< m, the distance that the contact keeps
  double friction = 0.0;  ///< Coulomb coefficient
  /// point_triangle and triangle_point: vertex 0 is the point; edge_edge: 0 and 1 are one edge.
  ContactKind kind = ContactKind::point_triangle;
};

/// The motion that a response works on. Body vertices have inv_mass 0 and follow the particles.
struct ContactMotion {
  std::span<const Vec3> x_t0;
  std::span<const double> inv_mass;  ///< 1/kg, 0 for held particles and body vertices
  std::size_t particles = 0;         ///< how many of them are cloth
  double h = 0.0;                    ///< s, length of the step
};

/// Σ weight·x over the four vertices.
inline Vec3 relative(const ContactPoint& c, std::span<const Vec3> x) {
  return c.weight[0] * x[c.vertex[0]] + c.weight[1] * x[c.vertex[1]] +
         c.weight[2] * x[c.vertex[2]] + c.weight[3] * x[c.vertex[3]];
}

/// How many of the four vertices belong to the first primitive.
inline int first_count(const ContactPoint& c) { return c.kind == ContactKind::edge_edge ? 2 : 1; }

/// Σ weight²/mass: how easily an impulse along the contact moves its vertices apart, 1/kg.
inline double compliance(const ContactPoint& c, std::span<const double> inv_mass) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += c.weight[k] * c.weight[k] * inv_mass[c.vertex[k]];
  return sum;
}

}  // namespace selvedge
