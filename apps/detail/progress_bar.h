// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace selvedge {

/// Progress and remaining time on the error stream: one line on a terminal that is written anew; in
/// a pipe or file a further line every ten seconds, so that short work leaves none.
class ProgressBar {
 public:
  /// Takes the unit of progress, such as "frame", and the number of units.
  ProgressBar(std::string unit, int total);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(int done, double seconds);
  void clear();

 private:
  std::string unit_;
  int total_, first_done_ = -1;
  double first_seconds_ = 0.0, line_seconds_ = 0.0;
  bool on_, shown_ = false;
};

}  // namespace selvedge
