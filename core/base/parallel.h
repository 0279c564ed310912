// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

namespace selvedge {

/// A non-owning reference to a callable. It does not allocate and is valid while the callable
/// lives.
template <class Signature>
class FunctionRef;

template <class R, class... Args>
class FunctionRef<R(Args...)> {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef> &&
           std::is_invocable_r_v<R, F&, Args...>)
      FunctionRef(F&& f)  // NOLINT: implicit on purpose, as std::function
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(f)))),
        call_([](void* object, Args... args) -> R {
          return (*static_cast<std::remove_reference_t<F>*>(object))(std::forward<Args>(args)...);
        }) {}

  R operator()(Args... args) const { return call_(object_, std::forward<Args>(args)...); }

 private:
  void* object_;
  R (*call_)(void*, Args...);
};

/// Calls body(begin, end) on disjoint ranges that cover [0, n). The ranges depend only on n and
/// grain, not on the number of threads, so code that sums per range is deterministic.
void parallel_for(std::size_t n, std::size_t grain,
                  FunctionRef<void(std::size_t begin, std::size_t end)> body);

/// Sum of body(begin, end) over fixed ranges of size `grain`, added in range order: bit-identical
/// for any number of threads.
double parallel_sum(std::size_t n, std::size_t grain,
                    FunctionRef<double(std::size_t begin, std::size_t end)> body);

/// Runs both tasks, possibly in parallel, and returns when both are done.
void parallel_invoke(FunctionRef<void()> a, FunctionRef<void()> b);

/// Number of threads the library uses at present, outside of any ThreadArena.
int thread_count();

/// Limits the number of worker threads to `threads` during its lifetime (0: number of processors).
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Limits the threads of the tasks that it runs; all other loops of the process keep theirs.
class ThreadArena {
 public:
  /// Loops of a task use at most this many threads, >= 1.
  explicit ThreadArena(int threads);
  ~ThreadArena();
  ThreadArena(const ThreadArena&) = delete;
  ThreadArena& operator=(const ThreadArena&) = delete;

  /// Runs the task and returns when it is done. Passes its exceptions on.
  void run(FunctionRef<void()> task);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace selvedge
