// SPDX-License-Identifier: MIT
//
// Stability: largest stable steps of the integrators, and how whole scenes end.
#pragma once

#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/methods.h>
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

// -- scenes at the limits -------------------------------------------------------------------------

/// How a scene ends.
enum class Answer {
  correct,    ///< finished, without a crossing, and within its limits
  refused,    ///< the scene is rejected, or the run stopped; the note gives the reason
  degraded,   ///< the run finished and reports the limits that it could not keep
  failed,     ///< a NaN, a crash, a hang, or a crossing that the run does not report
  unfinished  ///< clean as far as the limit of processor time allowed
};
/// "correct", "refused", "degraded", "FAILED", "unfinished".
const char* to_string(Answer answer);

/// The worst numbers of a scene.
struct SceneMeasures {
  double max_stretch = 0.0;
  std::size_t crossings = 0;  ///< intersections in the worst frame, and collisions on paths
  double worst_speed = 0.0;   ///< m/s
  /// Largest mechanical energy over that at the start; NaN where it is unknown.
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();
  /// J; total kinetic energy that a stage of the step added, by its ledger, in the run with the
  /// largest value. Negative values mean energy removed.
  std::map<std::string, double> given;
};

/// A method with its default options that every scene takes instead of its own.
struct TriedMethod {
  std::string key;   ///< "contact.response", "solver.integrator" or "solver.strain_limiter"
  std::string name;  ///< "": every scene keeps its own
};

struct SettledScene {
  std::string name;    ///< of the file, without its ending
  std::string method;  ///< that every scene took; "" if each kept its own
  Answer answer = Answer::failed;
  std::string note;                       ///< a number, the reason or the flag
  std::optional<SceneMeasures> measures;  ///< nullopt: the process ended without a result
  double wall_s = 0.0;                    ///< s
};

struct SettleConfig {
  std::filesystem::path folder{};
  std::vector<std::string> scenes{};  ///< names, or how they begin; empty: all
  TriedMethod method{};
  std::filesystem::path out{};  ///< each run writes its frames into a subfolder; "": no output
  int threads = 0;              ///< 0: no limit
  /// s of processor time after which a scene ends unfinished, at the end of a step, or within a
  /// step after three times as long. One that stops computing hangs, and has failed.
  double limit = 120.0;
};

/// The scenes of a folder by name: its files *.json but *.schema.json, whose names begin with one
/// of `beginnings`, or all. Throws std::invalid_argument for a folder without scenes, and for a
/// beginning without a scene.
std::vector<std::string> scenes_in(const std::filesystem::path& folder,
                                   const std::vector<std::string>& beginnings = {});

/// Runs the scenes of a folder and settles how each ends. The exact check, which shares no code
/// with the simulator, examines every frame and every path between two accepted states. Each scene
/// runs in a copy of this process (fork), so that a crash or a hang is a result; call it from a
/// process with one thread. Calls `report`, which may be empty, after each scene. Throws as
/// scenes_in.
std::vector<SettledScene> settle_scenes(
    const SettleConfig& config, const Methods& methods,
    const std::function<void(const SettledScene&)>& report = {});

}  // namespace selvedge
