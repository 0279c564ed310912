// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/extreme_run.h>

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// How a run of an extreme scene may end. Not a number in the output, a hang, or cloth that passes
/// through something without a word is `failed`, and so is a number that is wrong.
enum class Answer {
  correct,   ///< with the number that says so
  refused,   ///< with the reason
  degraded,  ///< it ran, and says itself what it could not keep
  failed
};
const char* to_string(Answer answer);

struct CaseResult {
  Answer answer = Answer::failed;
  std::string note;           ///< the number, the reason, or the flag
  double max_stretch = 0.0;   ///< the worst of all runs of the case, as are the next
  std::size_t crossings = 0;  ///< intersections of the worst frame, and collisions on paths
  double worst_speed = 0.0;   ///< m/s
  double energy_ratio = std::numeric_limits<double>::quiet_NaN();
  /// J of kinetic energy that a stage of the step has given in all, by its ledger: of the run with
  /// the largest. Below 0: taken.
  std::map<std::string, double> given;
};

struct TrialConfig {
  std::filesystem::path data;  ///< the folder of the scenes, data/extreme
  std::string response;        ///< "": the default
  std::filesystem::path out;   ///< frames of each run go into a folder in it; "": nowhere
};

/// What a case may do: run scenes, whose measures it collects.
class Trial {
 public:
  explicit Trial(TrialConfig config) : config_(std::move(config)) {}

  ExtremeRun run(const std::string& name, const std::vector<Override>& overrides = {});
  ExtremeRun run(const Scene& scene);
  /// The scene NAME.json of the folder. Throws std::invalid_argument if there is none.
  Scene read(const std::string& name) const;

  /// The result with the measures of all runs so far.
  CaseResult answer(Answer answer, const std::string& note) const;
  /// `right` says whether the cloth did what it should, `number` shows it. Refused, stopped,
  /// crossed or over-stretched runs come first, in this order.
  CaseResult settle(const ExtremeRun& run, bool right, const std::string& number) const;

 private:
  void collect(const ExtremeRun& run);
  ExtremeConfig run_config(const std::string& name, const std::vector<Override>& overrides) const;

  std::filesystem::path file(const std::string& name) const;

  TrialConfig config_;
  CaseResult measures_;
};

struct ExtremeCase {
  std::string name;  ///< that of its scene, or of the first
  Answer best;       ///< what the default response gives
  bool quick;        ///< short enough for the tests
  std::function<CaseResult(Trial&)> run;
};

/// S1 to S24 of the project's list of extreme cases, and more; in the order of their names.
std::vector<ExtremeCase> extreme_cases();

/// Its two halves: what is about numbers and files, and what is about contact.
std::vector<ExtremeCase> extreme_number_cases();
std::vector<ExtremeCase> extreme_contact_cases();

}  // namespace selvedge
