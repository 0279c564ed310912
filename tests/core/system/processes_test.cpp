// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/core/system/internal/processes.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace selvedge::processes_test {
namespace {

using namespace std::chrono_literals;

// On a busy machine the clock says little about a child; its processor time does.
TEST(ChildProcessTime, OfOneThatComputesGrowsAndOfOneThatWaitsDoesNot) {
  const ChildProcess busy = run_in_copy([] {
    for (std::atomic<int> k = 0;; ++k) continue;
    return 0;
  });
  const ChildProcess waiting = run_in_copy([] {
    std::this_thread::sleep_for(1h);
    return 0;
  });
  const auto deadline = std::chrono::steady_clock::now() + 60s;
  while (!(busy.processor_s() > 0.1) && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);
  EXPECT_GT(busy.processor_s(), 0.1);
  EXPECT_LT(waiting.processor_s(), 0.05);
  busy.kill();
  waiting.kill();
}

}  // namespace
}  // namespace selvedge::processes_test
