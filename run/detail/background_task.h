// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <future>

namespace selvedge::detail {

/// One task at a time in a thread of its own. With one thread (thread_count), the task runs in
/// `finish` instead.
class BackgroundTask {
 public:
  BackgroundTask() = default;
  BackgroundTask(const BackgroundTask&) = delete;
  BackgroundTask& operator=(const BackgroundTask&) = delete;

  /// Starts a task; the former one must be finished. What the task refers to must live until
  /// `finish` or the destructor, which waits as well.
  void start(std::function<void()> task);
  /// Whether a task was started and `finish` was not called since.
  bool is_pending() const { return done_.valid(); }
  /// Whether nothing runs beside the calling thread any more. Requires a pending task.
  bool is_done() const;
  /// Waits for the pending task, frees it with all that it holds, and throws what it threw.
  void finish() { done_.get(); }

 private:
  std::future<void> done_;  // its destructor waits for the task
};

}  // namespace selvedge::detail
