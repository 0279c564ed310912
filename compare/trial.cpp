// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/trial.h>

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
    case Answer::unfinished:
      return "unfinished";
    case Answer::failed:
      break;
  }
  return "FAILED";
}

}  // namespace selvedge

namespace selvedge::detail {

std::filesystem::path Trial::file(const std::string& name) const {
  return config_.data / (name + ".json");
}

Scene Trial::read(const std::string& name) const { return read_scene(file(name), {}, methods_); }

JudgedRunConfig Trial::run_config(const std::string& name,
                                  const std::vector<Override>& overrides) const {
  JudgedRunConfig config;
  config.overrides = overrides;
  config.method = config_.method;
  config.limit = config_.limit;
  if (!config_.out.empty()) config.out = config_.out / name;
  return config;
}

JudgedRun Trial::run(const std::string& name, const std::vector<Override>& overrides) {
  JudgedRun run = run_judged(file(name), run_config(name, overrides), methods_);
  collect(run);
  return run;
}

JudgedRun Trial::run(const Scene& scene) {
  JudgedRun run = run_judged(scene, run_config(scene.name, {}), methods_);
  collect(run);
  return run;
}

void Trial::collect(const JudgedRun& run) {
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

CaseResult Trial::settle(const JudgedRun& run, bool right, const std::string& number) const {
  if (!run.finite) return answer(Answer::failed, run.stopped);
  if (!run.refused.empty()) return answer(Answer::refused, run.refused);
  const std::size_t crossings = run.intersections + run.path_collisions;
  if (crossings > 0 && run.result.clean && run.stopped.empty())
    return answer(Answer::failed,
                  fmt::format("reported as clean, but has {}", counted(crossings, "crossing")));
  if (crossings > 0)
    return answer(Answer::degraded,
                  fmt::format("reported as not clean: {}", counted(crossings, "crossing")));
  if (!run.in_time) return answer(Answer::unfinished, run.stopped);
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

CaseResult Trial::settle(const std::string& name) {
  const JudgedRun judged = run(name);
  return settle(judged, true,
                fmt::format("{} steps; rms speed {:.2g} m/s at the end", judged.result.steps,
                            judged.rms_speed));
}

}  // namespace selvedge::detail
