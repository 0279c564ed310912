// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace selvedge::detail {

/// Limits of a child process.
struct ChildConfig {
  double timeout = 30.0;         ///< s; the child is killed when it runs longer
  std::size_t output_limit = 0;  ///< bytes; the child is killed when it writes more
};

/// How a child process ended.
struct ChildResult {
  enum class End { exited, signalled, timed_out, too_much_output, not_started };
  End end = End::not_started;
  int code = 0;        ///< exit status, signal number, or errno when not started
  std::string output;  ///< the standard output of the child
};

/// Runs a program until it exits, or kills it and its children. Never waits longer than the
/// timeout. Safe in a multi-threaded program: the child is spawned, not forked.
ChildResult run_child(const std::vector<std::string>& arguments, const ChildConfig& config);

}  // namespace selvedge::detail
