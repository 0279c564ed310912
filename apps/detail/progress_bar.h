// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace selvedge {

/// One line on a terminal that shows progress and remaining time. Prints nothing to a pipe or file.
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
  double first_seconds_ = 0.0;
  bool on_, shown_ = false;
};

}  // namespace selvedge
