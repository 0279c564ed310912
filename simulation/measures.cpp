// SPDX-License-Identifier: MIT
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace selvedge {

std::optional<DrapeSupport> drape_support(const Scene& scene) {
  constexpr double upright = 1e-9;
  for (const BodySpec& body : scene.bodies) {
    const auto* shape = std::get_if<BodyShape>(&body.shape);
    const auto* cylinder = shape != nullptr ? std::get_if<Cylinder>(&shape->shape) : nullptr;
    if (cylinder == nullptr || !body.motion.empty()) continue;
    const Vec3 axis = body.placement.rotation * Vec3::UnitZ();
    if (axis.head<2>().norm() > upright) continue;
    return DrapeSupport{body.placement.translation, cylinder->radius};
  }
  return std::nullopt;
}

std::optional<DrapeMeasures> measure_drape(const BuiltScene& built, std::span<const Vec3> x,
                                           const DrapeSupport& support) {
  const std::vector<Triangle>& triangles = built.cloth.surface.triangles;
  DrapeMeasures d;
  d.support = std::numbers::pi * support.radius * support.radius;
  d.specimen = surface_area(built.rest.vertices, built.rest.triangles);
  if (!(d.specimen > d.support)) return std::nullopt;
  d.shadow = projected_area(x, triangles);
  d.drape_coefficient = drape_coefficient(d.shadow, d.specimen, d.support);
  try {
    d.rim = rim_profile(x, triangles, {support.centre, RimConfig{}.samples});
  } catch (const std::invalid_argument&) {  // has slid off, or is no sheet
    return std::nullopt;
  }
  return d;
}

std::map<std::string, double> energies(const Scene& scene, const BuiltScene& built,
                                       const ForceState& state, const ForceLawRegistry& laws) {
  std::map<std::string, double> joules = {
      {"kinetic", 0.0}, {"gravity", 0.0}, {"stretch_and_shear", 0.0}};
  for (std::size_t i = 0; i < state.x.size(); ++i) {
    joules["kinetic"] += 0.5 * state.mass[i] * state.v[i].squaredNorm();
    joules["gravity"] -= state.mass[i] * scene.gravity.dot(state.x[i]);
  }
  for (const auto* law : laws.in_order()) {
    const std::string part(law->traits().energy);
    if (part.empty()) continue;
    for (const auto& force : make_forces_of(*law, built.cloth, scene.force_laws))
      joules[part] += force->energy(state);
  }
  if (!scene.seams.empty()) joules["seams"] = 0.0;  // also if all of them are merged
  if (!scene.seams.empty())
    for (const auto& force : make_seams(scene, built)) joules["seams"] += force->energy(state);
  return joules;
}

std::map<std::string, double> final_measures(const Scene& scene, const BuiltScene& built,
                                             const ForceState& state,
                                             const ForceLawRegistry& laws) {
  std::map<std::string, double> all;
  const StrainSummary sheet =
      summary_of(triangle_strains(state.x, built.cloth.surface.triangles, built.rest));
  const StrainSummary springs = spring_strains(built.cloth.springs, state.x);
  all = {{"strain_max", sheet.max},           {"strain_min", sheet.min},
         {"strain_rms", sheet.rms},           {"spring_strain_max", springs.max},
         {"spring_strain_min", springs.min},  {"spring_strain_rms", springs.rms},
         {"spring_strain_mean", springs.mean}};
  for (const auto& [part, joules] : energies(scene, built, state, laws))
    all["energy_" + part + "_J"] = joules;
  const auto support = drape_support(scene);
  if (!support || scene.cloths.size() != 1) return all;
  if (const auto drape = measure_drape(built, state.x, *support)) {
    all["drape_coefficient"] = drape->drape_coefficient;
    all["folds"] = drape->rim.folds;
    all["fold_maxima"] = drape->rim.maxima;
  }
  return all;
}

}  // namespace selvedge
