// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge detect`: every detector and narrow phase on one step of any two meshes, or of one
/// against itself. Sets exit_code to 1 if a detector breaks its promise. Throws
/// std::invalid_argument with one sentence for bad input.
void add_command_detect(CLI::App& app, int& exit_code);
