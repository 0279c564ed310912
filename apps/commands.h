// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

#include <vector>

namespace selvedge {

/// A command of the program, such as `selvedge run`. Its action throws std::invalid_argument with
/// one sentence for bad input.
struct ProgramCommand {
  const char* name;
  const char* purpose;  ///< its line in `selvedge --help` and in docs/program.md
  void (*add_options)(const Command& command);  ///< and the action
};

/// All commands, in the order of the help.
std::vector<ProgramCommand> program_commands();

}  // namespace selvedge
