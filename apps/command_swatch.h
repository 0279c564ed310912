// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge swatch`: the constants of a weave from its yarns, by tests of a simulated swatch.
/// Throws std::invalid_argument with one sentence for bad input.
void add_command_swatch(const selvedge::Command& app);
