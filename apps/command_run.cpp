// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/apps/detail/record_queries.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/signals.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/run.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/scene/methods.h>
#include "overrides.h"

namespace {

using namespace selvedge;

struct RunOptions {
  std::string scene, out;
  std::vector<std::string> set;
  double budget = 0.0;
  int max_steps = 0;
  std::optional<int> stall_steps;
  bool resume = false, overwrite = false, every_step = false, json = false, pictures = true;
  QueryRecorderConfig record;
};

void draw(const std::filesystem::path& out, int frame) {
  render_result_frame(out, frame, {}, numbered(out / "pictures", "frame", frame, 5, ".png"));
}

// What the scene prescribes crosses: handles hold cloth inside bodies.
std::string held_inside(const RunResult& r) {
  const auto count = r.counters.find("max_held_inside_bodies");
  if (count == r.counters.end() || count->second == 0.0) return "";
  return fmt::format(" (handles hold {} inside them)",
                     counted(static_cast<long>(count->second), "vertex", "vertices"));
}

/// Says no more than what was checked.
std::string nothing_passed(const RunResult& r, bool beside_tangles) {
  if (r.unchecked.empty())
    return beside_tangles ? "nothing else passed through" : "nothing passed through anything";
  return fmt::format("no {}crossing in any frame; {}", beside_tangles ? "other " : "", r.unchecked);
}

std::string clean_line(const Scene& scene, const RunResult& r) {
  const TangleReport& t = r.tangle;
  const std::string else_passed = nothing_passed(r, true);
  if (t.jams > 0 && t.start_pairs == 0 && r.clean_elsewhere)
    return fmt::format("NO: bodies left cloth no room {}{}; its vertices are flagged, {}",
                       t.jams == 1 ? "once" : fmt::format("{} times", t.jams), held_inside(r),
                       else_passed);
  if (t.start_pairs == 0 && r.clean) return "yes: " + nothing_passed(r, false);
  if (t.start_pairs == 0 || !r.clean_elsewhere) return "NO: something passed through";
  const std::string start =
      fmt::format("{} of triangles crossed at the start", counted(t.start_pairs, "pair"));
  if (r.clean)
    return fmt::format("yes, from {:.4f} s (frame {:.0f}) on: {}, {}", t.until_s,
                       std::ceil(t.until_s * scene.time.fps), start, else_passed);
  return fmt::format("NO: {}, {} still do{}; {}", start, t.pairs,
                     t.given_up ? ", and no way out was found" : "", else_passed);
}

/// The most vertices with a flag in one frame, the start included.
int most_flagged(const RunResult& r, VertexFlag flag) {
  return r.flags.worst[std::countr_zero(static_cast<unsigned>(flag))];
}

// Strain above the limit that no limiter could remove; each of these vertices has a flag.
std::string over_strain(const RunResult& r) {
  if (const int count = most_flagged(r, kFlagOverStrain); count > 0)
    return fmt::format(", {:.2f} % above the limit at {} vertices, flagged",
                       100.0 * r.strain_residual, count);
  if (r.strain_residual <= 0.0) return "";
  return fmt::format(", {:.2f} % above the limit between frames", 100.0 * r.strain_residual);
}

void print_pinched(const RunResult& r) {
  if (const int count = most_flagged(r, kFlagPinched); count > 0)
    fmt::print(
        "pinched      {} vertices nearer to bodies on both sides than the rest gap, flagged\n",
        count);
}

void print_summary(const Scene& scene, const RunResult& r, const std::filesystem::path& out) {
  constexpr double megabyte = 1e6;
  fmt::print("{}: {}, {} in {:.1f} s, at most {:.0f} MB; results in {}\n", printable(scene.name),
             counted(r.frames, "frame"), counted(r.steps, "step"), r.wall_s,
             r.peak_bytes / megabyte, printable(out.string()));
  fmt::print("clean        {}\n", clean_line(scene, r));
  fmt::print("max stretch  {:.2f} %{}\n", 100.0 * r.max_stretch, over_strain(r));
  print_pinched(r);
  if (const auto& gains = r.ledger.at("balance"); gains.at("gained_steps") > 0.0)
    fmt::print("energy       numerical errors added {:.3g} J in {}; shorten the steps\n",
               gains.at("energy_gained_J"),
               counted(static_cast<long>(gains.at("gained_steps")), "step"));
  else if (gains.at("steps") == 0.0 && r.steps > 0)
    fmt::print("energy       not checked: no step of this run has a balance\n");
  fmt::print("rest         {}\n", printable(r.rest.verdict));
  fmt::print("seconds     ");
  for (const auto& [phase, seconds] : r.phase_s) fmt::print(" {} {:.2f}", phase, seconds);
  fmt::print("\n");
  if (!r.stopped.empty()) fmt::print("{}; continue with --resume\n", printable(r.stopped));
}

void print_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  fmt::print("{}", text);
}

/// Reports where a failed run left its failure bundle.
RunResult run_or_explain(const Scene& scene, const RunConfig& config, ProgressBar& bar) {
  try {
    return run_scene(scene, config);
  } catch (const SimulationFailed&) {
    bar.clear();
    const std::string bundle = (config.out / "failure").string();
    fmt::print(stderr, "the failed step is in {}; `selvedge replay {} --explain` repeats it\n",
               printable(bundle), printable(shell_quoted(bundle)));
    throw;
  }
}

int run_command(const RunOptions& options) {
  Methods methods = methods_of_this_build();
  const Scene scene = read_scene(options.scene, read_overrides(options.set), methods);
  RecordedRun recording(options.record, methods);
  const StopOnSignal stop;
  ProgressBar bar("frame", scene.time.frames);
  RunConfig config;
  config.methods = methods;
  config.out = options.out.empty() ? std::filesystem::path("out") / scene.name
                                   : std::filesystem::path(options.out);
  config.resume = options.resume;
  config.overwrite = options.overwrite;
  config.every_step = options.every_step;
  if (options.budget > 0.0) config.budget_s = options.budget;
  config.max_steps = options.max_steps;
  config.stall_steps = options.stall_steps.value_or(config.stall_steps);
  config.stop = stop.requested();
  config.progress = [&](int frame, double seconds) { bar.show(frame, seconds); };
  config.warning = [&](const std::string& sentence) {
    bar.clear();
    fmt::print(stderr, "warning: {}\n", printable(sentence));
  };
  const RunResult result = run_or_explain(scene, config, bar);
  bar.clear();
  recording.write();
  if (options.pictures) draw(config.out, result.frames - 1);
  if (options.json)
    print_file(config.out / "result.json");
  else
    print_summary(scene, result, config.out);
  const bool carried = scene.contact.carry_tangled && result.clean_elsewhere;
  return (result.clean || carried) && result.stopped.empty() ? 0 : 1;
}

void add_run_options(const Command& command) {
  const auto options = std::make_shared<RunOptions>();
  command.option("scene", options->scene, "Scene file (JSON)").required();
  command.option("--out", options->out, "Result folder (default: out/NAME of the scene)");
  command.option("--set", options->set, "path=value replaces a value of the scene file").one_word();
  const Command::Option resume = command.flag("--resume", options->resume,
                                              "Continue from the checkpoint in the result folder");
  command
      .flag("--overwrite", options->overwrite,
            "Replace the results of an earlier run of the scene in the result folder")
      .excludes(resume);
  command.flag("--every-step", options->every_step, "Also write every accepted state");
  command
      .option("--budget", options->budget,
              "Wall seconds; a run that exceeds them stops after the current step, and "
              "--resume continues it")
      .positive();
  command.option("--max-steps", options->max_steps, "Stop after this many accepted steps")
      .range(1, 1'000'000'000);
  command
      .option("--stall-steps", options->stall_steps,
              "Stop as stalled after this many accepted steps in a row near the "
              "smallest size (default 512; 0: never)")
      .range(0, 1'000'000'000);
  add_record_options(command, options->record);
  command.flag("--json", options->json, "Print result.json");
  command.action([options, command] {
    options->pictures = command.pictures();
    return run_command(*options);
  });
}

}  // namespace

selvedge::ProgramCommand run_command() {
  return {.name = "run",
          .purpose = "Simulate a scene into a result folder",
          .add_options = add_run_options};
}
