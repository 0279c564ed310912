// SPDX-License-Identifier: MIT
// The extreme cases of data/extreme against every response: which are answered correctly, which are
// refused with a reason, which are degraded and say so. Every frame and every path between two
// accepted states is judged by the exact check. Each case runs in a process of its own, so that a
// crash or a hang is a row of the table and not its end.
#include <selvedge/tests/extreme_cases.h>

#include <fmt/core.h>
#include <poll.h>
#include <selvedge/core/parallel.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

using nlohmann::json;
using selvedge::ExtremeCase;
using Clock = std::chrono::steady_clock;

struct Options {
  std::vector<std::string> cases, responses;  // empty: all
  std::filesystem::path out;
  int threads = 0;
  double limit = 120.0;  // s a case
  bool as_json = false, list = false;
};

Options parse(int argc, char** argv) {
  Options options;
  CLI::App app("The extreme cases of data/extreme: correct, refused, degraded or FAILED");
  app.add_option("--cases", options.cases, "Beginnings of names of cases; left out: all")
      ->delimiter(',');
  app.add_option("--responses", options.responses,
                 "Names of responses, or all; left out: the default")
      ->delimiter(',');
  app.add_option("--threads", options.threads, "Threads at most; 0: as many as the machine has")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--out", options.out, "Folder for frames, which `selvedge render` draws");
  app.add_option("--limit", options.limit, "Seconds after which a case has failed")
      ->check(CLI::PositiveNumber);
  app.add_flag("--json", options.as_json, "Print JSON instead of the table");
  app.add_flag("--list", options.list, "Print the names of the cases");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error) == 0 ? 0 : 2);
  }
  return options;
}

std::vector<ExtremeCase> chosen_cases(const Options& options) {
  std::vector<ExtremeCase> all = selvedge::extreme_cases(), chosen;
  for (const std::string& wanted : options.cases)
    if (std::none_of(all.begin(), all.end(),
                     [&](const ExtremeCase& c) { return c.name.starts_with(wanted); }))
      throw std::invalid_argument(
          fmt::format("--cases {}: there is no such case; see --list", wanted));
  for (ExtremeCase& one : all)
    if (options.cases.empty() ||
        std::any_of(options.cases.begin(), options.cases.end(),
                    [&](const std::string& wanted) { return one.name.starts_with(wanted); }))
      chosen.push_back(std::move(one));
  return chosen;
}

/// "" is the default response.
std::vector<std::string> chosen_responses(const Options& options) {
  const auto known = selvedge::Methods{}.responses;
  if (options.responses.empty()) return {""};
  std::vector<std::string> chosen;
  for (const std::string& name : options.responses) {
    if (name == "all") {
      for (const auto& [key, factory] : known) chosen.push_back(key);
    } else if (known.contains(name)) {
      chosen.push_back(name);
    } else {
      throw std::invalid_argument(fmt::format("--responses {}: there is no such response", name));
    }
  }
  return chosen;
}

json number(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

/// In the child: runs the case and writes its result into the pipe.
[[noreturn]] void run_child(const ExtremeCase& one, const std::string& response,
                            const Options& options, int pipe) {
  json result;
  try {
    const selvedge::ThreadLimit limit(options.threads);
    selvedge::Trial trial(response, options.out.empty()
                                        ? std::filesystem::path{}
                                        : options.out / (response.empty() ? "default" : response));
    const selvedge::CaseResult r = one.run(trial);
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

json measure(const ExtremeCase& one, const std::string& response, const Options& options) {
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
  result["response"] = response.empty() ? selvedge::ContactSpec{}.response : response;
  result["expected"] = response.empty() ? to_string(one.best) : "";
  result["wall_s"] = std::chrono::duration<double>(Clock::now() - begin).count();
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

void print_row(const json& r) {
  std::string note = r["note"].get<std::string>();
  std::replace(note.begin(), note.end(), '|', '/');
  std::replace(note.begin(), note.end(), '\n', ' ');
  // The folder of the sources is nobody else's.
  const std::string source = SELVEDGE_SOURCE_DIR "/";
  for (std::size_t at = note.find(source); at != std::string::npos; at = note.find(source))
    note.erase(at, source.size());
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} |\n",
             r["case"].get<std::string>(), r["response"].get<std::string>(),
             r["answer"].get<std::string>(), note, shown(r, "max_stretch", "{:.3g}", 100.0),
             shown(r, "crossings", "{:.0f}"), shown(r, "worst_speed", "{:.3g}"),
             shown(r, "energy_ratio", "{:.4f}"), ledger(r), r["wall_s"].get<double>());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  const Options options = parse(argc, argv);
  const std::vector<ExtremeCase> cases = chosen_cases(options);
  if (options.list) {
    for (const ExtremeCase& one : cases) fmt::print("{}\n", one.name);
    return 0;
  }
  if (!options.as_json)
    fmt::print(
        "| case | response | answer | number, reason or flag | stretch % | crossings | worst "
        "speed m/s | energy ratio | given by, mJ | wall s |\n"
        "| --- | --- | --- | --- | --: | --: | --: | --: | --- | --: |\n");
  json results = json::array();
  std::map<std::string, int> count;
  for (const std::string& response : chosen_responses(options))
    for (const ExtremeCase& one : cases) {
      const json result = measure(one, response, options);
      ++count[result["answer"].get<std::string>()];
      if (!options.as_json) print_row(result);
      results.push_back(result);
    }
  if (options.as_json)
    fmt::print("{}\n", json{{"results", results}}.dump(2));
  else
    fmt::print("\n{} correct, {} degraded, {} refused, {} FAILED\n", count["correct"],
               count["degraded"], count["refused"], count["FAILED"]);
  return count["FAILED"] > 0 ? 1 : 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "bench_extreme: {}\n", error.what());
  return 2;
}
