// SPDX-License-Identifier: MIT
#include <selvedge/core/force.h>

#include <iterator>

namespace selvedge {
namespace {

std::vector<Spring> springs_of_curve(const ClothMesh& cloth, std::int32_t curve) {
  if (cloth.curve_of_spring.empty()) return curve < 0 ? cloth.springs : std::vector<Spring>{};
  std::vector<Spring> springs;
  for (std::size_t s = 0; s < cloth.springs.size(); ++s)
    if (cloth.curve_of_spring[s] == curve) springs.push_back(cloth.springs[s]);
  return springs;
}

std::vector<Hinge> hinges_of_law(const ClothMesh& cloth, bool sine) {
  std::vector<Hinge> hinges;
  for (const Hinge& hinge : cloth.hinges)
    if (hinge.sine == sine) hinges.push_back(hinge);
  return hinges;
}

/// Hinges with couples make a plate; others stay by themselves.
void add_shape_operators(const ClothMesh& cloth, std::vector<std::unique_ptr<Force>>& forces) {
  std::vector<std::int32_t> number(cloth.hinges.size(), -1);
  for (const HingeCouple& c : cloth.couples) number[c.a] = number[c.b] = 0;
  std::vector<Hinge> coupled, single;
  for (std::size_t i = 0; i < cloth.hinges.size(); ++i) {
    if (number[i] == 0) {
      number[i] = static_cast<std::int32_t>(coupled.size());
      coupled.push_back(cloth.hinges[i]);
    } else if (!cloth.hinges[i].sine) {
      single.push_back(cloth.hinges[i]);
    }
  }
  std::vector<HingeCouple> couples = cloth.couples;
  for (HingeCouple& c : couples) c = {number[c.a], number[c.b], c.stiffness};
  forces.push_back(make_shape_operator_force(coupled, couples, cloth.mass.size()));
  if (!single.empty()) forces.push_back(make_bending_force(single, cloth.mass.size()));
}

}  // namespace

std::vector<std::unique_ptr<Force>> make_internal_forces(const ClothMesh& cloth) {
  const std::size_t n = cloth.mass.size();
  std::vector<std::unique_ptr<Force>> forces;
  const std::vector<Spring> hooke = springs_of_curve(cloth, -1);
  if (!hooke.empty()) forces.push_back(make_hooke_force(hooke, n));
  for (std::size_t c = 0; c < cloth.curves.size(); ++c)
    forces.push_back(make_curve_force(springs_of_curve(cloth, static_cast<std::int32_t>(c)),
                                      cloth.curves[c], n));
  const std::vector<Hinge> hinges = hinges_of_law(cloth, false), sine = hinges_of_law(cloth, true);
  if (!cloth.couples.empty())
    add_shape_operators(cloth, forces);
  else if (!hinges.empty())
    forces.push_back(make_bending_force(hinges, n));
  if (!sine.empty()) forces.push_back(make_bridson_force(sine, n));
  if (!cloth.links.empty()) forces.push_back(make_buckling_force(cloth.links, n));
  if (!cloth.twists.empty()) forces.push_back(make_twist_force(cloth.twists, n));
  if (!cloth.hinge_frictions.empty())
    forces.push_back(make_hinge_friction(cloth.hinge_frictions, n));
  if (!cloth.curvature_frictions.empty())
    forces.push_back(make_curvature_friction(cloth.hinges, cloth.curvature_frictions, n));
  if (!cloth.corner_frictions.empty())
    forces.push_back(make_corner_friction(cloth.corner_frictions, n));
  if (!cloth.hanging.empty()) forces.push_back(make_tie_force(cloth.hanging, n));
  if (!cloth.layers.empty()) forces.push_back(make_tie_force(cloth.layers, n));
  return forces;
}

}  // namespace selvedge
