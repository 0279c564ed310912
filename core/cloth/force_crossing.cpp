// SPDX-License-Identifier: MIT
//
// The angle between two yarns that cross, after S. Kawabata, M. Niwa, H. Kawai, "The
// finite-deformation theory of plain-weave fabrics, part III: the shear-deformation theory",
// Journal of the Textile Institute 1973: turning one yarn against the other takes a moment that is
// proportional to the angle of shear. (Part III adds friction, which this law leaves out.) G. Cirio
// et al., "Yarn-level simulation of woven cloth", 2014, has the same energy at the crossing nodes.
//
// The yarns have the directions u = (x1 - x0)/|x1 - x0| and w = (x3 - x2)/|x3 - x2|. Over the angle
// φ by which they differ from perpendicular ones,
//   φ = arcsin(u·w),  E = ½ k (φ - φ0)²,
//   ∂φ/∂x1 = (w - (u·w) u)/(|x1 - x0| cos φ), and likewise for x3.
// Each gradient is perpendicular to its yarn, so that the forces have no sum, and their moments
// cancel: u × w + w × u = 0. The same law keeps two yarns from sliding along each other: between a
// yarn and the link from its axis to that of the other.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <numbers>

namespace selvedge {
namespace {

class Crossings {
 public:
  static constexpr int arity = 4;
  static constexpr const char* name = "crossing";

  explicit Crossings(std::span<const Crossing> crossings)
      : crossings_(crossings.begin(), crossings.end()) {
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      detail::require_number_of("right angle less |rest_angle|", name, i,
                                0.5 * std::numbers::pi - std::abs(crossings[i].rest_angle), false);
      detail::require_number_of("stiffness", name, i, crossings[i].stiffness);
      detail::require_number_of("damping", name, i, crossings[i].damping);
    }
  }

  std::size_t size() const { return crossings_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return crossings_[e].v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(crossings_, order); }

  detail::ElementSample<4> sample(std::size_t e, std::span<const Vec3> x) const {
    const Crossing& crossing = crossings_[e];
    detail::ElementSample<4> s;
    const Vec3 p = x[crossing.v[1]] - x[crossing.v[0]], q = x[crossing.v[3]] - x[crossing.v[2]];
    const double lp = p.norm(), lq = q.norm();
    if (lp <= 0.0 || lq <= 0.0) return s;
    const Vec3 u = p / lp, w = q / lq;
    const Vec3 n = u.cross(w);
    const double sine = u.dot(w), cosine = n.norm();
    const double angle = elementary::atan2(sine, cosine) - crossing.rest_angle;
    s.energy = 0.5 * crossing.stiffness * angle * angle;
    // Parallel yarns have no plane in which to turn.
    constexpr double parallel = 1e-12;
    if (cosine <= parallel) return s;
    s.valid = true;
    // (u × w) × u = w - (u·w) u, without the cancellation where the yarns are nearly parallel.
    const Vec3 normal = n / cosine;
    const Vec3 turn_u = normal.cross(u) / lp, turn_w = w.cross(normal) / lq;
    s.gradient = {Vec3(-turn_u), turn_u, Vec3(-turn_w), turn_w};
    s.moment = crossing.stiffness * angle;
    s.slope = crossing.stiffness;
    s.damping = crossing.damping * crossing.stiffness;
    // The second derivatives of φ are at most (1 + 2 cos φ)/(l² cos φ) for one yarn and 1/(lp lq
    // cos φ) plus the product of both gradients for two.
    s.bound = 4.0 * std::abs(s.moment) / cosine;
    s.weight = {-1.0 / lp, 1.0 / lp, -1.0 / lq, 1.0 / lq};
    return s;
  }

 private:
  std::vector<Crossing> crossings_;
};

}  // namespace

std::unique_ptr<Force> make_crossing_force(std::span<const Crossing> crossings,
                                           std::size_t particles) {
  return std::make_unique<detail::ElementForce<Crossings>>(Crossings(crossings), particles);
}

void register_crossings(FabricLaws& laws) {
  laws.forces.add("crossing", {},
                  [](const MethodOptions&, const ClothMesh& cloth) {
                    ForceList forces;
                    if (!cloth.crossings.empty())
                      forces.push_back(make_crossing_force(cloth.crossings, cloth.mass.size()));
                    return forces;
                  },
                  {.promise = "minus the gradient of its energy; elastic, without friction",
                   .source = "Kawabata, Niwa, Kawai, Finite-deformation theory of plain-weave "
                             "fabrics, part III, 1973; Cirio et al. 2014",
                   .energy = "twisting"});
}

}  // namespace selvedge
