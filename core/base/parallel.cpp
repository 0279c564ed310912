// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/loop_watch.h>
#include <selvedge/core/base/internal/serial_loops.h>
#include <selvedge/core/base/parallel.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <vector>

#ifdef SELVEDGE_USE_TBB
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>
#endif

namespace selvedge {
namespace {

std::size_t range_count(std::size_t n, std::size_t grain) {
  return (n + std::max<std::size_t>(grain, 1) - 1) / std::max<std::size_t>(grain, 1);
}

#if defined(SELVEDGE_USE_TBB) && defined(__SANITIZE_THREAD__)
/// Makes the ordering of tasks visible to ThreadSanitizer, which cannot see it in the distributed
/// oneTBB: a task starts after it is submitted and ends before the caller continues. These atomics
/// express exactly that and do not order tasks among each other, so races between tasks are still
/// detected.
class Handover {
 public:
  void hand_out() { out_.store(1, std::memory_order_release); }
  void begin() { out_.load(std::memory_order_acquire); }
  void end() { done_.fetch_add(1, std::memory_order_release); }
  void collect() { done_.load(std::memory_order_acquire); }

 private:
  std::atomic<int> out_{0}, done_{0};
};
#else
struct Handover {
  void hand_out() {}
  void begin() {}
  void end() {}
  void collect() {}
};
#endif

// The watch over the loops of this thread; null: none.
thread_local LoopWatch* loop_watch = nullptr;

// The loops of this thread run in it alone.
thread_local bool loops_are_serial = false;

/// A range of a loop: has the watch of the loop, in whichever thread it runs.
class WatchedRange {
 public:
  explicit WatchedRange(LoopWatch* watch) : outer_(loop_watch) {
    if (watch == nullptr) return;
    watch->look();
    loop_watch = watch;
  }
  ~WatchedRange() { loop_watch = outer_; }
  WatchedRange(const WatchedRange&) = delete;
  WatchedRange& operator=(const WatchedRange&) = delete;

 private:
  LoopWatch* outer_;
};

// Largest number of partial sums of parallel_sum that need no heap memory: 4 KiB.
constexpr std::size_t kFewRanges = 512;

}  // namespace

LoopWatch::LoopWatch(FunctionRef<bool()> stops)
    : stops_(stops), owner_(std::this_thread::get_id()), outer_(loop_watch) {
  loop_watch = this;
}

LoopWatch::~LoopWatch() { loop_watch = outer_; }

void LoopWatch::look() {
  if (!stopped_ && std::this_thread::get_id() == owner_ && stops_()) stopped_ = true;
  if (stopped_) throw LoopStopped();
}

void parallel_for(std::size_t n, std::size_t grain,
                  FunctionRef<void(std::size_t, std::size_t)> body) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t ranges = range_count(n, grain);
  const auto run = [&, watch = loop_watch](std::size_t r) {
    const WatchedRange range(watch);
    body(r * grain, std::min(n, (r + 1) * grain));
  };
#ifdef SELVEDGE_USE_TBB
  if (ranges > 1 && !loops_are_serial) {
    Handover handover;
    handover.hand_out();
    tbb::parallel_for(std::size_t{0}, ranges, [&](std::size_t r) {
      handover.begin();
      run(r);
      handover.end();
    });
    handover.collect();
    return;
  }
#endif
  for (std::size_t r = 0; r < ranges; ++r) run(r);
}

double parallel_sum(std::size_t n, std::size_t grain,
                    FunctionRef<double(std::size_t, std::size_t)> body) {
  grain = std::max<std::size_t>(grain, 1);
  const std::size_t ranges = range_count(n, grain);
  // A solver calls this several times per iteration; up to a million particles it does not
  // allocate.
  std::array<double, kFewRanges> few;
  std::vector<double> many(ranges > few.size() ? ranges : 0);
  const std::span<double> partial = many.empty() ? std::span(few).first(ranges) : std::span(many);
  parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    partial[begin / grain] = body(begin, end);
  });
  double sum = 0.0;
  for (const double p : partial) sum += p;
  return sum;
}

#ifdef SELVEDGE_USE_TBB

void parallel_invoke(FunctionRef<void()> a, FunctionRef<void()> b) {
  if (loops_are_serial) {
    a();
    b();
    return;
  }
  Handover handover;
  handover.hand_out();
  const auto piece = [&, watch = loop_watch](FunctionRef<void()> work) {
    const WatchedRange range(watch);
    handover.begin();
    work();
    handover.end();
  };
  tbb::parallel_invoke([&] { piece(a); }, [&] { piece(b); });
  handover.collect();
}

int thread_count() {
  return static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct ThreadLimit::State {
  tbb::global_control control;
};

ThreadLimit::ThreadLimit(int threads)
    : state_(new State{
          {tbb::global_control::max_allowed_parallelism,
           static_cast<std::size_t>(threads > 0 ? threads : tbb::info::default_concurrency())}}) {}

struct ThreadArena::State {
  explicit State(int n) : threads(n), arena(n) {}
  int threads;
  tbb::task_arena arena;  // takes no thread before its first task
};

ThreadArena::ThreadArena(int threads) : state_(new State(std::max(threads, 1))) {}

void ThreadArena::run(FunctionRef<void()> task) {
  if (loops_are_serial || state_->threads >= thread_count()) return task();
  state_->arena.execute([&] { task(); });
}

void run_isolated(FunctionRef<void()> task) {
  tbb::this_task_arena::isolate([&] { task(); });
}

#else

void parallel_invoke(FunctionRef<void()> a, FunctionRef<void()> b) {
  a();
  b();
}

int thread_count() { return 1; }

struct ThreadLimit::State {};

ThreadLimit::ThreadLimit(int) : state_(new State) {}

struct ThreadArena::State {};

ThreadArena::ThreadArena(int) {}

void ThreadArena::run(FunctionRef<void()> task) { task(); }

void run_isolated(FunctionRef<void()> task) { task(); }

#endif

SerialLoops::SerialLoops() : outer_(loops_are_serial) { loops_are_serial = true; }
SerialLoops::~SerialLoops() { loops_are_serial = outer_; }

ThreadLimit::~ThreadLimit() = default;
ThreadArena::~ThreadArena() = default;

}  // namespace selvedge
