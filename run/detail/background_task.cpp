// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/run/detail/background_task.h>

#include <chrono>
#include <utility>

namespace selvedge::detail {

// Where the system has no thread left, the library defers the task as well.
void BackgroundTask::start(std::function<void()> task) {
  done_ = std::async(
      thread_count() > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred,
      std::move(task));
}

bool BackgroundTask::is_done() const {
  return done_.wait_for(std::chrono::seconds(0)) != std::future_status::timeout;
}

}  // namespace selvedge::detail
