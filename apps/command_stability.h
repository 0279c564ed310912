// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge stability`: the largest stable step of each integrator on the cloth of a scene, or the
/// extreme cases of a folder.
void add_command_stability(CLI::App& app, int& exit_code);
