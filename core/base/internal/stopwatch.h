// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace selvedge {

/// Wall seconds since `begin`.
inline double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Measures wall time from its construction on.
class Stopwatch {
 public:
  double seconds() const { return seconds_since(begin_); }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace selvedge
