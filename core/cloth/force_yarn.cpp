// SPDX-License-Identifier: MIT
//
// Shear of woven cloth on any triangles: the angle between warp and weft, from the deformation
// gradient F of each triangle. KES-F1 reads the shear force per width over the angle by which the
// yarns leave the right angle [Kawabata1980]; per area this is the moment τ(φ) of the energy
//   E = A ∫ τ dφ,  φ = angle(F e_warp, F e_weft) - π/2,  f = -A τ(φ) ∂φ/∂x.
// τ is G φ or a measured curve with this slope at rest. Stretch of the yarns of the same triangle
// is in force_spring_curve.cpp, the loop ±HG in force_friction.cpp. As in a trellis, warp and weft
// are independent: C12 = 0.
//
// The second derivative of φ is dropped from the Jacobian. Its part out of the plane is τ cos/sin
// of the angle, which is negative, because τ and the cosine have opposite signs.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/yarn_triangle.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <numbers>

namespace selvedge {
namespace {

class YarnAngles {
 public:
  static constexpr int arity = 3;
  static constexpr const char* name = "yarn triangle";

  YarnAngles(std::span<const YarnTriangle> triangles, std::span<const SpringCurve> curves) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const YarnTriangle& t = triangles[i];
      detail::require_number_of("shear", name, i, t.shear);
      detail::require_number_of("damping", name, i, t.damping);
      if (t.shear <= 0.0) continue;
      MonotoneCurve curve;
      if (t.shear_curve >= 0) {
        detail::require_curve(name, i, t.shear_curve, curves);
        curve = curves[t.shear_curve].measured;
      }
      elements_.push_back({detail::frame_of(t, i), t.shear, t.damping, std::move(curve)});
    }
  }

  std::size_t size() const { return elements_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return elements_[e].frame.v[k]; }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(elements_, order); }

  detail::ElementSample<3> sample(std::size_t e, std::span<const Vec3> x) const {
    const Element& element = elements_[e];
    detail::ElementSample<3> s;
    const detail::YarnAngle angle = detail::angle_of(element.frame, x);
    const double shear = angle.value - 0.5 * std::numbers::pi;
    const double stiffness = element.stiffness * element.frame.area;
    s.valid = angle.valid;
    set_moment(element.curve, stiffness, shear, s);
    s.damping = element.damping * stiffness;
    if (!s.valid) return s;
    s.gradient = angle.gradient;
    const double tangent = std::abs(1.0 / elementary::tan(angle.value));
    s.bound = std::abs(s.moment) * (2.0 + 2.0 * tangent);
    s.weight = angle.turn;
    s.plane.setZero();
    return s;
  }

 private:
  struct Element {
    detail::YarnFrame frame;
    double stiffness;  // N/m per rad
    double damping;    // s
    MonotoneCurve curve;
  };

  static void set_moment(const MonotoneCurve& curve, double stiffness, double shear,
                         detail::ElementSample<3>& s) {
    if (curve.empty()) {
      s.energy = 0.5 * stiffness * shear * shear;
      s.moment = stiffness * shear;
      s.slope = stiffness;
      return;
    }
    const double scale = stiffness / curve.slope_at_rest();
    s.energy = scale * curve.work(shear);
    s.moment = scale * curve.value(shear);
    s.slope = scale * curve.slope(shear);
  }

  std::vector<Element> elements_;
};

}  // namespace

std::unique_ptr<Force> make_yarn_shear(std::span<const YarnTriangle> triangles,
                                       std::span<const SpringCurve> curves, std::size_t particles) {
  return std::make_unique<detail::ElementForce<YarnAngles>>(YarnAngles(triangles, curves),
                                                            particles);
}

void register_yarns(FabricLaws& laws) {
  laws.shear.push_back(
      {.name = "angle",
       .text = "the angle between warp and weft of each triangle, which then also carries stretch "
               "along both, on any mesh that is flat at rest, garments included",
       .reads = {"shear_friction", "shear_curve"},
       .by_triangles = true});
  laws.forces.add("yarns", {},
                  [](const MethodOptions&, const ClothMesh& cloth) {
                    ForceList forces;
                    if (cloth.yarns.empty()) return forces;
                    forces = make_yarn_stretch(cloth.yarns, cloth.curves, cloth.mass.size());
                    forces.push_back(make_yarn_shear(cloth.yarns, cloth.curves, cloth.mass.size()));
                    return forces;
                  },
                  {.promise = "shear by the angle of warp and weft, stretch along both, on any "
                              "triangles; minus the gradient of its energy",
                   .source = "Kawabata, KES-F1; Zhong, Wang, 1998; Ji et al., 2006",
                   .energy = "stretch_and_shear"});
}

}  // namespace selvedge
