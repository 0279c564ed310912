// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge dress`: a sewing pattern and a body in, a garment on the body out.
void add_command_dress(const selvedge::Command& app);
