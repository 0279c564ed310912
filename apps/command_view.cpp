// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/option_values.h>
#include <selvedge/apps/detail/output_file.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/scene/methods.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct ViewOptions {
  std::vector<std::string> results;
  std::string out, frames;
};

ResultView view_of(const std::string& result, const ViewOptions& o) {
  const std::vector<int> all = view_frames(result);
  ViewConfig config{.methods = methods_of_this_build()};
  if (!o.frames.empty()) config.frames = chosen_frames(o.frames, all);
  ProgressBar bar("frame",
                  static_cast<int>(config.frames.empty() ? all.size() : config.frames.size()));
  const Stopwatch watch;
  config.progress = [&](std::size_t frame) { bar.show(static_cast<int>(frame), watch.seconds()); };
  return read_view(result, config);
}

fs::path page_file(const ViewOptions& o) {
  if (!o.out.empty()) return o.out;
  const fs::path result = o.results.front();
  return fs::is_directory(result) ? result / "view.html"
                                  : fs::path(result.stem().string() + ".html");
}

int view_command(const ViewOptions& o) {
  if (o.results.size() > 2)
    throw std::invalid_argument(
        fmt::format("view: a page shows one or two results, not {}", o.results.size()));
  const fs::path file = page_file(o);
  refuse_other_kind(file, kHtmlPage, "--out");
  std::vector<ResultView> views;
  for (const std::string& result : o.results) views.push_back(view_of(result, o));
  if (views.size() == 2) add_distance(views[0], views[1]);
  const std::string page = view_page(views);
  AtomicFile out(file);
  out.write(page);
  out.commit();
  constexpr double megabyte = 1e6;
  print_escaped("{}: {}, {:.1f} MB; open it in a browser\n", file.string(),
                counted(views.front().frames.size(), "frame"),
                static_cast<double>(page.size()) / megabyte);
  return 0;
}

void add_view_options(const Command& command) {
  const auto options = std::make_shared<ViewOptions>();
  command
      .option("results", options->results,
              "One or two: the result folder of a run, its folder failure/, or a mesh file")
      .required();
  command.option("--out", options->out, "File of the page (default: view.html in the result)");
  command.option("--frames", options->frames, "FIRST:LAST:STEP or one number (default: all)");
  command.action([options] { return view_command(*options); });
}

}  // namespace

selvedge::ProgramCommand view_command() {
  return {.name = "view",
          .purpose = "Write a page that shows a result, or two side by side, in a browser",
          .add_options = add_view_options};
}
