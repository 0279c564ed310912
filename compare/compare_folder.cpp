// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <fmt/format.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/detail/plan_json.h>
#include <selvedge/core/files.h>
#include <selvedge/core/read_file.h>
#include <selvedge/core/resources.h>
#include <sys/wait.h>
#include <unistd.h>

#ifdef __linux__
#include <sched.h>
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

/// Factor and seconds that extend the time budget for work other than steps: building, warming up,
/// judging detectors, and so on.
constexpr double kBeside = 2.0, kBeside_s = 120.0;
constexpr auto kLookEvery = std::chrono::milliseconds(2);

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

/// A forked process contains only the calling thread; locks held by other threads would never be
/// released.
void refuse_more_threads() {
  std::error_code error;
  const fs::directory_iterator tasks("/proc/self/task", error);
  if (!error && std::distance(begin(tasks), fs::directory_iterator{}) > 1)
    throw std::logic_error("a process with several threads is not copied for a run");
}

/// Silences the terminal and redirects messages to the log.
void redirect(const fs::path& log) {
  constexpr mode_t readable = 0644;
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const int said = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, readable);
  if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
  if (said >= 0) dup2(said, STDERR_FILENO);
}

/// Keeps this process on one core. Throws std::runtime_error if there is no such core.
void pin(int core) {
#ifdef __linux__
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(core, &cores);
  if (sched_setaffinity(0, sizeof cores, &cores) == 0) return;
#endif
  throw std::runtime_error(fmt::format("--core {}: a run cannot be pinned to this core", core));
}

/// Forks a process that makes the run. The copy starts from this process, which has never simulated
/// anything, and needs no loading or linking. Returns -1 if the system refuses a process.
pid_t fork_run(const fs::path& folder, int repeat, const CellLimits& limits,
               const Methods& methods) {
  const fs::path log = folder / "log.txt";
  const pid_t parent = getpid(), child = fork();
  if (child != 0) return child;
  int code = 0;
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(EXIT_FAILURE);
#endif
  redirect(log);
  try {
    if (limits.core >= 0) pin(limits.core);
    run_cell(folder, repeat, limits, methods);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "selvedge: %s\n", error.what());
    code = EXIT_FAILURE;
  }
  std::fflush(stderr);
  _exit(code);  // buffered output belongs to the parent
}

struct Ending {
  int status = 0;
  bool late = false;  ///< the process had to be killed
};

Ending wait_for(pid_t child, double seconds) {
  const Stopwatch watch;
  Ending ending;
  for (;;) {
    const pid_t ended = waitpid(child, &ending.status, WNOHANG);
    if (ended == child) return ending;
    if (ended < 0 && errno != EINTR) throw std::runtime_error("a run was lost sight of");
    if (watch.seconds() > seconds && !ending.late) {
      ending.late = true;
      kill(child, SIGKILL);
    }
    std::this_thread::sleep_for(kLookEvery);
  }
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
  else if (WIFSIGNALED(ending.status))
    run.why = fmt::format("the process was ended by signal {} ({})", WTERMSIG(ending.status),
                          strsignal(WTERMSIG(ending.status)));
  else
    run.why = fmt::format("the process ended with exit code {}", WEXITSTATUS(ending.status));
  if (const std::string words = last_words(log); !words.empty()) run.why += ": " + words;
  return run;
}

void add_time(const CellRun& run, TimeOfRuns& time) {
  ++time.runs;
  time.run_s += run.build_s + run.run_s;
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
  const pid_t child = fork_run(folder, repeat, limits, methods);
  if (child < 0)
    throw std::runtime_error(std::string("no process for a run could be started: ") +
                             std::strerror(errno));
  const Ending ending = wait_for(child, kBeside * limits.budget_s + kBeside_s);
  const auto run = read_cell_run(folder, repeat);
  if (run && WIFEXITED(ending.status) && WEXITSTATUS(ending.status) == 0) return;
  // The disk is full or an input file disappeared: this is no property of the cell.
  constexpr int no_fault_of_the_cell = 1;
  if (WIFEXITED(ending.status) && WEXITSTATUS(ending.status) == no_fault_of_the_cell)
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
  const std::string program = content("/proc/self/exe");
  return program.empty() ? "" : text_hash(program);
}

}  // namespace selvedge
