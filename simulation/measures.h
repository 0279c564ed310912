// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/measure.h>
#include <selvedge/scene/build.h>

#include <map>
#include <optional>
#include <span>
#include <string>

namespace selvedge {

/// The support of a cloth in Cusick's drape test.
struct DrapeSupport {
  Vec3 centre = Vec3::Zero();  ///< m, seen from above
  double radius = 0.09;        ///< m, > 0
};
/// The first body that is an upright cylinder at rest; nullopt if there is none.
std::optional<DrapeSupport> drape_support(const Scene& scene);

/// Results of Cusick's drape test.
struct DrapeMeasures {
  double shadow = 0.0, specimen = 0.0, support = 0.0;  ///< areas, m²
  double drape_coefficient = 0.0;                      ///< %
  RimProfile rim;
};
/// nullopt if the cloth's rim does not go around the support or is smaller than it.
std::optional<DrapeMeasures> measure_drape(const BuiltScene& built, std::span<const Vec3> x,
                                           const DrapeSupport& support);

/// Energies of a state in joules: "kinetic", "gravity" (0 at the origin), "stretch_and_shear" and,
/// if the cloth has them, "bending", "buckling", "twisting", "seams".
std::map<std::string, double> energies(const Scene& scene, const BuiltScene& built,
                                       const ForceState& state);

/// Measures of the last state of a run, by their names in result.json: strains, energies, drape.
std::map<std::string, double> final_measures(const Scene& scene, const BuiltScene& built,
                                             const ForceState& state);

}  // namespace selvedge
