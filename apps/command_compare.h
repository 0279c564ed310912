// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge compare`: error against run time over values that vary in a scene.
void add_command_compare(const selvedge::Command& app);
