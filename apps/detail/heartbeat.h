// SPDX-License-Identifier: MIT
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace selvedge {

/// Says on the error stream what a command is doing, for work whose end is not known: on a terminal
/// one line that is written anew every second, in a pipe or file a further line every ten seconds.
/// Short work leaves no line.
class Heartbeat {
 public:
  /// `command` begins every line.
  explicit Heartbeat(std::string command);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

  /// The work from now on, such as "fabric 2 of 6". Removes the line on a terminal, so that results
  /// can be printed.
  void now(std::string work);

 private:
  void beat();
  void clear();

  std::string command_, work_;
  bool on_terminal_, shown_ = false, stop_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;  // last member: it uses the others
};

}  // namespace selvedge
