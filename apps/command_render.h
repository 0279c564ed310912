// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge render`: pictures, turntables and animations of a result folder or a mesh file.
void add_command_render(const selvedge::Command& app);
