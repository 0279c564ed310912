// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge sequence`: an animated mesh of any program as numbered PLY files.
void add_command_sequence(const selvedge::Command& app);
