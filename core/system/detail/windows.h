// SPDX-License-Identifier: MIT
#pragma once

/// The interface of Windows, without its macros min and max. Include it before other headers of the
/// system.
#ifndef NOMINMAX
#define NOMINMAX
#endif
#define WIN32_LEAN_AND_MEAN
#include <windows.h>

#include <system_error>

namespace selvedge::detail {

/// The last error of the system in this thread.
inline std::error_code last_error() {
  return {static_cast<int>(GetLastError()), std::system_category()};
}

}  // namespace selvedge::detail
