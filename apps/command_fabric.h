// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge fabric`: laboratory measurements as the material of a scene, and the elastic constants
/// of each mesh pattern. Throws std::invalid_argument with one sentence for bad input.
void add_command_fabric(const selvedge::Command& app);
