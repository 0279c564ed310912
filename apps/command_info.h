// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge info`: what a mesh file holds.
void add_command_info(const selvedge::Command& app);
