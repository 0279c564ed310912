// SPDX-License-Identifier: MIT
#include <selvedge/apps/commands.h>

// A command is a source command_NAME.cpp that defines NAME_command(), and a line here.
#define SELVEDGE_COMMANDS(COMMAND) \
  COMMAND(run)                     \
  COMMAND(dress)                   \
  COMMAND(arrange)                 \
  COMMAND(repair)                  \
  COMMAND(check)                   \
  COMMAND(info)                    \
  COMMAND(render)                  \
  COMMAND(view)                    \
  COMMAND(detect)                  \
  COMMAND(ccd)                     \
  COMMAND(compare)                 \
  COMMAND(advise)                  \
  COMMAND(stability)               \
  COMMAND(plan)                    \
  COMMAND(measure)                 \
  COMMAND(fabric)                  \
  COMMAND(drape)                   \
  COMMAND(swatch)                  \
  COMMAND(identify)                \
  COMMAND(sequence)                \
  COMMAND(replay)                  \
  COMMAND(list)

#define SELVEDGE_DECLARE_COMMAND(name) selvedge::ProgramCommand name##_command();
SELVEDGE_COMMANDS(SELVEDGE_DECLARE_COMMAND)
#undef SELVEDGE_DECLARE_COMMAND

std::vector<selvedge::ProgramCommand> selvedge::program_commands() {
#define SELVEDGE_CALL_COMMAND(name) name##_command(),
  return {SELVEDGE_COMMANDS(SELVEDGE_CALL_COMMAND)};
#undef SELVEDGE_CALL_COMMAND
}
