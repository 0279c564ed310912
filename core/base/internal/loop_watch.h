// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/parallel.h>

#include <atomic>
#include <exception>
#include <thread>

namespace selvedge {

/// Thrown out of a loop that a LoopWatch has stopped.
class LoopStopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped"; }
};

/// Stops the loops that its thread runs during its lifetime, and the loops within them: soon after
/// `stops` has returned true, they throw LoopStopped. Objects that they were to change are then
/// incomplete and must not be used again. That thread alone calls `stops`, before each range that
/// it takes itself.
class LoopWatch {
 public:
  /// `stops` must outlive it.
  explicit LoopWatch(FunctionRef<bool()> stops);
  ~LoopWatch();
  LoopWatch(const LoopWatch&) = delete;
  LoopWatch& operator=(const LoopWatch&) = delete;

  /// Throws LoopStopped if the loops are to stop.
  void look();

 private:
  FunctionRef<bool()> stops_;
  std::thread::id owner_;
  LoopWatch* outer_;  // of the same thread
  std::atomic<bool> stopped_{false};
};

}  // namespace selvedge
