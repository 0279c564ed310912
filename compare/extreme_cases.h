// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/extreme_run.h>

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// Outcome of a run of an extreme scene. A NaN in the output, a hang, an unreported passage of
/// cloth through a surface, or a wrong number counts as `failed`.
enum class Answer {
  correct,   ///< the note gives the number that shows it
  refused,   ///< the note gives the reason
  degraded,  ///< the run finished and reports the limits that it could not keep
  failed
};
const char* to_string(Answer answer);

struct CaseResult {
  Answer answer = Answer::failed;
  std::string note;           ///< the number, the reason or the flag
  double max_stretch = 0.0;   ///< this and the next two: the worst over all runs of the case
  std::size_t crossings = 0;  ///< intersections in the worst frame, and collisions on paths
  double worst_speed = 0.0;   ///< m/s
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();
  /// J; total kinetic energy that a stage of the step added, by its ledger, in the run with the
  /// largest value. Negative values mean energy removed.
  std::map<std::string, double> given;
};

struct TrialConfig {
  std::filesystem::path data;  ///< the folder of the scenes, data/extreme
  std::string response;        ///< "": the default
  std::filesystem::path out;   ///< each run writes its frames into a subfolder; "": no output
};

/// Interface of a case: it runs scenes and collects their measures.
class Trial {
 public:
  explicit Trial(TrialConfig config) : config_(std::move(config)) {}

  ExtremeRun run(const std::string& name, const std::vector<Override>& overrides = {});
  ExtremeRun run(const Scene& scene);
  /// The scene NAME.json of the folder. Throws std::invalid_argument if it does not exist.
  Scene read(const std::string& name) const;

  /// The result with the measures of all runs so far.
  CaseResult answer(Answer answer, const std::string& note) const;
  /// `right` states whether the cloth behaved as expected, and `number` shows it. Refused, stopped,
  /// crossed and over-stretched runs take precedence, in this order.
  CaseResult settle(const ExtremeRun& run, bool right, const std::string& number) const;

 private:
  void collect(const ExtremeRun& run);
  ExtremeConfig run_config(const std::string& name, const std::vector<Override>& overrides) const;

  std::filesystem::path file(const std::string& name) const;

  TrialConfig config_;
  CaseResult measures_;
};

struct ExtremeCase {
  std::string name;  ///< of its scene, or of the first one
  Answer best;       ///< the expected answer of the default response
  bool quick;        ///< short enough for the tests
  std::function<CaseResult(Trial&)> run;
};

/// S1 to S24 of the project's list of extreme cases, and further cases, ordered by name.
std::vector<ExtremeCase> extreme_cases();

/// The two halves: numbers and files, and contact.
std::vector<ExtremeCase> extreme_number_cases();
std::vector<ExtremeCase> extreme_contact_cases();

}  // namespace selvedge
