// SPDX-License-Identifier: MIT
#include <selvedge/apps/detail/numbered_files.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

std::optional<int> number_in(const std::string& name, const std::string& begin,
                             const std::string& end) {
  if (name.size() <= begin.size() + end.size() || !name.starts_with(begin) || !name.ends_with(end))
    return std::nullopt;
  const char* first = name.data() + begin.size();
  const char* stop = name.data() + name.size() - end.size();
  int number = 0;
  const auto [ptr, fault] = std::from_chars(first, stop, number);
  if (fault != std::errc() || ptr != stop || number < 0) return std::nullopt;
  return number;
}

}  // namespace

std::vector<int> numbers_of(const fs::path& folder, const std::string& stem) {
  std::vector<int> numbers;
  std::error_code error;
  if (!fs::exists(folder, error) && !error) return numbers;
  for (fs::directory_iterator it(folder, error), last; !error && it != last; it.increment(error))
    if (const auto number = number_in(it->path().filename().string(), stem + "_", ".ply"))
      numbers.push_back(*number);
  if (error) throw std::invalid_argument(folder.string() + ": cannot be read: " + error.message());
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace selvedge
