// SPDX-License-Identifier: MIT
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <future>

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
