// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge list`: every method of this build, its paper and its guarantee.
void add_command_list(CLI::App& app, int& exit_code);
