// SPDX-License-Identifier: MIT
//
// Stability: largest stable steps of the integrators, and whole scenes at the limits.
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/scene.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
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
  /// A step has no finite end or cannot be made, so that the program divides it.
  bool rejected = false;
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
  /// The method rejects longer steps, such as those that need too many inner steps, and gains no
  /// energy before: the bound holds.
  bool rejects_longer = false;
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
  refused,  ///< stable, but longer than the program takes in one step: it divides it
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

// -- extreme cases --------------------------------------------------------------------------------

/// Outcome of an extreme case. A NaN in the output, a hang, an unreported passage of cloth through
/// a surface, or a wrong number counts as `failed`.
enum class Answer {
  correct,   ///< the note gives the number that shows it
  refused,   ///< the note gives the reason
  degraded,  ///< the run finished and reports the limits that it could not keep
  failed
};
/// "correct", "refused", "degraded", "FAILED".
const char* to_string(Answer answer);

/// The worst numbers of all runs of a case.
struct ExtremeMeasures {
  double max_stretch = 0.0;
  std::size_t crossings = 0;  ///< intersections in the worst frame, and collisions on paths
  double worst_speed = 0.0;   ///< m/s
  /// Largest mechanical energy over that at the start; NaN where it is unknown.
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();
  /// J; total kinetic energy that a stage of the step added, by its ledger, in the run with the
  /// largest value. Negative values mean energy removed.
  std::map<std::string, double> given;
};

/// A method with its default options that every scene of the extreme cases takes instead of its
/// own.
struct ExtremeMethod {
  std::string key;   ///< "contact.response", "solver.integrator" or "solver.strain_limiter"
  std::string name;  ///< "": every scene keeps its own
};

struct ExtremeResult {
  std::string name;    ///< of the case
  std::string method;  ///< that every scene took; "" if each kept its own
  Answer answer = Answer::failed;
  std::optional<Answer> expected;           ///< only if each scene kept its own methods
  std::string note;                         ///< the number, the reason or the flag
  std::optional<ExtremeMeasures> measures;  ///< nullopt: the process ended without a result
  double wall_s = 0.0;                      ///< s

  bool is_as_expected() const { return !expected || *expected == answer; }
};

struct ExtremeCasesConfig {
  std::filesystem::path folder;    ///< of the scenes: data/extreme
  std::vector<std::string> cases;  ///< names of cases, or how they begin; empty: all
  ExtremeMethod method;
  std::filesystem::path out;  ///< each run writes its frames into a subfolder; "": no output
  int threads = 0;            ///< 0: no limit
  double wall_limit = 120.0;  ///< s; a case that takes longer has failed
};

/// The cases whose names begin with one of `beginnings`, by name; all if it is empty. Throws
/// std::invalid_argument for a beginning without a case.
std::vector<std::string> extreme_case_names(const std::vector<std::string>& beginnings = {});

/// Runs the extreme cases: scenes of data/extreme with an expected answer. The exact check, which
/// shares no code with the simulator, examines every frame and every path between two accepted
/// states. Each case runs in a copy of this process (fork), so that a crash or a hang is a result;
/// call it from a process with one thread. Calls `report`, which may be empty, after each case.
/// Throws std::invalid_argument if the folder is not that of the extreme cases, and for a beginning
/// without a case.
std::vector<ExtremeResult> run_extreme_cases(
    const ExtremeCasesConfig& config, const std::function<void(const ExtremeResult&)>& report = {});

}  // namespace selvedge
