// SPDX-License-Identifier: MIT
#pragma once

namespace CLI {
class App;
}

/// `selvedge advise`: from what a compare measured, the cheapest cell within a wanted error.
void add_command_advise(CLI::App& app, int& exit_code);
