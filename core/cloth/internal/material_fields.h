// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/fields.h>
#include <selvedge/core/cloth/fabric.h>
#include <selvedge/core/cloth/fabric_laws.h>

namespace selvedge {
namespace detail {

/// Keys of the laws of a kind: the names of all, with half a sentence on each.
Key stretch_law_key();
Key shear_law_key();
Key bending_law_key();

inline Key tension_points(const char* text) {
  return {
      .text = text, .axes = {{{"strain", "1", 100}, {"force", "N/m", 1e12}}}, .completed = false};
}
inline Key bending_points(const char* text) {
  return {.text = text,
          .axes = {{{"curvature", "1/m", 1e9}, {"moment", "N", 1e9}}},
          .completed = false};
}

}  // namespace detail

/// The constants of a material, as the keys of scene files.
template <>
struct Fields<Material> {
  static constexpr const char* kText = "What a fabric is made of, independent of the mesh.";
  static void visit(auto&& visitor) {
    using T = Material;
    visitor("density", &T::density,
            Key{.unit = "kg/m²", .range = {1e-9, 1000}, .text = "Mass per area"});
    visitor("stretch_stiffness", &T::stretch_stiffness,
            Key{.unit = "N/m",
                .range = {1e-12, 1e9},
                .text = "Force per width and strain along warp and weft"});
    visitor("shear_stiffness", &T::shear_stiffness,
            Key{.unit = "N/m", .range = {0, 1e9}, .text = "Force per width and shear angle"});
    visitor("bending_stiffness", &T::bending_stiffness,
            Key{.unit = "N·m", .range = {0, 1e6}, .text = "Plate rigidity"});
    visitor("stretch_weft", &T::stretch_weft,
            Key{.unit = "N/m",
                .range = {1e-12, 1e9},
                .text = "stretch_stiffness along weft, y of a grid or of a flat pattern; that "
                        "along warp, x, is then the key above. If left out, both are alike"});
    visitor(
        "bending_weft", &T::bending_weft,
        Key{.unit = "N·m", .range = {0, 1e6}, .text = "bending_stiffness along weft, likewise"});
    visitor("poisson", &T::poisson,
            Key{.unit = "1",
                .range = {-1, 0.999, true, true},
                .text = "Poisson's ratio C12/sqrt(C11 C22) of the stretch laws "
                        "st_venant_kirchhoff and corotated; if left out, C12 equals the shear "
                        "stiffness, as in a net of springs"});
    visitor("spring_damping", &T::spring_damping,
            Key{.unit = "s", .range = {0, 100}, .text = "Damping of springs per their stiffness"});
    visitor("bending_damping", &T::bending_damping,
            Key{.unit = "s", .range = {0, 100}, .text = "Damping of bending per its stiffness"});
    visitor("strain_limit", &T::strain_limit,
            Key{.unit = "1",
                .range = {1e-9, 100},
                .text = "Largest stretch of a spring, as a part of its rest length"});
    visitor("friction", &T::friction,
            Key{.unit = "1", .range = {0, 1e6}, .text = "Coulomb coefficient of cloth on cloth"});
    visitor("stretch_law", &T::stretch_law, detail::stretch_law_key());
    visitor("shear_law", &T::shear_law, detail::shear_law_key());
    visitor("bending_law", &T::bending_law, detail::bending_law_key());
    for (const LawConstant& constant : fabric_laws().constants)
      visitor(constant.name.c_str(), constant, constant.key);
    visitor("kawabata_lt", &T::kawabata_lt,
            Key{.unit = "1",
                .range = {0.5, 1, true, true},
                .text = "Linearity LT of the tension test"});
    visitor("kawabata_strain", &T::kawabata_strain,
            Key{.unit = "1",
                .range = {1e-6, 100},
                .text = "Strain EMT at the end of the tension test"});
    visitor("kawabata_rt", &T::kawabata_rt,
            Key{.unit = "1",
                .range = {.least = 1e-6, .most = 1, .firm = true},
                .text = "Resilience RT of the tension test: the share of its work that comes "
                        "back"});
    visitor("shear_friction", &T::shear_friction,
            Key{.unit = "N/m",
                .range = {0, 1e6},
                .text = "Half the width of the loop of a shear test, force per width; only with "
                        "shear_law twisting or angle"});
    visitor("bending_friction", &T::bending_friction,
            Key{.unit = "N",
                .range = {0, 1e6},
                .text = "Half the width of the loop of a bending test, moment per width; on grids "
                        "of cells, on other meshes with the shape operator"});
    visitor("tension_curve", &T::tension_curve,
            detail::tension_points("Points of the tension test for stretch_law measured; "
                                   "stretch_stiffness is its slope at rest"));
    visitor("tension_curve_weft", &T::tension_weft,
            detail::tension_points(
                "That of the weft, if it differs; stretch_weft is its slope at rest"));
    visitor("shear_curve", &T::shear_curve,
            Key{.text = "Points of the shear test for shear_law angle, the same for both "
                        "directions of shear; shear_stiffness is its slope at rest",
                .axes = {{{"angle", "rad", 1.57}, {"force", "N/m", 1e12}}},
                .completed = false});
    visitor("bending_curve", &T::bending_curve,
            detail::bending_points("Points of the bending test, the same for both faces, for "
                                   "bending_law shape_operator, on grids of cells also hinge and "
                                   "chord; bending_stiffness is its slope at rest"));
    visitor("bending_curve_weft", &T::bending_curve_weft,
            detail::bending_points(
                "That of the weft, if it differs; bending_weft is its slope at rest"));
  }
};

}  // namespace selvedge
