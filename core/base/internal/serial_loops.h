// SPDX-License-Identifier: MIT
//
// For threads that each do a whole task: the loops within a task stay in its thread.
#pragma once

#include <selvedge/core/base/parallel.h>

namespace selvedge {

/// The loops of this thread run in it alone during the lifetime. Results do not change.
class SerialLoops {
 public:
  SerialLoops();
  ~SerialLoops();
  SerialLoops(const SerialLoops&) = delete;
  SerialLoops& operator=(const SerialLoops&) = delete;

 private:
  bool outer_;
};

/// Runs the task. While its loops wait for other threads, this thread takes no work from outside of
/// the task.
void run_isolated(FunctionRef<void()> task);

}  // namespace selvedge
