// SPDX-License-Identifier: MIT
//
// Twisting springs after X. Dai, Y. Li, X. Zhang, "Simulation anisotropic woven fabric deformation
// with a new particle model", Textile Research Journal 2003: a torsional spring at a particle
// between two links (perpendicular ones for shear, collinear ones for bending), M = k (φ - φ0).
// Each end feels M/l perpendicular to its link, and the centre the opposite of both: net force and
// net moment are zero.
//
// E = ½ k (φ - φ0)². On a straight line the gradient of φ is undefined, but for φ0 = 0 the gradient
// of E is 0 there and its second derivative is k Dᵀ(I - u uᵀ) D, where D is the difference of the
// two directions.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <numbers>

namespace selvedge {
namespace {

class TwistSprings {
 public:
  static constexpr int arity = 3;
  static constexpr const char* name = "twisting spring";

  explicit TwistSprings(std::span<const TwistSpring> springs)
      : springs_(springs.begin(), springs.end()) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      detail::require_number_of("rest_angle", name, i, springs[i].rest_angle);
      detail::require_number_of("pi less rest_angle", name, i,
                                std::numbers::pi - springs[i].rest_angle, false);
      detail::require_number_of("stiffness", name, i, springs[i].stiffness);
      detail::require_number_of("damping", name, i, springs[i].damping);
    }
  }

  std::size_t size() const { return springs_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return springs_[e].v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(springs_, order); }

  detail::ElementSample<3> sample(std::size_t e, std::span<const Vec3> x) const {
    const TwistSpring& spring = springs_[e];
    detail::ElementSample<3> s;
    const Vec3 p = x[spring.v[1]] - x[spring.v[0]], q = x[spring.v[2]] - x[spring.v[1]];
    const double lp = p.norm(), lq = q.norm();
    if (lp <= 0.0 || lq <= 0.0) return s;
    const Vec3 u = p / lp, w = q / lq, n = u.cross(w);
    const double sine = n.norm(), cosine = u.dot(w), angle = elementary::atan2(sine, cosine);
    const double deviation = angle - spring.rest_angle;
    s.valid = true;
    s.energy = 0.5 * spring.stiffness * deviation * deviation;
    s.damping = spring.damping * spring.stiffness;
    s.weight = {1.0 / lp, -(1.0 / lp + 1.0 / lq), 1.0 / lq};
    // Below this value the normal of the plane of both links is rounding error.
    constexpr double straight = 1e-12;
    if (sine <= straight) {
      // Folded flat, the direction is undefined in any case; straight, the moment is k (0 - φ0).
      set_straight(spring, u, cosine > 0.0, s);
      return s;
    }
    const Vec3 normal = n / sine;
    // u rotates by δ towards its side normal×u: the angle grows when u rotates back and w forward.
    const Vec3 across_u = normal.cross(u) / lp, across_w = normal.cross(w) / lq;
    s.gradient = {across_u, Vec3(-across_u - across_w), across_w};
    s.moment = spring.stiffness * deviation;
    s.slope = spring.stiffness;
    set_across(spring, deviation, sine, cosine, normal, s);
    return s;
  }

 private:
  static void set_straight(const TwistSpring& spring, const Vec3& u, bool ahead,
                           detail::ElementSample<3>& s) {
    s.gradient.fill(Vec3::Zero());
    s.slope = 0.0;
    s.damping = 0.0;
    s.bound = spring.stiffness;
    s.across = ahead && spring.rest_angle <= 0.0 ? spring.stiffness : 0.0;
    s.plane = Mat3::Identity() - u * u.transpose();
  }

  // Out of the plane of the links, with the rotations δu and δw,
  //   φ + [½ cos φ (δu² + δw²) - δu δw]/sin φ = φ + [½ cos φ (δu-δw)² - (1-cos φ) δu δw]/sin φ.
  // The first part is kept if it is positive; on a straight line it is the only one.
  static void set_across(const TwistSpring& spring, double deviation, double sine, double cosine,
                         const Vec3& normal, detail::ElementSample<3>& s) {
    const double tension = spring.stiffness * deviation;
    s.across = std::max(0.0, tension * cosine / sine);
    // The in-plane second derivative of φ adds at most 1/l² for each link.
    s.bound = std::abs(tension) * (1.0 + (std::abs(cosine) + 1.0 - cosine) / sine);
    s.plane = normal * normal.transpose();
  }

  std::vector<TwistSpring> springs_;
};

}  // namespace

std::unique_ptr<Force> make_twist_force(std::span<const TwistSpring> springs,
                                        std::size_t particles) {
  return std::make_unique<detail::ElementForce<TwistSprings>>(TwistSprings(springs), particles);
}

namespace {

// A torsional spring at a particle rotates by κ d and stores ½ k κ² d²: k = (share·area)/d².
void add_bend_twists(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  detail::for_each_line(grid, m, [&](const detail::GridLine& line) {
    cloth.twists.push_back({{line.before, line.centre, line.after},
                            0.0,
                            line.rigidity_area / (line.spacing * line.spacing),
                            m.bending_damping});
  });
}

void add_grid_twist(ClothMesh& cloth, const GridConfig& grid, const Material& material) {
  if (material.shear_stiffness <= 0.0) return;
  const detail::CellConstants c = detail::cell_sides(grid);
  // Under a shear γ each of the four corners of a cell rotates by γ: 4 · ½ k γ² = ½ G γ² a b.
  const double stiffness = 0.25 * material.shear_stiffness * c.a * c.b;
  const std::int32_t up = grid.cells_x + 1;
  const auto add = [&](std::int32_t x_end, std::int32_t corner, std::int32_t y_end) {
    cloth.twists.push_back(
        {{x_end, corner, y_end}, 0.5 * std::numbers::pi, stiffness, material.spring_damping});
  };
  for (std::int32_t j = 0; j < grid.cells_y; ++j)
    for (std::int32_t i = 0; i < grid.cells_x; ++i) {
      const std::int32_t v00 = j * up + i, v10 = v00 + 1, v01 = v00 + up, v11 = v01 + 1;
      add(v10, v00, v01);
      add(v00, v10, v11);
      add(v11, v01, v00);
      add(v01, v11, v10);
    }
  if (material.shear_friction <= 0.0) return;
  // As above, 4 M γ = HG γ a b.
  const double moment = 0.25 * material.shear_friction * c.a * c.b;
  for (const TwistSpring& twist : cloth.twists)
    if (twist.rest_angle > 0.0)
      cloth.corner_frictions.push_back({twist.v, twist.rest_angle, moment, detail::kYieldShear});
}

}  // namespace

void register_twisting(FabricLaws& laws) {
  laws.bending.push_back({.name = "twisting",
                          .text = "moments along lines of particles",
                          .add_to_grid = add_bend_twists});
  laws.shear.push_back(
      {.name = "twisting",
       .text = "moments between warp and weft, only in the rectangular and responsive patterns",
       .reads = {"shear_friction"},
       .add_to_grid = add_grid_twist});
  laws.forces.add(
      "twisting", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        if (!cloth.twists.empty())
          forces.push_back(make_twist_force(cloth.twists, cloth.mass.size()));
        return forces;
      },
      {.promise = "minus the gradient of its energy",
       .source = "Dai, Li, Zhang, Simulation anisotropic woven fabric deformation, 2003",
       .energy = "twisting"});
}

}  // namespace selvedge
