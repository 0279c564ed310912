// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/integrator.h>
#include <selvedge/scene/scene.h>

#include <string>
#include <vector>

namespace selvedge {

/// The cloth of a scene as an oscillator with springs and hinges only. Handles hold the particles
/// that they hold at the start. There is no gravity, air, contact or strain limit.
struct StabilitySubject {
  ClothMesh cloth;
  std::vector<double> inv_mass;  ///< 1/kg; 0 for held particles
  std::vector<Vec3> kick;        ///< m/s; velocities that excite every mode slightly
  Vec3 gravity;                  ///< m/s²; for trials that swing

  /// `stiffness`: of the stiffest spring, N/m; the others scale in proportion; 0 keeps the scene's.
  /// `mass_ratio`: mass of the first free particle over that of the others. `damping`: of all
  /// springs, s; a negative value keeps the scene's.
  StabilitySubject(const Scene& scene, double stiffness, double mass_ratio, double damping);
};

/// Result of a trial at one step length.
struct StabilityTrial {
  bool stable = false;
  double energy_ratio = 0.0;  ///< energy at the end over that of the kick or of the fall
};

struct StabilityConfig {
  int steps = 2000;         ///< most steps of a trial
  double seconds = 10.0;    ///< most simulated seconds; the smaller limit ends the trial
  double growth = 10.0;     ///< largest allowed growth factor of the kick's energy
  double precision = 0.01;  ///< relative precision of the largest stable step
  double longest = 1.0;     ///< s; longest step length to test
  /// Name in strain_limiters(): the cloth swings under gravity with that limiter ("none": without
  /// one). Its kinetic and elastic energy may reach `growth` times the energy gained by falling
  /// through its own diagonal. Empty: the cloth is kicked and gravity is off.
  std::string limiter;
  int max_sweeps = 50;  ///< of the limiter in a step
};

/// Runs one trial: the cloth is kicked and left alone, or swings.
StabilityTrial try_step_length(const std::string& integrator, const StabilitySubject& subject,
                               double h, const StabilityConfig& config);

struct StabilityRow {
  std::string integrator;
  double stiffness = 0.0, mass_ratio = 1.0, damping = 0.0;
  bool any_step = false;      ///< the method promises stability at any step
  double bound = 0.0;         ///< s; enforced limit, by Gershgorin; 0: no step stays stable
  double predicted = 0.0;     ///< s; from the largest eigenvalue by power iteration
  double measured = 0.0;      ///< s; largest stable step; `longest` if every step is stable
  double energy_ratio = 0.0;  ///< of the trial at that step
};

/// Finds the largest stable step by bisection.
StabilityRow largest_stable_step(const std::string& integrator, const StabilitySubject& subject,
                                 const StabilityConfig& config);

/// Largest omega² and damping rate of the cloth at rest, by power iteration on its forces
/// [GolubVanLoan2013, section 7.3].
ModeBound fastest_mode(const StabilitySubject& subject);

/// Verdict on one square of the map.
enum class StabilityVerdict {
  stable,
  unstable,
  refused,  ///< the trial was stable, but the step exceeds the bound that the program enforces
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

/// Draws the maps into one SVG picture.
std::string draw_maps(const std::vector<StabilityMap>& maps);

}  // namespace selvedge
