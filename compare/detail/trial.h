// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/internal/stability.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace selvedge::detail {

/// One run of a scene. The exact checker, which shares no code with the simulator,
/// judges every frame and every path between two accepted states.
struct JudgedRun {
  Scene scene;
  std::string refused;                ///< why the run did not start; "" if it did
  std::string stopped;                ///< why the run stopped; "" if it finished
  bool in_time = true;                ///< false: the limit of processor time stopped it
  std::vector<std::string> warnings;  ///< of the meshes
  RunResult result;
  ClothMesh cloth;  ///< at the start
  std::vector<std::int32_t> piece_begin;
  std::vector<double> times;                      ///< s, of the frames, the start included
  std::vector<std::vector<Vec3>> frames, bodies;  ///< m
  std::vector<Vec3> x, v;                         ///< at the end
  double time = 0.0;                              ///< s, at the end
  bool finite = true;                             ///< every position and velocity is finite
  std::size_t intersections = 0;                  ///< worst frame; self, body and inside
  std::size_t path_collisions = 0;                ///< sum over all paths
  double worst_speed = 0.0;                       ///< m/s, in any accepted state
  double rms_speed = 0.0;                         ///< m/s, at the end
  /// Largest mechanical energy over that at the start; the lowest position of the run is the zero
  /// level. NaN if external motion drives the cloth or nothing ran. Excludes bending energy.
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();

  /// Vertices of a piece in a frame.
  std::span<const Vec3> piece(std::size_t frame, std::size_t piece) const;
};

struct JudgedRunConfig {
  std::vector<Override> overrides;
  TriedMethod method;
  bool judge_paths = true;
  std::filesystem::path out;  ///< folder of the frames for pictures; "": none
  double limit = 600.0;       ///< s of processor time; the run stops after it and reports it
};

/// Reads a scene file and runs it. Errors of a scene never throw.
JudgedRun run_judged(const std::filesystem::path& file, const JudgedRunConfig& config,
                     const Methods& methods);
/// The same for a scene made in code.
JudgedRun run_judged(const Scene& scene, const JudgedRunConfig& config, const Methods& methods);

/// How a scene, or a case of several, ended in this process.
struct CaseResult {
  Answer answer = Answer::failed;
  std::string note;  ///< the number, the reason or the flag
  std::optional<SceneMeasures> measures;
};

/// The result that the process of a case has sent; empty for any other text.
std::optional<CaseResult> read_case_result(const std::string& text);

struct TrialConfig {
  std::filesystem::path data;  ///< the folder of the scenes
  TriedMethod method;
  std::filesystem::path out;  ///< each run writes its frames into a subfolder; "": no output
  double limit = JudgedRunConfig{}.limit;  ///< s of processor time of each run
};

/// Runs scenes, collects their measures and settles how they end.
class Trial {
 public:
  explicit Trial(TrialConfig config, const Methods& methods = {})
      : config_(std::move(config)), methods_(methods) {}

  JudgedRun run(const std::string& name, const std::vector<Override>& overrides = {});
  JudgedRun run(const Scene& scene);
  /// The scene NAME.json of the folder. Throws std::invalid_argument if it does not exist.
  Scene read(const std::string& name) const;

  /// The result with the measures of all runs so far.
  CaseResult answer(Answer answer, const std::string& note) const;
  /// The scene NAME.json alone.
  CaseResult settle(const std::string& name);
  /// `right` states whether the cloth behaved as expected, and `number` shows it. Refused, stopped,
  /// crossed and over-stretched runs take precedence, in this order.
  CaseResult settle(const JudgedRun& run, bool right, const std::string& number) const;

 private:
  void collect(const JudgedRun& run);
  JudgedRunConfig run_config(const std::string& name, const std::vector<Override>& overrides) const;

  std::filesystem::path file(const std::string& name) const;

  TrialConfig config_;
  Methods methods_;
  SceneMeasures measures_;
};

}  // namespace selvedge::detail
