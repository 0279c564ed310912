// SPDX-License-Identifier: MIT
//
// Each scene runs in a process of its own, which sends its result through a pipe.
#include <selvedge/compare/detail/trial.h>

#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/whole_number.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/system/internal/processes.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

namespace selvedge::detail {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostText = std::size_t{1} << 20;  // bytes of a result
constexpr Answer kAnswers[] = {Answer::correct, Answer::refused, Answer::degraded, Answer::failed,
                               Answer::unfinished};
// A scene that has not ended within kHangs times its limit of processor time, by the clock, hangs
// if it uses less than kIdle of a core in that time: it waits for something. If it computes, it may
// go on to kOverdue times the limit by the processor: then a single step is longer than its limit.
constexpr double kHangs = 30.0, kOverdue = 3.0, kIdle = 0.002;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

double number_of(const Json& j) {
  return j.is_number() ? j.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

Json to_json(const SceneMeasures& measures) {
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

SceneMeasures measures_from(const Json& j) {
  SceneMeasures measures;
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

CaseResult run_here(const std::string& name, const SettleConfig& config, const Methods& methods) {
  // No limit differs from a limit of all processors: a scene may ask for more threads.
  std::optional<ThreadLimit> limit;
  if (config.threads > 0) limit.emplace(config.threads);
  try {
    Trial trial(
        {.data = config.folder, .method = config.method, .out = config.out, .limit = config.limit},
        methods);
    return trial.settle(name);
  } catch (const std::exception& error) {
    return {Answer::failed, error.what(), {}};
  }
}

enum class Reading : std::uint8_t { done, overdue, hangs };

Reading read_in_time(const ChildProcess& child, double limit, Pipe& pipe, std::string& text) {
  const double round = kHangs * limit;
  for (double before = 0.0;;) {
    if (pipe.read_all(round, kMostText, text) != Pipe::ReadEnd::late) return Reading::done;
    const double used = child.processor_s();
    if (!(used - before > kIdle * round)) return Reading::hangs;
    if (used >= kOverdue * limit) return Reading::overdue;
    before = used;
  }
}

SettledScene run_apart(const std::string& name, const SettleConfig& config,
                       const Methods& methods) {
  const Stopwatch watch;
  Pipe pipe;
  const ChildProcess child = run_in_copy([&] {
    pipe.write(to_json(run_here(name, config, methods))
                   .dump(-1, ' ', false, Json::error_handler_t::replace));
    return 0;
  });
  std::string text;
  const Reading reading = read_in_time(child, config.limit, pipe, text);
  const ProcessEnd end = reading == Reading::done ? child.wait() : child.kill();
  SettledScene result;
  result.name = name;
  result.method = config.method.name;
  if (reading == Reading::hangs) {
    result.note = fmt::format("hangs: not done after {:.0f} s", watch.seconds());
  } else if (reading == Reading::overdue) {
    result.answer = Answer::unfinished;
    result.note =
        fmt::format("a step takes more than {:g} s of the processor", kOverdue * config.limit);
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

bool is_scene(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(".json") && !name.ends_with(".schema.json");
}

std::vector<std::string> all_scenes_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none))
    if (entry.is_regular_file() && is_scene(entry.path()))
      names.push_back(entry.path().stem().string());
  if (names.empty())
    throw std::invalid_argument(folder.string() + ": the folder has no scenes (*.json)");
  std::sort(names.begin(), names.end());
  return names;
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

}  // namespace selvedge::detail

namespace selvedge {

std::vector<std::string> scenes_in(const std::filesystem::path& folder,
                                   const std::vector<std::string>& beginnings) {
  const std::vector<std::string> all = detail::all_scenes_in(folder);
  if (beginnings.empty()) return all;
  for (const std::string& begin : beginnings)
    if (std::none_of(all.begin(), all.end(),
                     [&](const std::string& name) { return name.starts_with(begin); }))
      throw std::invalid_argument(fmt::format("{}: there is no scene \"{}\"; nearest is \"{}\"",
                                              folder.string(), begin, nearest_word(begin, all)));
  std::vector<std::string> chosen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [&](const std::string& name) {
    return std::any_of(beginnings.begin(), beginnings.end(),
                       [&](const std::string& begin) { return name.starts_with(begin); });
  });
  return chosen;
}

std::vector<SettledScene> settle_scenes(const SettleConfig& config, const Methods& methods,
                                        const std::function<void(const SettledScene&)>& report) {
  std::vector<SettledScene> settled;
  for (const std::string& name : scenes_in(config.folder, config.scenes)) {
    settled.push_back(detail::run_apart(name, config, methods));
    if (report) report(settled.back());
  }
  return settled;
}

}  // namespace selvedge
