// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge fabric`: what a laboratory measured as the material of a scene, and what each mesh
/// makes of it. Throws std::invalid_argument with one sentence for bad input.
void add_command_fabric(CLI::App& app, int& exit_code);
