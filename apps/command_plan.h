// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge plan`: what a scene needs, what is left out, and why; what proofs save; what switching
/// a part off by hand would cost.
void add_command_plan(CLI::App& app, int& exit_code);
