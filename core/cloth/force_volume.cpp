// SPDX-License-Identifier: MIT
//
// Surface and volume difference after L. Zhengdong, S. Shuyuan, "A mass-spring model for real time
// cloth deformation", 2011; T. Vassilev, B. Spanlang 2014 (survey sections 2.9, 3.1.1). [survey eq.
// 3] F(P_i) = -K (Δl_tot + C Δl_i) u_i, where Δl_tot is the volume difference per area, ΔV/A, C a
// number in (0,1) (the text says "the body center and a coefficient"), Δl_i the length change of
// the support spring from the centre to P_i, and u_i its direction. The equation has no reaction,
// so a body would move itself. Here the centre, a particle, takes the reaction: Σf = 0, and the
// moment is zero because all f_i point to the centre. V = Σ x_a·(x_b × x_c)/6 over the triangles,
// relative to the centre.
//
// The term C Δl_i is a Hooke spring of stiffness K C (make_supported adds it to the mesh); this
// force is the volume term. It points along u_i instead of along the normals, so it is not the
// gradient of an energy and has none here. Its Jacobian, -K/A u_i ⊗ ∂V/∂x_j, couples all particles
// and is not symmetric. Implicit steps replace it by that of a spring of stiffness K a/A along each
// u_i, where a is the current area. This is exact for a uniform expansion if the u_i are the
// normals, and an upper bound for any other motion. So a step of any length is stable, and other
// motions are overdamped. The rotation term of u_i, -K ΔV/A (I - u uᵀ)/l, is kept if the body is
// too large.
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <string>

namespace selvedge {
namespace {

double signed_volume(std::span<const Vec3> x, std::span<const Triangle> triangles,
                     const Vec3& from) {
  double sum = 0.0;
  for (const Triangle& t : triangles)
    sum += (x[t[0]] - from).dot((x[t[1]] - from).cross(x[t[2]] - from));
  return sum / 6.0;
}

double surface_area(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  double sum = 0.0;
  for (const Triangle& t : triangles)
    sum += 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
  return sum;
}

/// Throws unless every side has an opposite one: a volume needs a closed, consistently oriented
/// surface.
void require_closed(std::span<const Triangle> triangles) {
  std::map<Edge, int> balance;
  for (const Triangle& t : triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  for (const auto& [edge, count] : balance)
    if (count != 0)
      throw std::invalid_argument("volume: the edge of particles " + std::to_string(edge[0]) +
                                  " and " + std::to_string(edge[1]) +
                                  " is open; a volume needs a closed surface");
}

class VolumeForce final : public Force {
 public:
  VolumeForce(double stiffness, std::int32_t centre, std::span<const Triangle> triangles,
              std::span<const Vec3> rest)
      : stiffness_(stiffness), centre_(centre), triangles_(triangles.begin(), triangles.end()) {
    detail::require_number("volume stiffness", stiffness);
    detail::require_particle("volume centre", 0, centre, rest.size());
    std::vector<char> on_surface(rest.size(), 0);
    for (std::size_t k = 0; k < triangles.size(); ++k)
      for (const std::int32_t v : triangles[k]) {
        detail::require_particle("triangle", k, v, rest.size());
        on_surface[v] = 1;
      }
    if (on_surface[centre] != 0)
      throw std::invalid_argument("volume: the centre, particle " + std::to_string(centre) +
                                  ", is on the surface");
    require_closed(triangles);
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (on_surface[i] != 0) surface_.push_back(static_cast<std::int32_t>(i));
    rest_volume_ = signed_volume(rest, triangles_, rest[centre]);
    rest_area_ = surface_area(rest, triangles_);
    detail::require_number("rest volume", rest_volume_, false);
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const Vec3& c = state.x[centre_];
    const double push = -stiffness_ * difference(state.x);
    Vec3 sum = Vec3::Zero();
    for (const std::int32_t i : surface_) {
      const Vec3 d = state.x[i] - c;
      const double length = d.norm();
      if (length <= 0.0) continue;
      const Vec3 force = (push / length) * d;
      f[i] += force;
      sum += force;
    }
    f[centre_] -= sum;
  }

  double energy(const ForceState&) const override { return 0.0; }
  void add_links(std::vector<Edge>& links) const override {
    for (const std::int32_t i : surface_) links.push_back({i, centre_});
  }
  void bind(const BlockMatrix& matrix) override {
    slots_.clear();
    for (const std::int32_t i : surface_)
      slots_.push_back({matrix.slot(i, i), matrix.slot(i, centre_), matrix.slot(centre_, i),
                        matrix.slot(centre_, centre_)});
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    const double along = h * h * stiffness_ * surface_area(state.x, triangles_) / rest_area_;
    const double swelling = h * h * stiffness_ * std::max(0.0, difference(state.x));
    const std::span<Mat3> values = a.values();
    for (std::size_t k = 0; k < surface_.size(); ++k) {
      const Vec3 d = state.x[surface_[k]] - state.x[centre_];
      const double length = d.norm();
      if (length <= 0.0) continue;
      const Mat3 in = d * d.transpose() / (length * length);
      const Mat3 block = along * in + (swelling / length) * (Mat3::Identity() - in);
      values[slots_[k][0]] += block;
      values[slots_[k][1]] -= block;
      values[slots_[k][2]] -= block;
      values[slots_[k][3]] += block;
    }
  }

  // ∂f_i/∂x_j = -K/A u_i ⊗ ∂V/∂x_j - K ΔV/A ∂u_i/∂x_j, |∂V/∂x_j| at most a third of the area of
  // the triangles of j, together A.
  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double>) const override {
    const double share = surface_area(state.x, triangles_) / rest_area_;
    const double push = std::abs(stiffness_ * difference(state.x));
    double sum = 0.0;
    for (const std::int32_t i : surface_) {
      const double length = (state.x[i] - state.x[centre_]).norm();
      const double row = stiffness_ * share + (length > 0.0 ? 2.0 * push / length : 0.0);
      stiffness[i] += row;
      sum += row;
    }
    stiffness[centre_] += sum;
  }

 private:
  double difference(std::span<const Vec3> x) const {
    return (signed_volume(x, triangles_, x[centre_]) - rest_volume_) / rest_area_;
  }

  double stiffness_;
  std::int32_t centre_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> surface_;
  std::vector<std::array<std::int32_t, 4>> slots_;  // per particle of the surface, with the centre
  double rest_volume_ = 0.0, rest_area_ = 0.0;
};

}  // namespace

std::unique_ptr<Force> make_volume_force(double stiffness, std::int32_t centre,
                                         std::span<const Triangle> triangles,
                                         std::span<const Vec3> rest) {
  return std::make_unique<VolumeForce>(stiffness, centre, triangles, rest);
}

void register_volume(FabricLaws& laws) {
  laws.forces.add_keyed(
      "volume", "geometry.*.support",
      {.promise = "no net force, no net moment; not a gradient; survey eq. 3 corrected",
       .source = "Zhengdong, Shuyuan, 2011; Vassilev, Spanlang, 2014"});
}

}  // namespace selvedge
