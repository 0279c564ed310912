// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <system_error>

#include "command_advise.h"
#include "command_ccd.h"
#include "command_check.h"
#include "command_compare.h"
#include "command_detect.h"
#include "command_fabric.h"
#include "command_identify.h"
#include "command_list.h"
#include "command_measure.h"
#include "command_plan.h"
#include "command_render.h"
#include "command_replay.h"
#include "command_run.h"
#include "command_stability.h"

namespace {

constexpr int run_failed = 1, input_wrong = 2;

int say(const char* sentence, int exit_code) {
  std::fflush(stdout);
  std::fprintf(stderr, "selvedge: %s\n", sentence);
  return exit_code;
}

int run_command_line(int argc, char** argv) {
  CLI::App app{"Cloth collision: exact, clean, and nothing the scene does not need.", "selvedge"};
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::simple);
  int exit_code = 0;
  add_command_run(app, exit_code);
  add_command_check(app, exit_code);
  add_command_detect(app, exit_code);
  add_command_ccd(app, exit_code);
  add_command_compare(app, exit_code);
  add_command_advise(app, exit_code);
  add_command_plan(app, exit_code);
  add_command_stability(app, exit_code);
  add_command_render(app, exit_code);
  add_command_measure(app, exit_code);
  add_command_fabric(app, exit_code);
  add_command_drape(app, exit_code);
  add_command_identify(app, exit_code);
  add_command_replay(app, exit_code);
  add_command_list(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : input_wrong;  // help is no error
  } catch (const std::system_error&) {
    if (std::ferror(stdout) == 0) throw;  // else the text was longer than what stdout holds back
  }
  // What was printed may have gone to a full disk.
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return say("the output could not be written; is the disk full?", run_failed);
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the size limit is an error of write, not a death
  try {
    return run_command_line(argc, argv);
  } catch (const std::invalid_argument& error) {
    return say(error.what(), input_wrong);
  } catch (const std::bad_alloc&) {
    return say("out of memory; use a coarser cloth or body", run_failed);
  } catch (const std::exception& error) {
    return say(error.what(), run_failed);
  }
}
