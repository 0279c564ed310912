// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge replay`: repeats the step at which a run stopped, or tells two runs apart.
void add_command_replay(CLI::App& app, int& exit_code);
