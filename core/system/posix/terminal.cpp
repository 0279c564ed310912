// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/terminal.h>

#include <unistd.h>

namespace selvedge {

bool error_stream_is_terminal() { return ::isatty(STDERR_FILENO) != 0; }

std::vector<std::string> program_arguments(int argc, char** argv) { return {argv, argv + argc}; }

void write_bytes_to_output() {}

void prepare_console() {}

}  // namespace selvedge
