// SPDX-License-Identifier: MIT
#include <selvedge/apps/command_line.h>
#include <selvedge/core/signals.h>
#include <selvedge/core/text.h>

#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "command_advise.h"
#include "command_ccd.h"
#include "command_check.h"
#include "command_compare.h"
#include "command_detect.h"
#include "command_dress.h"
#include "command_fabric.h"
#include "command_identify.h"
#include "command_info.h"
#include "command_list.h"
#include "command_measure.h"
#include "command_plan.h"
#include "command_render.h"
#include "command_replay.h"
#include "command_run.h"
#include "command_sequence.h"
#include "command_stability.h"
#include "command_swatch.h"
#include "command_view.h"
#include "version.h"

namespace {

constexpr int kRunFailed = 1, kInputWrong = 2;

int say(const char* sentence, int exit_code) {
  std::fflush(stdout);
  std::fprintf(stderr, "selvedge: %s\n", selvedge::printable(sentence).c_str());
  return exit_code;
}

int run_command_line(int argc, char** argv) {
  selvedge::CommandLine app(
      "Find cloth collisions exactly, and simulate cloth that never passes through anything.",
      "selvedge");
  app.version(version_text());
  add_command_run(app);
  add_command_info(app);
  add_command_dress(app);
  add_command_check(app);
  add_command_detect(app);
  add_command_ccd(app);
  add_command_compare(app);
  add_command_advise(app);
  add_command_plan(app);
  add_command_sequence(app);
  add_command_stability(app);
  add_command_render(app);
  add_command_view(app);
  add_command_measure(app);
  add_command_fabric(app);
  add_command_drape(app);
  add_command_swatch(app);
  add_command_identify(app);
  add_command_replay(app);
  add_command_list(app);
  std::optional<int> exit_code;
  try {
    exit_code = app.parse(argc, argv);
  } catch (const std::system_error&) {
    if (std::ferror(stdout) == 0) throw;  // else the text was longer than the buffer of stdout
  }
  // The text may have gone to a full disk.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return say("the output could not be written; is the disk full?", kRunFailed);
  return exit_code.value_or(0);
}

}  // namespace

int main(int argc, char** argv) {
  selvedge::report_large_files();
  try {
    return run_command_line(argc, argv);
  } catch (const std::invalid_argument& error) {
    return say(error.what(), kInputWrong);
  } catch (const std::bad_alloc&) {
    return say("out of memory; use a coarser cloth or body", kRunFailed);
  } catch (const std::exception& error) {
    return say(error.what(), kRunFailed);
  }
}
