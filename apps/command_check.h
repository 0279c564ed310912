// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge check`: what the judge finds in meshes of any program. Sets exit_code to 0 if nothing
/// is wrong, 1 if something intersects, is inside the body or collides on the path. Throws
/// std::invalid_argument with one sentence for bad input.
void add_command_check(CLI::App& app, int& exit_code);
