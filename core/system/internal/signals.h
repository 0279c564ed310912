// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>

namespace selvedge {

/// While it lives, the first Ctrl-C or SIGTERM sets a flag; a second one ends the process at once.
/// One object at a time: a signal handler can only use static storage.
class StopOnSignal {
 public:
  StopOnSignal();
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

  const std::atomic<bool>* requested() const;
};

/// A file that exceeds the size limit of the process becomes an error of the write; by default it
/// ends the process.
void report_large_files();

}  // namespace selvedge
