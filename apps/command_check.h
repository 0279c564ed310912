// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge check`: the exact check of meshes of any program. The exit code is 0 if nothing
/// is wrong, 1 if something intersects, is inside the body or collides on the path. Throws
/// std::invalid_argument with one sentence for bad input.
void add_command_check(const selvedge::Command& app);
