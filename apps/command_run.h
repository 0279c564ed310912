// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge run`: simulates a scene into a result folder.
void add_command_run(const selvedge::Command& app);
