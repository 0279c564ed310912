// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/compare/compare_plan.h>
#include <selvedge/compare/compare_table.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/processes.h>
#include <selvedge/pictures/internal/result_view.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/scene/methods.h>
#include "overrides.h"

namespace {

using namespace selvedge;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct CompareOptions {
  std::string scene, out, in, only, workflow, design = "product", error = "position";
  std::vector<std::string> vary, set, reference_set;
  int threads = 1, repeats = 7, judged = 4, seeds = 0, core = -1;
  double budget = 300.0;
  bool no_reference = false, pictures = true, views = false, json = false;
};

void write_whole(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

/// A command that repeats the comparison, without the folder and the options for printing.
std::string command_in_words(const CompareOptions& o) {
  std::string text = "selvedge compare " + shell_quoted(o.scene);
  const auto add = [&](const char* option, const std::vector<std::string>& values) {
    for (const std::string& value : values)
      text += std::string(" ") + option + " " + shell_quoted(value);
  };
  add("--vary", o.vary);
  add("--set", o.set);
  add("--reference-set", o.reference_set);
  if (o.design != "product") text += " --design " + o.design;
  if (o.no_reference) text += " --no-reference";
  if (o.error != "position") text += " --error " + o.error;
  text +=
      o.seeds > 0 ? fmt::format(" --seeds {}", o.seeds) : fmt::format(" --repeats {}", o.repeats);
  if (o.core >= 0) text += fmt::format(" --core {}", o.core);
  return text + fmt::format(" --threads {}", o.threads);
}

CompareRequest request_of(const CompareOptions& o) {
  CompareRequest request;
  request.scene = fs::absolute(o.scene).lexically_normal();
  request.set = read_overrides(o.set, "--set");
  request.reference_set = read_overrides(o.reference_set, "--reference-set");
  request.vary = o.vary;
  request.design = o.design == "product" ? CompareDesign::product : CompareDesign::one_at_a_time;
  request.reference = !o.no_reference;
  request.error = o.error;
  request.repeats = o.seeds > 0 ? o.seeds : o.repeats;
  request.limits = {o.threads, o.budget, o.judged, o.seeds > 0, o.core};
  request.command = command_in_words(o);
  return request;
}

/// All repeats of one cell, or of all; nothing is merged.
void run_only(const CompareOptions& o, const ComparePlan& plan, const Methods& methods) {
  int repeats = level_runs(plan);
  for (const CompareCell& cell : plan.cells)
    if (cell.id == o.only) repeats = plan.repeats;
  for (int repeat = 0; repeat < repeats; ++repeat)
    if (!read_cell_run(cell_folder(o.in, o.only), repeat))
      run_in_process(o.in, o.only, repeat, limits_of(plan, o.only), methods);
}

/// A page of each finished cell, beside the first one, which the page of the comparison links.
void write_views(const fs::path& out, const CompareTable& table, const Methods& methods) {
  const ViewConfig config{.methods = methods, .shortfall = false};
  std::optional<ResultView> first;
  for (const CompareRow& row : table.rows) {
    if (row.status != RunStatus::ok) continue;
    const fs::path cell = cell_folder(out, row.id);
    if (!fs::exists(cell / "frames")) continue;  // it compares detectors alone
    std::vector<ResultView> views = {read_view(cell, config)};
    views[0].name = row.label;
    views[0].notes.push_back("Frame 0 is the start of the run, frame 1 its end.");
    if (first) {
      views.insert(views.begin(), *first);
      add_distance(views[0], views[1]);
    } else {
      first = views[0];
    }
    write_whole(cell / "view.html", view_page(views));
  }
}

int report(const CompareOptions& o, const fs::path& out, const ComparePlan& plan,
           const Methods& methods) {
  const CompareTable table = make_table(out, plan, methods);
  write_whole(out / "compare.csv", to_csv(table));
  write_whole(out / "compare.json", to_json_text(table));
  PageConfig page;
  page.pictures = o.pictures;
  if (o.views) write_views(out, table, methods);
  write_whole(out / "compare.html", compare_page(out, table, page));
  print_escaped("{}", o.json ? to_json_text(table) : to_text(table));
  if (!o.json)
    print_escaped("{0}/compare.html, compare.csv and compare.json contain all results\n",
                  out.string());
  return table.failed() ? 1 : 0;
}

/// Prints the share of the time that is not spent in runs. If it is large, use longer runs.
void print_own_share(const TimeOfRuns& time, double all_s) {
  if (time.runs == 0) return;
  std::string parts;
  double rest_s = all_s - time.run_s;
  for (const auto& [what, seconds] : time.beside_s) {
    parts += fmt::format("{} {:.2f} s, ", what, seconds);
    rest_s -= seconds;
  }
  print_escaped("{} took {:.2f} s; overhead of compare {:.1f} %: {}rest {:.2f} s\n",
                counted(time.runs, "run"), time.run_s, 100.0 * (all_s / time.run_s - 1.0), parts,
                rest_s);
}

int run_all(const CompareOptions& o, const fs::path& out, const ComparePlan& plan,
            const Methods& methods, Clock::time_point begin) {
  const auto spent = [&] { return seconds_since(begin); };
  ProgressBar bar("run", run_count(plan));
  const TimeOfRuns time =
      run_missing(out, plan, methods, [&](int done, int) { bar.show(done, spent()); });
  bar.clear();
  const int code = report(o, out, plan, methods);
  if (!o.json) print_own_share(time, spent());
  return code;
}

void warn_of(const FolderLock& lock) {
  if (!lock.warning().empty()) print_escaped(stderr, "warning: {}\n", lock.warning());
}

int run_planned(const CompareOptions& o, const Methods& methods, Clock::time_point begin) {
  const ComparePlan plan = read_plan(o.in);
  if (plan.build != program_hash())
    throw std::invalid_argument(o.in +
                                ": was planned by another build of this program; times and "
                                "bits of the two do not mix");
  if (o.only.empty()) {
    const FolderLock lock(o.in, "compare");
    warn_of(lock);
    return run_all(o, o.in, plan, methods, begin);
  }
  if (!fs::exists(cell_folder(o.in, o.only) / "scene.json"))
    throw std::invalid_argument(
        fmt::format("--only {}: there is no such cell in {}", o.only, o.in));
  run_only(o, plan, methods);
  return 0;
}

/// A plan and its notes.
struct NotedPlan {
  PlannedCompare made;
  std::vector<std::string> notes;

  /// Writes the plan and then prints its notes, so that a folder is refused in one sentence.
  void write(const fs::path& folder) const {
    write_plan(folder, made.plan, made.scene_of_id);
    for (const std::string& note : notes) print_escaped(stderr, "note: {}\n", note);
  }
};

NotedPlan planned(const CompareOptions& o, const Methods& methods) {
  NotedPlan plan;
  plan.made = plan_compare(request_of(o), methods,
                           [&](const std::string& note) { plan.notes.push_back(note); });
  return plan;
}

int make_workflow(const CompareOptions& o, const Methods& methods) {
  const NotedPlan plan = planned(o, methods);
  const PlannedCompare& made = plan.made;
  const FolderLock lock(o.workflow, "compare");
  warn_of(lock);
  plan.write(o.workflow);
  write_workflow(o.workflow, made.plan);
  print_escaped("{}/Snakefile: {}; run them with: cd {} && snakemake --cores 2\n", o.workflow,
                counted(made.plan.cells.size() + made.plan.levels.size() + 1, "job"),
                shell_quoted(o.workflow));
  return 0;
}

/// Plans into the folder in a copy of this process, so that this one never has a second thread and
/// can be copied for every run (run_in_process). The `main` of the copy prints its exceptions.
/// Returns its exit code.
int plan_in_a_copy(const CompareOptions& o, const fs::path& out, const Methods& methods) {
  const ChildProcess copy = run_in_copy([&] {
    const NotedPlan plan = planned(o, methods);
    const FolderLock lock(out, "compare");
    plan.write(out);
    std::fflush(nullptr);
    return 0;
  });
  const ProcessEnd end = copy.wait();
  return end.by_signal ? EXIT_FAILURE : end.code;
}

int run_command(const CompareOptions& o) {
  const auto begin = Clock::now();
  const Methods methods = methods_of_this_build();
  if (!o.in.empty()) return run_planned(o, methods, begin);
  if (o.scene.empty())
    throw std::invalid_argument(
        "compare: give a scene file and --vary, such as --vary broad_phase");
  if (o.vary.empty())
    throw std::invalid_argument(
        "compare: give --vary, such as --vary broad_phase or dt=1e-3..1e-2:5");
  if (!o.workflow.empty()) return make_workflow(o, methods);
  fs::path out = o.out;
  if (out.empty())
    out = fs::path("out") / ("compare_" + read_scene(o.scene, read_overrides(o.set), methods).name);
  if (const int code = plan_in_a_copy(o, out, methods); code != 0) return code;
  const FolderLock lock(out, "compare");
  warn_of(lock);
  return run_all(o, out, read_plan(out), methods, begin);
}

void add_options(const Command& command, CompareOptions& o) {
  command.option("scene", o.scene, "Scene file (JSON)");
  command
      .option("--vary", o.vary,
              "NAME=a,b,c or NAME=lo..hi:n or \"NAME=lo..hi:n log\" or NAME,NAME (all values "
              "of each); may be given several times")
      .one_word();
  command.option("--design", o.design, "product: every combination; one: one at a time")
      .one_of({"product", "one"});
  command.option("--set", o.set, "path=value replaces a value of the scene file in all cells")
      .one_word();
  command
      .option("--reference-set", o.reference_set,
              "path=value replaces a value in the scene of the converged reference only")
      .one_word();
  command.flag("--no-reference", o.no_reference,
               "Compute no reference: times and detectors only, no errors");
  command
      .option("--error", o.error,
              "Quantity of the errors: position (root mean square, default), hausdorff, drape, "
              "strain, energy, penetration; the table lists all")
      .one_of(error_names());
  command
      .option("--seeds", o.seeds,
              "Instead of repeats: this many runs of each cell and of the reference with different "
              "perturbations; errors are those of the means, with their 90 % intervals")
      .range(2, kMaxRepeats);
  command.option("--out", o.out, "Folder (default: out/compare_NAME); a second start continues it");
  command.option("--repeats", o.repeats, "Runs of each cell (default 7)").range(1, kMaxRepeats);
  command.option("--core", o.core, "Pin every run to this processor core (default: none)")
      .range(0, 1023);
  command.option("--budget", o.budget, "Wall seconds allowed for a run (default 300)").positive();
  command
      .option("--judge", o.judged, "Number of motions on which detectors are checked (default 4)")
      .range(0, 1000);
  command.flag("--views", o.views,
               "Also write a page for each cell that shows its end beside that of the first cell");
  command.flag("--json", o.json, "Print JSON");
  command.option("--in", o.in, "Continue the comparison in this folder");
  command.option("--only", o.only, "With --in: only the runs of this cell; nothing is merged");
  command.option("--workflow", o.workflow,
                 "Write a Snakemake workflow of this comparison, one job for each cell, "
                 "into this folder; run nothing");
}

std::string footer() {
  std::string names;
  for (const auto& [name, key] : short_axes()) names += (names.empty() ? "" : ", ") + name;
  return "Short names: " + names +
         ";\nor any path of the scene file. mesh: particles on a side, dt: seconds per step.\n"
         "Each run has its own process; repeats are interleaved.\n"
         "Exit code: 0 done, 1 a method broke its guarantee (FAILURE), 2 bad input.";
}

void add_compare_options(const Command& command) {
  const auto o = std::make_shared<CompareOptions>();
  add_options(command, *o);
  command.footer(footer());
  command.action([o, command] {
    o->threads = command.threads().value_or(1);
    o->pictures = command.pictures();
    return run_command(*o);
  });
}

}  // namespace

selvedge::ProgramCommand compare_command() {
  return {.name = "compare",
          .purpose = "Measure error against run time while values of a scene vary",
          .add_options = add_compare_options};
}
