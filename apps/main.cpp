// SPDX-License-Identifier: MIT
#include <selvedge/apps/command_line.h>
#include <selvedge/apps/commands.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/signals.h>
#include <selvedge/core/system/internal/terminal.h>

#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>

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
  app.common_options();
  for (const selvedge::ProgramCommand& command : selvedge::program_commands())
    command.add_options(app.subcommand(command.name, command.purpose));
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
  selvedge::prepare_console();
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
