// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge measure`: drape coefficient, folds, rim spectrum, strains and energies of a result as
/// tables and pictures. Throws std::invalid_argument with one sentence for bad input.
void add_command_measure(const selvedge::Command& app);
