// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge ccd`: what narrow phases make of query files with known answers, and their times.
/// Throws std::invalid_argument with one sentence for bad input.
void add_command_ccd(CLI::App& app, int& exit_code);
