// SPDX-License-Identifier: MIT
//
// R. Bridson, S. Marino, R. Fedkiw, "Simulation of clothing with folds and wrinkles", SCA 2003, as
// printed: force k |E|²/(|N1|+|N2|) (sin(θ/2) - sin(θ0/2)) u and damping -k_d |E| dθ/dt u, with
// dθ/dt = Σ u_i·v_i ("curvature and change rate of the angle", survey 3.1.3; Liu et al. 2012). θ is
// 0 for coplanar triangles; some texts count from π. Deviation: the geometric factor is that of the
// rest shape and part of `stiffness` (half of it, because 2 sin(θ/2) has slope 1). The force
// therefore has the energy
//   E = k [4 (1 - cos(θ/2)) - 2 θ sin(θ0/2)], minus its value at θ0,
// and k_d |E| is damping·stiffness. Sharp folds are soft: at θ = π the stiffness vanishes. For that
// reason force_bending is the default.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

namespace selvedge {
namespace {

class SineHinges {
 public:
  static constexpr int arity = 4;
  static constexpr const char* name = "hinge";

  explicit SineHinges(std::span<const Hinge> hinges) : hinges_(hinges.begin(), hinges.end()) {
    for (std::size_t i = 0; i < hinges.size(); ++i) {
      detail::require_number_of("stiffness", name, i, hinges[i].stiffness);
      detail::require_number_of("damping", name, i, hinges[i].damping);
      detail::require_number_of("size of rest_angle", name, i, std::abs(hinges[i].rest_angle));
    }
  }

  std::size_t size() const { return hinges_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return hinges_[e].v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(hinges_, order); }

  detail::ElementSample<4> sample(std::size_t e, std::span<const Vec3> x) const {
    const Hinge& hinge = hinges_[e];
    detail::ElementSample<4> s;
    const detail::Dihedral d = detail::dihedral(x, hinge.v);
    s.valid = d.valid;
    if (!d.valid) return s;
    const double k = hinge.stiffness, sine0 = elementary::sin(0.5 * hinge.rest_angle);
    const double cosine = elementary::cos(0.5 * d.angle),
                 cosine0 = elementary::cos(0.5 * hinge.rest_angle);
    s.energy = k * (4.0 * (cosine0 - cosine) - 2.0 * (d.angle - hinge.rest_angle) * sine0);
    s.moment = 2.0 * k * (elementary::sin(0.5 * d.angle) - sine0);
    s.slope = k * cosine;
    s.damping = k * hinge.damping;
    s.gradient = d.gradient;
    s.weight.fill(0.0);
    s.plane.setZero();
    return s;
  }

 private:
  std::vector<Hinge> hinges_;
};

}  // namespace

std::unique_ptr<Force> make_bridson_force(std::span<const Hinge> hinges, std::size_t particles) {
  return std::make_unique<detail::ElementForce<SineHinges>>(SineHinges(hinges), particles);
}

void register_bridson(FabricLaws& laws) {
  laws.bending.push_back({.name = "bridson",
                          .text = "by the sine of half of it",
                          .reads = {"bending_friction"},
                          .add_to_grid = detail::add_hinged_grid,
                          .add_to_triangles = detail::add_edge_hinges,
                          .add_to_side = detail::add_side_hinge,
                          .by_sine = true});
  laws.forces.add(
      "bridson", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        std::vector<Hinge> hinges;
        for (const Hinge& hinge : cloth.hinges)
          if (hinge.sine) hinges.push_back(hinge);
        if (!hinges.empty()) forces.push_back(make_bridson_force(hinges, cloth.mass.size()));
        return forces;
      },
      {.promise = "as printed: by the sine of half the angle, damped by its rate",
       .source = "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003",
       .energy = "bending"});
}

}  // namespace selvedge
