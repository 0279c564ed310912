// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge replay`: repeats the step at which a run stopped, or finds the first difference of two
/// runs.
void add_command_replay(const selvedge::Command& app);
