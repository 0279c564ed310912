// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/heartbeat.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/terminal.h>

#include <chrono>
#include <cstdio>
#include <utility>

namespace selvedge {

Heartbeat::Heartbeat(std::string command)
    : command_(std::move(command)),
      on_terminal_(error_stream_is_terminal()),
      thread_([this] { beat(); }) {}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    clear();
  }
  wake_.notify_one();
  thread_.join();
}

void Heartbeat::now(std::string work) {
  const std::lock_guard lock(mutex_);
  clear();
  work_ = std::move(work);
}

void Heartbeat::clear() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

void Heartbeat::beat() {
  using Clock = std::chrono::steady_clock;
  const auto period = std::chrono::seconds(on_terminal_ ? 1 : 10);
  const auto begin = Clock::now();
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, period, [this] { return stop_; })) {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(Clock::now() - begin);
    const std::string line = fmt::format("{}: {}{}{} s", command_, printable(work_),
                                         work_.empty() ? "" : ", ", seconds.count());
    if (on_terminal_) {
      fmt::print(stderr, "\r\033[K{}", line);
      std::fflush(stderr);
      shown_ = true;
    } else {
      fmt::print(stderr, "{}\n", line);
    }
  }
}

}  // namespace selvedge
