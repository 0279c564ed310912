// SPDX-License-Identifier: MIT
// Loops that are stopped while they run.
#include <gtest/gtest.h>
#include <selvedge/core/base/internal/loop_watch.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace selvedge::loop_watch_test {
namespace {

/// Ranges that a loop within a loop has run, of 1,000 x 1,000.
int ranges_run(const std::atomic<bool>& asked) {
  std::atomic<int> run{0};
  const auto stops = [&] { return asked || run > 2000; };
  const LoopWatch watch(stops);
  try {
    parallel_for(1000, 1, [&](std::size_t, std::size_t) {
      parallel_for(1000, 1, [&](std::size_t, std::size_t) { ++run; });
    });
  } catch (const LoopStopped&) {
  }
  return run;
}

TEST(LoopWatch, StopsLoopsWithinLoopsInAllThreads) {
  for (const int threads : {1, 4}) {
    const ThreadLimit limit(threads);
    EXPECT_LT(ranges_run(false), 900'000) << threads;
    EXPECT_EQ(ranges_run(true), 0) << threads;
  }
}

TEST(LoopWatch, ThrowsOnceItIsAskedToAndLeavesOtherThreadsAlone) {
  const auto always = [] { return true; };
  const LoopWatch watch(always);
  EXPECT_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) {}), LoopStopped);
  std::thread other([] { EXPECT_NO_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) {})); });
  other.join();
}

TEST(LoopWatch, EndsWithItsLifetimeAndLetsTheOuterOneGoOn) {
  const auto always = [] { return true; };
  const auto never = [] { return false; };
  {
    const LoopWatch outer(always);
    {
      const LoopWatch inner(never);
      EXPECT_NO_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) {}));
    }
    EXPECT_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) {}), LoopStopped);
  }
  EXPECT_NO_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) {}));
}

TEST(LoopWatch, AnErrorOfALoopIsPassedOn) {
  const auto never = [] { return false; };
  const LoopWatch watch(never);
  EXPECT_THROW(parallel_for(10, 1, [](std::size_t, std::size_t) { throw std::domain_error(""); }),
               std::domain_error);
}

}  // namespace
}  // namespace selvedge::loop_watch_test
