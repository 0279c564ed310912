// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/option_values.h>

#include <stdexcept>

namespace selvedge {

void refuse_value(const std::string& option, const std::string& value, const std::string& wanted) {
  throw std::invalid_argument(option + " " + value + ": " + wanted);
}

std::optional<UpAxis> up_axis(const std::string& word) {
  if (word.empty()) return std::nullopt;
  return word == "x" ? UpAxis::x : word == "y" ? UpAxis::y : UpAxis::z;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> pieces;
  for (;;) {
    const std::size_t end = text.find(separator);
    pieces.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return pieces;
    text.remove_prefix(end + 1);
  }
}

std::vector<int> chosen_frames(const std::string& value, const std::vector<int>& all) {
  const auto pieces = split(value, ':');
  std::vector<int> bounds = {all.front(), all.back(), 1};
  bool good = pieces.size() <= 3;
  for (std::size_t i = 0; i < pieces.size() && good; ++i) {
    if (pieces[i].empty()) continue;
    const auto number = number_from<int>(pieces[i]);
    good = number && *number >= (i == 2 ? 1 : 0);
    if (good) bounds[i] = *number;
  }
  if (!good)
    refuse_value("--frames", value, "must be FIRST:LAST:STEP, such as 0:120:10, or one number");
  if (pieces.size() == 1) bounds[1] = bounds[0];
  std::vector<int> chosen;
  for (const int frame : all)
    if (frame >= bounds[0] && frame <= bounds[1] && (frame - bounds[0]) % bounds[2] == 0)
      chosen.push_back(frame);
  if (chosen.empty())
    refuse_value("--frames", value,
                 fmt::format("selects no frame; the frames are {} to {}", all.front(), all.back()));
  return chosen;
}

}  // namespace selvedge
