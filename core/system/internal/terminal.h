// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace selvedge {

/// True if standard error is shown on a terminal, not written to a file or pipe.
bool error_stream_is_terminal();

/// The program and its arguments in UTF-8, from those of main(), which on Windows have another
/// encoding.
std::vector<std::string> program_arguments(int argc, char** argv);

/// Lets standard output carry bytes as they are; Windows translates ends of lines by default.
void write_bytes_to_output();

/// Lets the console show UTF-8 and obey the escape sequences of progress; on Windows it does not by
/// default.
void prepare_console();

}  // namespace selvedge
