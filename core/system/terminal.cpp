// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/terminal.h>

#include <unistd.h>

namespace selvedge {

bool error_stream_is_terminal() { return ::isatty(STDERR_FILENO) != 0; }

}  // namespace selvedge
