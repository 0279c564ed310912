// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge drape`: drape coefficients of fabrics computed beside the measured ones, over seeds
/// and meshes. Throws std::invalid_argument with one sentence for bad input.
void add_command_drape(CLI::App& app, int& exit_code);

/// `selvedge identify`: constants of cloth by the drape it makes. Throws std::invalid_argument with
/// one sentence for bad input.
void add_command_identify(CLI::App& app, int& exit_code);
