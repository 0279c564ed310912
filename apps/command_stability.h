// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge stability`: the largest stable step of each integrator on the cloth of a scene, or the
/// extreme cases of a folder.
void add_command_stability(const selvedge::Command& app);
