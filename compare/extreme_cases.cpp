// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/extreme_cases.h>

#include <fmt/format.h>
#include <selvedge/core/base/internal/text.h>

#include <algorithm>
#include <cmath>

namespace selvedge {

const char* to_string(Answer answer) {
  switch (answer) {
    case Answer::correct:
      return "correct";
    case Answer::refused:
      return "refused";
    case Answer::degraded:
      return "degraded";
    case Answer::failed:
      break;
  }
  return "FAILED";
}

std::filesystem::path Trial::file(const std::string& name) const {
  return config_.data / (name + ".json");
}

Scene Trial::read(const std::string& name) const { return read_scene(file(name)); }

ExtremeConfig Trial::run_config(const std::string& name,
                                const std::vector<Override>& overrides) const {
  ExtremeConfig config;
  config.overrides = overrides;
  config.method = config_.method;
  if (!config_.out.empty()) config.out = config_.out / name;
  return config;
}

ExtremeRun Trial::run(const std::string& name, const std::vector<Override>& overrides) {
  ExtremeRun run = run_extreme(file(name), run_config(name, overrides));
  collect(run);
  return run;
}

ExtremeRun Trial::run(const Scene& scene) {
  ExtremeRun run = run_extreme(scene, run_config(scene.name, {}));
  collect(run);
  return run;
}

void Trial::collect(const ExtremeRun& run) {
  measures_.max_stretch = std::max(measures_.max_stretch, run.result.max_stretch);
  measures_.crossings = std::max(measures_.crossings, run.intersections + run.path_collisions);
  measures_.worst_speed = std::max(measures_.worst_speed, run.worst_speed);
  measures_.energy_ratio = std::fmax(measures_.energy_ratio, run.energy_ratio);
  for (const auto& [stage, figures] : run.result.ledger) {
    const auto found = figures.find("energy_kinetic_J");
    if (found == figures.end()) continue;  // the energy balance of the whole step
    double& most = measures_.given[stage];
    const double energy = found->second;
    if (std::abs(energy) > std::abs(most)) most = energy;
  }
}

CaseResult Trial::answer(Answer answer, const std::string& note) const {
  return {answer, note, measures_};
}

CaseResult Trial::settle(const ExtremeRun& run, bool right, const std::string& number) const {
  if (!run.finite) return answer(Answer::failed, run.stopped);
  if (!run.refused.empty()) return answer(Answer::refused, run.refused);
  const std::size_t crossings = run.intersections + run.path_collisions;
  if (crossings > 0 && run.result.clean && run.stopped.empty())
    return answer(Answer::failed,
                  fmt::format("reported as clean, but has {}", counted(crossings, "crossing")));
  if (crossings > 0)
    return answer(Answer::degraded,
                  fmt::format("reported as not clean: {}", counted(crossings, "crossing")));
  if (!run.stopped.empty()) return answer(Answer::refused, run.stopped);
  if (!right) return answer(Answer::failed, number);
  std::string flags;
  if (run.result.strain_residual > 0.0)
    flags = fmt::format("; {:.3g} % above the strain limit", 100.0 * run.result.strain_residual);
  if (const double gained = run.result.ledger.at("balance").at("energy_gained_J"); gained > 0.0)
    flags += fmt::format("; {:.3g} J gained without a source", gained);
  if (flags.empty()) return answer(Answer::correct, number);
  return answer(Answer::degraded, number + flags + ", reported");
}

std::vector<ExtremeCase> extreme_cases() {
  std::vector<ExtremeCase> all = extreme_number_cases();
  for (ExtremeCase& more : extreme_contact_cases()) all.push_back(std::move(more));
  std::stable_sort(all.begin(), all.end(),
                   [](const ExtremeCase& a, const ExtremeCase& b) { return a.name < b.name; });
  return all;
}

}  // namespace selvedge
