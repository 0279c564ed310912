// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/signals.h>

#include <csignal>
#include <cstddef>
#include <iterator>

namespace selvedge {
namespace {

constexpr int kSignals[] = {SIGINT, SIGBREAK, SIGTERM};

std::atomic<bool> stop_requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);
void (*former_handlers[std::size(kSignals)])(int) = {};

// Windows restores the default handler before it calls this one, so a second signal ends the
// process.
void request_stop(int) { stop_requested = true; }

}  // namespace

StopOnSignal::StopOnSignal() {
  stop_requested = false;
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    former_handlers[i] = std::signal(kSignals[i], &request_stop);
}

StopOnSignal::~StopOnSignal() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i)
    std::signal(kSignals[i], former_handlers[i]);
}

const std::atomic<bool>* StopOnSignal::requested() const { return &stop_requested; }

// Windows has no such limit.
void report_large_files() {}

}  // namespace selvedge
