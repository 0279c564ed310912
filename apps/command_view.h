// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge view`: results as one page that a browser opens.
void add_command_view(const selvedge::Command& app);
