// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/system/internal/terminal.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace selvedge {
namespace {

constexpr double kLinePeriod = 10.0;  // s between two lines in a log

std::string as_duration(double seconds) {
  const auto whole = static_cast<long>(seconds + 0.5);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

ProgressBar::ProgressBar(std::string unit, int total)
    : unit_(std::move(unit)), total_(total), on_(error_stream_is_terminal()) {}

void ProgressBar::show(int done, double seconds) {
  if (first_done_ < 0) {
    first_done_ = done;
    first_seconds_ = line_seconds_ = seconds;
  }
  if (!on_ && seconds < line_seconds_ + kLinePeriod) return;
  std::string left;
  if (done > first_done_)
    left = ", " + as_duration((seconds - first_seconds_) / (done - first_done_) * (total_ - done)) +
           " left";
  const std::string words =
      fmt::format("{} {} of {}, {}{}", unit_, done, total_, as_duration(seconds), left);
  if (!on_) {
    line_seconds_ = seconds;
    fmt::print(stderr, "{}\n", words);
    return;
  }
  constexpr int width = 30;
  const auto filled = static_cast<std::size_t>(static_cast<long>(width) * std::min(done, total_) /
                                               std::max(total_, 1));
  fmt::print(stderr, "\r\033[K[{}{}] {}", std::string(filled, '#'),
             std::string(width - filled, ' '), words);
  std::fflush(stderr);
  shown_ = true;
}

void ProgressBar::clear() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace selvedge
