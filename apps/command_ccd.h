// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge ccd`: accuracy and time of narrow phases on query files with known answers.
/// Throws std::invalid_argument with one sentence for bad input.
void add_command_ccd(const selvedge::Command& app);
