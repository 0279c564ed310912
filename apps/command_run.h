// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge run`: simulates a scene into a result folder.
void add_command_run(CLI::App& app, int& exit_code);
