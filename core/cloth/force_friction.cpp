// SPDX-License-Identifier: MIT
//
// Hysteresis of bending and shear as measured by KES-F instruments: M = B κ ± HB, F = G φ ± HG (S.
// Kawabata; survey 3.1.2, Zhong and Wang 1998, Ji et al. 2006, Zhang et al. 2012, who fit the
// curves but do not say how the branch changes). This force is the term ±: a slider in series with
// a spring at every hinge or corner. It sticks to an angle and opposes rotation with a moment that
// grows to `moment` over `yield`; beyond that it is dragged along. The angle at which it sticks
// changes
// only when a step is accepted (`accept`); within a step the force is the gradient of
//   E = ½ (M/y) e² for |e| <= y, M (|e| - y/2) beyond,  e = θ - slip.
// Unloaded cloth keeps the curvature HB/B. 2HG5, the hysteresis at 5°, is not used: the loop has
// the same width everywhere.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/detail/yarn_triangle.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <numbers>

namespace selvedge {
namespace {

/// Angle and gradient of a hinge or of the corner of a twisting spring.
template <int N>
struct Angle {
  double value = 0.0;
  std::array<Vec3, N> gradient;
  bool valid = false;
};

Angle<4> angle_of(std::span<const Vec3> x, const std::array<std::int32_t, 4>& v) {
  const detail::Dihedral d = detail::dihedral(x, v);
  return {d.angle, d.gradient, d.valid};
}

Angle<3> angle_of(std::span<const Vec3> x, const std::array<std::int32_t, 3>& v) {
  Angle<3> a;
  const Vec3 p = x[v[1]] - x[v[0]], q = x[v[2]] - x[v[1]];
  const double lp = p.norm(), lq = q.norm();
  if (lp <= 0.0 || lq <= 0.0) return a;
  const Vec3 u = p / lp, w = q / lq, n = u.cross(w);
  const double sine = n.norm();
  // If the corner is straight or folded flat, the plane of rotation is undefined.
  constexpr double straight = 1e-12;
  a.value = elementary::atan2(sine, u.dot(w));
  a.valid = sine > straight;
  if (!a.valid) return a;
  const Vec3 normal = n / sine, across_u = normal.cross(u) / lp, across_w = normal.cross(w) / lq;
  a.gradient = {across_u, Vec3(-across_u - across_w), across_w};
  return a;
}

/// Hysteresis of the angle of warp and weft in a triangle.
struct YarnFriction {
  detail::YarnFrame frame;
  std::array<std::int32_t, 3> v;  // of the frame
  double rest_angle, moment, yield;
};

template <class Friction>
auto angle_of(std::span<const Vec3> x, const Friction& friction) {
  if constexpr (std::is_same_v<Friction, YarnFriction>) {
    const detail::YarnAngle angle = detail::angle_of(friction.frame, x);
    return Angle<3>{angle.value, angle.gradient, angle.valid};
  } else {
    return angle_of(x, friction.v);
  }
}

template <class Friction>
class Sliders {
 public:
  static constexpr int arity = std::tuple_size_v<decltype(Friction::v)>;
  static constexpr const char* name = "friction";

  explicit Sliders(std::span<const Friction> frictions) {
    for (std::size_t i = 0; i < frictions.size(); ++i) {
      detail::require_number_of("moment", name, i, frictions[i].moment);
      detail::require_number_of("yield", name, i, frictions[i].yield, false);
      detail::require_number_of("size of rest_angle", name, i, std::abs(frictions[i].rest_angle));
      sliders_.push_back({frictions[i], frictions[i].rest_angle});
    }
  }

  std::size_t size() const { return sliders_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return sliders_[e].friction.v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(sliders_, order); }

  detail::ElementSample<arity> sample(std::size_t e, std::span<const Vec3> x) const {
    const auto& [friction, slip] = sliders_[e];
    detail::ElementSample<arity> s;
    const Angle<arity> angle = angle_of(x, friction);
    s.valid = angle.valid;
    if (!s.valid) return s;
    const double off = angle.value - slip, size = std::abs(off), y = friction.yield;
    s.energy =
        size <= y ? 0.5 * friction.moment / y * off * off : friction.moment * (size - 0.5 * y);
    s.moment = friction.moment * std::clamp(off / y, -1.0, 1.0);
    s.slope = size <= y ? friction.moment / y : 0.0;
    s.gradient = angle.gradient;
    // While it slips, the slope is zero, and only the moment times the second derivative of the
    // angle remains. That derivative is at most about twice the product of the gradients.
    s.bound = 2.0 * std::abs(s.moment);
    for (int k = 0; k < arity; ++k) s.weight[k] = s.gradient[k].norm();
    s.plane.setZero();
    return s;
  }

  void slide(std::span<const Vec3> x) {
    for (auto& [friction, slip] : sliders_) {
      const Angle<arity> angle = angle_of(x, friction);
      if (!angle.valid) continue;
      slip = angle.value - std::clamp(angle.value - slip, -friction.yield, friction.yield);
    }
  }

  void save(std::vector<double>& memory) const {
    for (const Slider& slider : sliders_) memory.push_back(slider.slip);
  }

  std::span<const double> restore(std::span<const double> memory) {
    detail::require_memory(name, memory.size(), sliders_.size());
    for (std::size_t i = 0; i < sliders_.size(); ++i) sliders_[i].slip = memory[i];
    return memory.subspan(sliders_.size());
  }

 private:
  struct Slider {
    Friction friction;
    double slip;  // rad, the angle at which it sticks
  };
  std::vector<Slider> sliders_;
};

template <class Friction>
class FrictionForce final : public detail::ElementForce<Sliders<Friction>> {
 public:
  using detail::ElementForce<Sliders<Friction>>::ElementForce;
  void accept(const ForceState& state) override { this->kind_.slide(state.x); }
  void save_memory(std::vector<double>& memory) const override { this->kind_.save(memory); }
  std::span<const double> restore_memory(std::span<const double> memory) override {
    return this->kind_.restore(memory);
  }
};

}  // namespace

std::unique_ptr<Force> make_hinge_friction(std::span<const HingeFriction> frictions,
                                           std::size_t particles) {
  return std::make_unique<FrictionForce<HingeFriction>>(Sliders<HingeFriction>(frictions),
                                                        particles);
}

std::unique_ptr<Force> make_corner_friction(std::span<const CornerFriction> frictions,
                                            std::size_t particles) {
  return std::make_unique<FrictionForce<CornerFriction>>(Sliders<CornerFriction>(frictions),
                                                         particles);
}

std::unique_ptr<Force> make_yarn_friction(std::span<const YarnTriangle> triangles,
                                          std::size_t particles) {
  std::vector<YarnFriction> frictions;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const YarnTriangle& t = triangles[i];
    const detail::YarnFrame frame = detail::frame_of(t, i);
    if (t.friction > 0.0)
      frictions.push_back(
          {frame, t.v, 0.5 * std::numbers::pi, t.friction * frame.area, detail::kYieldShear});
  }
  return std::make_unique<FrictionForce<YarnFriction>>(Sliders<YarnFriction>(frictions), particles);
}

void register_hysteresis(FabricLaws& laws) {
  laws.forces.add(
      "hysteresis", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        if (!cloth.hinge_frictions.empty())
          forces.push_back(make_hinge_friction(cloth.hinge_frictions, cloth.mass.size()));
        if (!cloth.curvature_frictions.empty())
          forces.push_back(
              make_curvature_friction(cloth.hinges, cloth.curvature_frictions, cloth.mass.size()));
        if (!cloth.corner_frictions.empty())
          forces.push_back(make_corner_friction(cloth.corner_frictions, cloth.mass.size()));
        if (std::any_of(cloth.yarns.begin(), cloth.yarns.end(),
                        [](const YarnTriangle& t) { return t.friction > 0.0; }))
          forces.push_back(make_yarn_friction(cloth.yarns, cloth.mass.size()));
        return forces;
      },
      {.promise = "minus the gradient of its energy within a step; has a memory",
       .source = "Kawabata, KES-F; Zhong, Wang, 1998; Ji et al., 2006; Zhang et al., 2012"});
}

}  // namespace selvedge
