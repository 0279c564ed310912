// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/signals.h>

#include <csignal>
#include <cstddef>
#include <iterator>

namespace selvedge {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM};

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);
struct sigaction former_actions[std::size(kSignals)] = {};

}  // namespace

StopOnSignal::StopOnSignal() {
  stop_requested = false;
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    struct sigaction action {};
    action.sa_handler = [](int) { stop_requested = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(kSignals[i], &action, &former_actions[i]);
  }
}

StopOnSignal::~StopOnSignal() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    sigaction(kSignals[i], &former_actions[i], nullptr);
}

const std::atomic<bool>* StopOnSignal::requested() const { return &stop_requested; }

void report_large_files() { std::signal(SIGXFSZ, SIG_IGN); }

}  // namespace selvedge
