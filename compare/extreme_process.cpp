// SPDX-License-Identifier: MIT
//
// Each extreme case runs in a process of its own, which sends its result through a pipe.
#include <selvedge/compare/detail/extreme_cases.h>

#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/whole_number.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/processes.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostText = std::size_t{1} << 20;  // bytes of a result
constexpr Answer kAnswers[] = {Answer::correct, Answer::refused, Answer::degraded, Answer::failed};

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double number_of(const Json& j) {
  return j.is_number() ? j.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Json to_json(const ExtremeMeasures& measures) {
  Json given = Json::object();
  for (const auto& [stage, energy] : measures.given) given[stage] = number(energy);
  return {{"max_stretch", number(measures.max_stretch)},
          {"crossings", measures.crossings},
          {"worst_speed", number(measures.worst_speed)},
          {"energy_ratio", number(measures.energy_ratio)},
          {"given", std::move(given)}};
}

Json to_json(const CaseResult& r) {
  Json json = {{"answer", r.answer}, {"note", r.note}};
  if (r.measures) json["measures"] = to_json(*r.measures);
  return json;
}

ExtremeMeasures measures_from(const Json& j) {
  ExtremeMeasures measures;
  measures.max_stretch = number_of(j.at("max_stretch"));
  const auto crossings = whole_number<std::size_t>(j.at("crossings"));
  if (!crossings) throw std::invalid_argument("crossings are not counted");
  measures.crossings = *crossings;
  measures.worst_speed = number_of(j.at("worst_speed"));
  measures.energy_ratio = number_of(j.at("energy_ratio"));
  for (const auto& [stage, energy] : j.at("given").items())
    measures.given[stage] = number_of(energy);
  return measures;
}

CaseResult run_here(const ExtremeCase& one, const ExtremeCasesConfig& config) {
  // No limit differs from a limit of all processors: a case may ask for more threads.
  std::optional<ThreadLimit> limit;
  if (config.threads > 0) limit.emplace(config.threads);
  try {
    Trial trial({.data = config.folder, .method = config.method, .out = config.out});
    return one.run(trial);
  } catch (const std::exception& error) {
    return {Answer::failed, error.what(), {}};
  }
}

ExtremeResult run_apart(const ExtremeCase& one, const ExtremeCasesConfig& config) {
  const Stopwatch watch;
  Pipe pipe;
  const ChildProcess child = run_in_copy([&] {
    pipe.write(to_json(run_here(one, config)).dump(-1, ' ', false, Json::error_handler_t::replace));
    return 0;
  });
  std::string text;
  const bool in_time = pipe.read_all(config.wall_limit, kMostText, text) != Pipe::ReadEnd::late;
  const ProcessEnd end = in_time ? child.wait() : child.kill();
  ExtremeResult result;
  result.name = one.name;
  result.method = config.method.name;
  if (config.method.name.empty()) result.expected = one.best;
  if (!in_time) {
    result.note = fmt::format("not done after {:g} s", config.wall_limit);
  } else if (const auto sent = read_case_result(text)) {
    result.answer = sent->answer;
    result.note = sent->note;
    if (sent->measures) result.measures = *sent->measures;
  } else {
    result.note = fmt::format("crashed ({} {})", end.by_signal ? "signal" : "exit code", end.code);
  }
  result.wall_s = watch.seconds();
  return result;
}

bool begins_with_one(const std::string& name, const std::vector<std::string>& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](const std::string& begin) { return name.starts_with(begin); });
}

std::vector<std::string> names_of(const std::vector<ExtremeCase>& cases) {
  std::vector<std::string> names;
  for (const ExtremeCase& one : cases) names.push_back(one.name);
  return names;
}

std::vector<ExtremeCase> chosen_cases(const std::vector<std::string>& beginnings) {
  std::vector<ExtremeCase> cases = extreme_cases();
  for (const std::string& begin : beginnings)
    if (std::none_of(cases.begin(), cases.end(),
                     [&](const ExtremeCase& c) { return c.name.starts_with(begin); }))
      throw std::invalid_argument(fmt::format("there is no extreme case \"{}\"; nearest is \"{}\"",
                                              begin, nearest_word(begin, names_of(cases))));
  if (!beginnings.empty())
    std::erase_if(cases,
                  [&](const ExtremeCase& c) { return !begins_with_one(c.name, beginnings); });
  return cases;
}

}  // namespace

std::optional<CaseResult> read_case_result(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  try {
    const auto answer = whole_number<std::size_t>(json.at("answer"), 0, std::size(kAnswers) - 1);
    if (!answer) return std::nullopt;
    CaseResult result{kAnswers[*answer], json.at("note").get<std::string>(), {}};
    if (json.contains("measures")) result.measures = measures_from(json["measures"]);
    return result;
  } catch (const std::exception&) {  // cut short, or of another form
    return std::nullopt;
  }
}

std::vector<std::string> extreme_case_names(const std::vector<std::string>& beginnings) {
  return names_of(chosen_cases(beginnings));
}

std::vector<ExtremeResult> run_extreme_cases(
    const ExtremeCasesConfig& config, const std::function<void(const ExtremeResult&)>& report) {
  // The expected answers belong to these scenes alone.
  if (!std::filesystem::exists(config.folder / "s01_stiffness.json"))
    throw std::invalid_argument(config.folder.string() +
                                ": is not a folder of extreme cases, such as data/extreme of the "
                                "sources or share/selvedge/extreme of an installation");
  std::vector<ExtremeResult> results;
  for (const ExtremeCase& one : chosen_cases(config.cases)) {
    results.push_back(run_apart(one, config));
    if (report) report(results.back());
  }
  return results;
}

}  // namespace selvedge
