// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/measure.h>
#include <selvedge/scene/scene.h>

#include <map>
#include <optional>
#include <span>
#include <string>

namespace selvedge {

/// What a cloth drapes over in Cusick's test.
struct DrapeSupport {
  Vec3 centre = Vec3::Zero();  ///< m, seen from above
  double radius = 0.09;        ///< m, > 0
};
/// The first obstacle that is a cylinder on its end and does not move; none if there is none.
std::optional<DrapeSupport> drape_support(const Scene& scene);

/// A drape as Cusick's test sees it.
struct DrapeMeasures {
  double shadow = 0.0, specimen = 0.0, support = 0.0;  ///< areas, m²
  double drape_coefficient = 0.0;                      ///< %
  RimProfile rim;
};
/// None where the cloth's rim does not go around the support or is smaller than it.
std::optional<DrapeMeasures> measure_drape(const BuiltScene& built, std::span<const Vec3> x,
                                           const DrapeSupport& support);

/// Energies of a state in joules: "kinetic", "gravity" (0 at z = 0) and, of those the cloth has,
/// "stretch_and_shear", "bending", "buckling", "twisting", "seams".
std::map<std::string, double> energies(const Scene& scene, const BuiltScene& built,
                                       const ForceState& state);

/// Of the last state of a run, as result.json has it: strains, energies, the drape.
std::map<std::string, double> final_measures(const Scene& scene, const BuiltScene& built,
                                             const ForceState& state);

}  // namespace selvedge
