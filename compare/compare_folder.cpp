// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/detail/plan_json.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/libraries.h>
#include <selvedge/core/system/internal/processes.h>
#include <selvedge/core/system/internal/read_file.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

/// Factor and seconds that extend the time budget for work other than steps: building, warming up,
/// judging detectors, and so on.
constexpr double kBeside = 2.0, kBeside_s = 120.0;
constexpr int kNoFaultOfTheCell = 1;  // exit code of a run

std::string content(const fs::path& file) {
  return read_if_there(file, {.most_bytes = std::uintmax_t{8} << 30});
}

void write_whole(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

/// The fields that all runs of a comparison must share.
OrderedJson what_decides(const ComparePlan& plan) {
  OrderedJson j = detail::plan_json(plan);
  j.erase("command");
  j.erase("error");
  j.erase("repeats");
  return j;
}

void refuse_other_files(const fs::path& out) {
  std::error_code error;
  if (!fs::exists(out, error)) return;
  if (!fs::is_directory(out, error))
    throw std::invalid_argument(out.string() + ": is a file; name a folder with --out");
  for (const auto& entry : fs::directory_iterator(out, error))
    if (entry.path().filename() != FolderLock::kFile)
      throw std::invalid_argument(out.string() +
                                  ": holds files that are of no compare; name another folder");
}

void refuse_other_compare(const fs::path& out, const ComparePlan& plan) {
  const ComparePlan former = read_plan(out);
  if (what_decides(former) == what_decides(plan)) return;
  const std::string what = former.build != plan.build ? "was made by another build of this program"
                                                      : "is another compare";
  throw std::invalid_argument(
      fmt::format("{}: {}; name another folder with --out, or remove it", out.string(), what));
}

// -- processes ------------------------------------------------------------------------------------

void refuse_more_threads() {
  if (running_threads() > 1)
    throw std::logic_error("a process with several threads is not copied for a run");
}

/// The task of a copy of this process, which has never simulated anything. Returns its exit code.
int run_logged(const fs::path& folder, int repeat, const CellLimits& limits,
               const Methods& methods) {
  redirect_output(folder / "log.txt");
  try {
    if (limits.core >= 0 && !pin_to_core(limits.core))
      throw std::runtime_error(
          fmt::format("--core {}: a run cannot be pinned to this core", limits.core));
    run_cell(folder, repeat, limits, methods);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "selvedge: %s\n", error.what());
    return kNoFaultOfTheCell;
  }
}

struct Ending : ProcessEnd {
  bool late = false;  ///< the process had to be killed
};

Ending wait_for(const ChildProcess& child, double seconds) {
  if (const auto end = child.wait(seconds)) return {*end};
  return {child.kill(), true};
}

/// The last line that a run printed.
std::string last_words(const fs::path& log) {
  std::ifstream in(log);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

CellRun silent_end(const Ending& ending, const fs::path& log) {
  CellRun run;
  run.status = ending.late ? RunStatus::budget : RunStatus::crashed;
  if (ending.late)
    run.why = "did not end within the time granted and was killed";
  else if (ending.by_signal)
    run.why = fmt::format("the process was ended by signal {} ({})", ending.code,
                          signal_name(ending.code));
  else
    run.why = fmt::format("the process ended with exit code {}", ending.code);
  if (const std::string words = last_words(log); !words.empty()) run.why += ": " + words;
  return run;
}

void add_time(const CellRun& run, TimeOfRuns& time) {
  ++time.runs;
  time.run_s += run.build_s + run.clock_s;
  for (const auto& [what, seconds] : run.beside_s)
    (what == "checking" ? time.run_s : time.beside_s[what]) += seconds;
}

}  // namespace

CellLimits limits_of(const ComparePlan& plan, const std::string& id) {
  CellLimits limits = plan.limits;
  for (const CompareCell& cell : plan.cells)
    if (cell.id == id) {
      limits.threads = cell.threads;
      return limits;
    }
  limits.judged_motions = 0;
  return limits;
}

fs::path cell_folder(const fs::path& out, const std::string& id) { return out / "cells" / id; }

void write_plan(const fs::path& out, const ComparePlan& plan,
                const std::vector<std::pair<std::string, std::string>>& scene_of_id) {
  if (fs::exists(out / "plan.json"))
    refuse_other_compare(out, plan);
  else
    refuse_other_files(out);
  fs::create_directories(out);
  for (const auto& [id, scene] : scene_of_id) {
    fs::create_directories(cell_folder(out, id));
    if (!fs::exists(cell_folder(out, id) / "scene.json"))
      write_whole(cell_folder(out, id) / "scene.json", scene + "\n");
  }
  write_whole(
      out / "plan.json",
      detail::plan_json(plan).dump(1, ' ', false, OrderedJson::error_handler_t::replace) + "\n");
}

ComparePlan read_plan(const fs::path& out) {
  const fs::path file = out / "plan.json";
  const OrderedJson j = OrderedJson::parse(content(file), nullptr, false);
  if (!j.is_object())
    throw std::invalid_argument(
        fmt::format("{}: {}; make one with `selvedge compare`", file.string(),
                    fs::exists(file) ? "is damaged" : "there is no compare in this folder"));
  try {
    return detail::plan_from(j);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}; remove the folder and start the compare again",
                                            file.string(), error.what()));
  }
}

void run_in_process(const fs::path& out, const std::string& id, int repeat,
                    const CellLimits& limits, const Methods& methods) {
  const fs::path folder = cell_folder(out, id);
  const fs::path log = folder / "log.txt";
  refuse_more_threads();
  const ChildProcess child =
      run_in_copy([&] { return run_logged(folder, repeat, limits, methods); });
  const Ending ending = wait_for(child, kBeside * limits.budget_s + kBeside_s);
  const auto run = read_cell_run(folder, repeat);
  if (run && !ending.by_signal && ending.code == 0) return;
  // The disk is full or an input file disappeared: this is no property of the cell.
  if (!ending.by_signal && ending.code == kNoFaultOfTheCell)
    throw std::runtime_error(fmt::format("cell {}: {}", id, last_words(log)));
  note_run(folder, repeat, silent_end(ending, log));
}

int level_runs(const ComparePlan& plan) { return plan.limits.seeds ? plan.repeats : 1; }

int run_count(const ComparePlan& plan) {
  return level_runs(plan) * static_cast<int>(plan.levels.size()) +
         plan.repeats * static_cast<int>(plan.cells.size());
}

TimeOfRuns run_missing(const fs::path& out, const ComparePlan& plan, const Methods& methods,
                       const std::function<void(int, int)>& progress) {
  const int all = run_count(plan);
  int done = 0;
  TimeOfRuns time;
  const auto run = [&](const std::string& id, int repeat) {
    const fs::path folder = cell_folder(out, id);
    if (!read_cell_run(folder, repeat)) {
      run_in_process(out, id, repeat, limits_of(plan, id), methods);
      if (const auto made = read_cell_run(folder, repeat)) add_time(*made, time);
    }
    progress(++done, all);
  };
  for (const std::string& level : plan.levels)
    for (int member = 0; member < level_runs(plan); ++member) run(level, member);
  for (int repeat = 0; repeat < plan.repeats; ++repeat)
    for (const CompareCell& cell : plan.cells) {
      const auto first = read_cell_run(cell_folder(out, cell.id), 0);
      if (!cell.impossible.empty() || (first && first->status != RunStatus::ok))
        progress(++done, all);
      else
        run(cell.id, repeat);
    }
  return time;
}

std::string text_hash(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a, 64 bits
  constexpr std::uint64_t prime = 1099511628211u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * prime;
  return fmt::format("{:016x}", hash);
}

std::string program_hash() {
  const std::string program = content(running_program());
  return program.empty() ? "" : text_hash(program);
}

}  // namespace selvedge
