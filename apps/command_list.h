// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge list`: every method of this build, its paper and its guarantee.
void add_command_list(const selvedge::Command& app);
