// SPDX-License-Identifier: MIT
#pragma once

namespace selvedge {

/// True if standard error is shown on a terminal, not written to a file or pipe.
bool error_stream_is_terminal();

}  // namespace selvedge
