// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

/// `selvedge drape`: drape coefficients of fabrics computed beside the measured ones, over seeds
/// and meshes. Throws std::invalid_argument with one sentence for bad input.
void add_command_drape(const selvedge::Command& app);

/// `selvedge identify`: constants of cloth by the drape it makes. Throws std::invalid_argument with
/// one sentence for bad input.
void add_command_identify(const selvedge::Command& app);
