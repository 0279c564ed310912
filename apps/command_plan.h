// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge plan`: the parts that a scene needs and the parts that are left out, with reasons; the
/// time that proofs save; the error of switching a part off.
void add_command_plan(const selvedge::Command& app);
