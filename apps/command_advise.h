// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge advise`: the fastest cell of a comparison within a given error.
void add_command_advise(const selvedge::Command& app);
