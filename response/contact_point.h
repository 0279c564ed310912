// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/collision_types.h>
#include <selvedge/core/types.h>

#include <array>
#include <cstdint>
#include <span>

namespace selvedge {

/// A contact in the index space of the response: cloth particles first, [0, particles), then body
/// vertices. Σ weight·x is the vector from the point on the second primitive to the point on the
/// first; its product with `normal` is the gap. The weights sum to 0.
struct ContactPoint {
  std::array<std::int32_t, 4> vertex;
  std::array<double, 4> weight;
  Vec3 normal;
  double gap = 0.0;       ///< m, at t = 0, signed distance along `normal`
  double rest_gap = 0.0;  ///< m, distance that the contact keeps at rest
  double friction = 0.0;  ///< Coulomb coefficient
  /// point_triangle and triangle_point: vertex 0 is the point; edge_edge: 0 and 1 are one edge.
  ContactKind kind = ContactKind::point_triangle;
};

/// The motion that a response works on. Body vertices follow the particles in the arrays and have
/// inv_mass 0.
struct ContactMotion {
  std::span<const Vec3> x_t0;
  std::span<const double> inv_mass;  ///< 1/kg, 0 for held particles and body vertices
  std::size_t particles = 0;         ///< number of cloth particles
  double h = 0.0;                    ///< s, length of the step
};

/// Σ weight·x over the four vertices.
inline Vec3 relative(const ContactPoint& c, std::span<const Vec3> x) {
  return c.weight[0] * x[c.vertex[0]] + c.weight[1] * x[c.vertex[1]] +
         c.weight[2] * x[c.vertex[2]] + c.weight[3] * x[c.vertex[3]];
}

/// Number of vertices that belong to the first primitive.
inline int first_count(const ContactPoint& c) { return c.kind == ContactKind::edge_edge ? 2 : 1; }

/// Compliance of a contact, 1/kg: Σ weight²/mass. An impulse along the contact changes its relative
/// velocity by this factor.
inline double compliance(const ContactPoint& c, std::span<const double> inv_mass) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += c.weight[k] * c.weight[k] * inv_mass[c.vertex[k]];
  return sum;
}

}  // namespace selvedge
