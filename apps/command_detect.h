// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge detect`: every detector and narrow phase on one step of any two meshes, or of one
/// against itself. The exit code is 1 if a detector breaks its promise. Throws
/// std::invalid_argument with one sentence for bad input.
void add_command_detect(const selvedge::Command& app);
