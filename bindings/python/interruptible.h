// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>
#include <selvedge/core/base/internal/loop_watch.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <future>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge::python {

/// Thrown out of a call that the user interrupts.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

/// Reports of a long call, from whichever thread it runs in.
class Progress {
 public:
  /// `call`: a Python callable, or None.
  explicit Progress(pybind11::object call) : call_(std::move(call)) {}

  const std::atomic<bool>& stop() const { return stop_; }
  void request_stop() { stop_ = true; }

  /// Calls call(arguments...). Throws Interrupted after request_stop, and what the callable raises.
  template <class... Arguments>
  void report(Arguments... arguments) const {
    if (stop_) throw Interrupted();
    const pybind11::gil_scoped_acquire acquire;
    if (!call_.is_none()) call_(arguments...);
  }

 private:
  pybind11::object call_;
  std::atomic<bool> stop_{false};
};

/// Calls work() without the lock of the interpreter. The loops of `work` look for Ctrl-C and then
/// stop; what they were to change must not be used again. Python handles signals in its main
/// thread alone.
template <class Work>
auto stoppable(Work work) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{50};
  Clock::time_point looked = Clock::now();
  const auto interrupted = [&] {
    if (Clock::now() < looked + kLook) return false;
    looked = Clock::now();
    const pybind11::gil_scoped_acquire acquire;
    return PyErr_CheckSignals() != 0;
  };
  try {
    const pybind11::gil_scoped_release release;
    const LoopWatch watch(interrupted);
    return work();
  } catch (const LoopStopped&) {
    throw pybind11::error_already_set();  // what the signal raised
  }
}

/// Refuses a second thread while one uses an object without the lock of the interpreter.
class OneThread {
 public:
  /// `what`: "simulation". `busy` belongs to the object. Throws std::runtime_error.
  OneThread(std::atomic<bool>& busy, const char* what) : busy_(busy) {
    if (busy_.exchange(true))
      throw std::runtime_error(std::string("another thread uses this ") + what +
                               "; give each thread its own");
  }
  ~OneThread() { busy_ = false; }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  std::atomic<bool>& busy_;
};

/// Runs work() in another thread, while this one, which holds the lock of the interpreter, looks
/// for Ctrl-C. `work` asks `progress` often. Python handles signals in its main thread alone.
template <class Work>
auto run_interruptible(Progress& progress, Work work) {
  constexpr std::chrono::milliseconds kLook{50};
  std::future<decltype(work())> done;
  bool interrupted = false;
  {
    const pybind11::gil_scoped_release release;
    done = std::async(std::launch::async, std::move(work));
  }
  while (true) {
    {
      const pybind11::gil_scoped_release release;
      if (done.wait_for(interrupted ? std::chrono::milliseconds::max() / 1000 : kLook) ==
          std::future_status::ready)
        break;
    }
    if (!interrupted && PyErr_CheckSignals() != 0) {
      interrupted = true;
      progress.request_stop();
    }
  }
  if (!interrupted) return done.get();
  pybind11::error_already_set signal;  // keeps what the signal raised while the work ends
  try {
    (void)done.get();
  } catch (const std::exception&) {  // the work ended because it was asked to
  }
  throw signal;
}

}  // namespace selvedge::python
