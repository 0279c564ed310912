// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace selvedge::detail {

struct ChildConfig {
  double timeout = 30.0;         ///< s, until the child is killed
  std::size_t output_limit = 0;  ///< bytes, until the child is killed
};

struct ChildResult {
  enum class End { exited, signalled, timed_out, too_much_output, not_started };
  End end = End::not_started;
  int code = 0;        ///< exit status, signal number, or errno when not started
  std::string output;  ///< what it wrote to standard output
};

/// Runs a program to its end, or kills it and its children. Never waits longer than the timeout.
/// Safe in a program with threads: it is spawned, never forked.
ChildResult run_child(const std::vector<std::string>& arguments, const ChildConfig& config);

}  // namespace selvedge::detail
