// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge compare`: error against run time of a scene with what is varied in it.
void add_command_compare(CLI::App& app, int& exit_code);
