// SPDX-License-Identifier: MIT
// The exact check examines every frame and every path between two accepted states. Each case
// runs in a process of its own, so that a crash or a hang is a row of the table and not its end.
#include "command_stability_cases.h"

#include <fmt/core.h>
#include <poll.h>
#include <selvedge/compare/extreme_cases.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/resources.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

std::vector<ExtremeCase> chosen_cases(const CaseOptions& options) {
  std::vector<ExtremeCase> all = extreme_cases(), chosen;
  for (const std::string& wanted : options.cases)
    if (std::none_of(all.begin(), all.end(),
                     [&](const ExtremeCase& c) { return c.name.starts_with(wanted); }))
      throw std::invalid_argument(
          fmt::format("--cases {}: there is no such case; --list prints the names", wanted));
  for (ExtremeCase& one : all)
    if (options.cases.empty() ||
        std::any_of(options.cases.begin(), options.cases.end(),
                    [&](const std::string& wanted) { return one.name.starts_with(wanted); }))
      chosen.push_back(std::move(one));
  return chosen;
}

/// "" is the default response.
std::vector<std::string> chosen_responses(const CaseOptions& options) {
  const auto known = Methods{}.responses;
  if (options.responses.empty()) return {""};
  std::vector<std::string> chosen;
  for (const std::string& name : options.responses) {
    const std::string fault = known.fault(name);
    if (name == "all")
      chosen = known.names();
    else if (fault.empty())
      chosen.push_back(name);
    else
      throw std::invalid_argument("--responses: " + fault);
  }
  return chosen;
}

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

/// In the child: runs the case and writes its result into the pipe.
[[noreturn]] void run_child(const ExtremeCase& one, const std::string& response,
                            const CaseOptions& options, int pipe) {
  json result;
  try {
    // No limit differs from a limit of all processors: a case may ask for more threads.
    std::optional<ThreadLimit> limit;
    if (options.threads > 0) limit.emplace(options.threads);
    const std::filesystem::path out =
        options.out.empty() ? "" : options.out / (response.empty() ? "default" : response);
    Trial trial({.data = options.data, .response = response, .out = out});
    const CaseResult r = one.run(trial);
    result = {{"answer", to_string(r.answer)},
              {"note", r.note},
              {"max_stretch", number(r.max_stretch)},
              {"crossings", r.crossings},
              {"worst_speed", number(r.worst_speed)},
              {"energy_ratio", number(r.energy_ratio)},
              {"given_J", r.given}};
  } catch (const std::exception& error) {
    result = {{"answer", "FAILED"}, {"note", error.what()}};
  }
  const std::string text = result.dump(-1, ' ', false, json::error_handler_t::replace);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t more = write(pipe, text.data() + done, text.size() - done);
    if (more <= 0) break;
    done += static_cast<std::size_t>(more);
  }
  _exit(0);
}

/// Reads until the child closes the pipe; false if it takes longer than the limit.
bool read_all(int pipe, double limit, std::string& text) {
  const auto end = Clock::now() + std::chrono::duration<double>(limit);
  char buffer[4096];
  while (true) {
    const std::chrono::duration<double, std::milli> left = end - Clock::now();
    if (left.count() <= 0.0) return false;
    pollfd wait{pipe, POLLIN, 0};
    const int ready = poll(&wait, 1, static_cast<int>(left.count()) + 1);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t more = read(pipe, buffer, sizeof(buffer));
    if (more <= 0) return more == 0;
    text.append(buffer, static_cast<std::size_t>(more));
  }
}

json measure(const ExtremeCase& one, const std::string& response, const CaseOptions& options) {
  const auto begin = Clock::now();
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe can be made");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process can be made");
  if (child == 0) {
    close(ends[0]);
    run_child(one, response, options, ends[1]);
  }
  close(ends[1]);
  std::string text;
  const bool in_time = read_all(ends[0], options.limit, text);
  close(ends[0]);
  if (!in_time) kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  json result = json::parse(text, nullptr, false);
  if (!in_time)
    result = {{"answer", "FAILED"}, {"note", fmt::format("not done after {:g} s", options.limit)}};
  else if (result.is_discarded())
    result = {{"answer", "FAILED"}, {"note", fmt::format("crashed (status {})", status)}};
  result["case"] = one.name;
  result["response"] = response.empty() ? ContactSpec{}.response : response;
  result["expected"] = response.empty() ? to_string(one.best) : "";
  result["wall_s"] = seconds_since(begin);
  return result;
}

std::string shown(const json& result, const char* key, const char* format, double factor = 1.0) {
  if (!result.contains(key) || !result[key].is_number()) return "";
  return fmt::format(fmt::runtime(format), factor * result[key].get<double>());
}

/// What each stage of the step gave, in mJ; nothing of those that gave nothing.
std::string ledger(const json& result) {
  if (!result.contains("given_J") || !result["given_J"].is_object()) return "";
  std::string text;
  for (const auto& [stage, energy] : result["given_J"].items()) {
    if (!energy.is_number() || energy.get<double>() == 0.0) continue;
    text +=
        fmt::format("{}{} {:+.3g}", text.empty() ? "" : ", ", stage, 1e3 * energy.get<double>());
  }
  return text;
}

/// The answer, and which one it should have been.
std::string answer_of(const json& r) {
  const auto answer = r["answer"].get<std::string>(), expected = r["expected"].get<std::string>();
  if (expected.empty() || expected == answer) return answer;
  return answer + ", should be " + expected;
}

/// `name`: of the response, with the separator of the next column.
void print_row(const json& r, const std::string& name) {
  std::string note = r["note"].get<std::string>();
  std::replace(note.begin(), note.end(), '|', '/');
  std::replace(note.begin(), note.end(), '\n', ' ');
  fmt::print("| `{}` | {}{} | {} | {} | {} | {} | {} | {} | {:.1f} |\n",
             r["case"].get<std::string>(), name, answer_of(r), note,
             shown(r, "max_stretch", "{:.3g}", 100.0), shown(r, "crossings", "{:.0f}"),
             shown(r, "worst_speed", "{:.3g}"), shown(r, "energy_ratio", "{:.4f}"), ledger(r),
             r["wall_s"].get<double>());
  std::fflush(stdout);
}

void print_head(bool several) {
  fmt::print(
      "| case | {}answer | number, reason or flag | stretch, % | crossings | worst speed, m/s | "
      "energy ratio | given by, mJ | wall, s |\n| --- | {}--- | --- | --: | --: | --: | --: | --- "
      "| "
      "--: |\n",
      several ? "response | " : "", several ? "--- | " : "");
}

/// The expected answers belong to the scenes of data/extreme alone.
void refuse_other_folder(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / "s01_stiffness.json"))
    throw std::invalid_argument(folder.string() +
                                ": is not a folder of extreme cases, such as data/extreme of the "
                                "sources or share/selvedge/extreme of an installation");
}

int print_names(const std::vector<ExtremeCase>& cases) {
  for (const ExtremeCase& one : cases) fmt::print("{}\n", one.name);
  return 0;
}

}  // namespace

void add_case_options(const Command& group, CaseOptions& options) {
  group.option("--cases", options.cases, "Names of cases, or how they begin (default: all)")
      .comma_separated()
      .one_word();
  group
      .option("--responses", options.responses,
              "Names of responses, or all (default: the default response)")
      .comma_separated()
      .one_word();
  group.option("--out", options.out, "Folder for frames, which `selvedge render` draws");
  group
      .option("--limit", options.limit,
              "Wall seconds after which a case counts as failed (default 120)")
      .positive();
  group.flag("--list", options.list, "Print the names of the cases");
}

int run_cases(const CaseOptions& options) {
  refuse_other_folder(options.data);
  const std::vector<ExtremeCase> cases = chosen_cases(options);
  if (options.list) return print_names(cases);
  const std::vector<std::string> responses = chosen_responses(options);
  const bool several = responses.size() > 1;
  if (!options.json) print_head(several);
  json results = json::array();
  std::map<std::string, int> count;
  int unexpected = 0;
  for (const std::string& response : responses)
    for (const ExtremeCase& one : cases) {
      const json result = measure(one, response, options);
      ++count[result["answer"].get<std::string>()];
      unexpected += answer_of(result) != result["answer"].get<std::string>();
      if (!options.json)
        print_row(result, several ? result["response"].get<std::string>() + " | " : "");
      results.push_back(result);
    }
  if (options.json)
    fmt::print("{}\n", json{{"results", results}}.dump(2));
  else
    fmt::print("\n{} correct, {} degraded, {} refused, {} FAILED\n", count["correct"],
               count["degraded"], count["refused"], count["FAILED"]);
  return count["FAILED"] > 0 || unexpected > 0 ? 1 : 0;
}
