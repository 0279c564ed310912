// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/scene/scene.h>

#include <string>
#include <vector>

namespace selvedge {

/// The cloth of a scene as an oscillator: nothing but its springs and hinges, held where handles
/// hold it at the start, no gravity, no air, no contact, no strain limit.
struct StabilitySubject {
  ClothMesh cloth;
  std::vector<double> inv_mass;  ///< 1/kg, 0: held
  std::vector<Vec3> kick;        ///< m/s, velocities that stir every mode a little
  Vec3 gravity;                  ///< m/s², for trials that swing

  /// `stiffness`: N/m, of the stiffest spring, the others in proportion; 0: as in the scene.
  /// `mass_ratio`: of the first particle that is free to the others'. `damping`: s, of all springs;
  /// negative: as in the scene.
  StabilitySubject(const Scene& scene, double stiffness, double mass_ratio, double damping);
};

/// How a trial at one step length went.
struct StabilityTrial {
  bool stable = false;
  double energy_ratio = 0.0;  ///< of the energy at the end to that of the kick or of the fall
};

struct StabilityConfig {
  int steps = 2000;         ///< at most so many steps of a trial
  double seconds = 10.0;    ///< or so many simulated seconds, whichever ends first
  double growth = 10.0;     ///< the energy of the kick may grow by this factor
  double precision = 0.01;  ///< relative, of the largest stable step
  double longest = 1.0;     ///< s, steps that are tried at most
  /// Name in strain_limiters(): the cloth swings under gravity with that limiter, "none" without
  /// one, and its kinetic and elastic energy may be `growth` times what it would gain by falling
  /// through its own diagonal. Empty: kicked and left alone.
  std::string limiter;
  int max_sweeps = 50;  ///< of the limiter in a step
};

/// One trial: kicked, then left alone, or swinging.
StabilityTrial try_step_length(const std::string& integrator, const StabilitySubject& subject,
                               double h, const StabilityConfig& config);

struct StabilityRow {
  std::string integrator;
  double stiffness = 0.0, mass_ratio = 1.0, damping = 0.0;
  bool any_step = false;      ///< the method promises stability at any step
  double bound = 0.0;         ///< s, that the program keeps: by Gershgorin; 0: none holds for ever
  double predicted = 0.0;     ///< s, by the largest eigenvalue, from power iteration
  double measured = 0.0;      ///< s, largest step whose trial was stable; longest: at any
  double energy_ratio = 0.0;  ///< of the trial at that step
};

/// Bisects for the largest stable step.
StabilityRow largest_stable_step(const std::string& integrator, const StabilitySubject& subject,
                                 const StabilityConfig& config);

/// Largest omega² and damping rate of the cloth at rest, by power iteration on its forces
/// [GolubVanLoan2013, section 7.3].
ModeBound fastest_mode(const StabilitySubject& subject);

/// A square of the map.
enum class StabilityVerdict {
  stable,
  unstable,
  refused,  ///< trials were stable, but beyond the bound the program keeps
};
struct StabilityMap {
  std::string integrator;
  std::vector<double> stiffness, step;    ///< N/m, s; ascending
  std::vector<StabilityVerdict> verdict;  ///< step by step within each stiffness
  std::vector<double> bound;              ///< s, for each stiffness
};
StabilityMap map_stability(const std::string& integrator, const Scene& scene,
                           const std::vector<double>& stiffness, const std::vector<double>& step,
                           const StabilityConfig& config);

/// The maps as one drawing, SVG.
std::string draw_maps(const std::vector<StabilityMap>& maps);

}  // namespace selvedge
