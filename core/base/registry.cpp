// SPDX-License-Identifier: MIT
#include <selvedge/core/base/registry.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

namespace selvedge {
namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

/// Damerau, A technique for computer detection and correction of spelling errors, 1964: insertions,
/// deletions, substitutions and swaps of neighbours (each part of a word edited at most once).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

std::string quoted(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "\"" : ", \"") + word + "\"";
  return list;
}

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  return buffer;
}

const MethodOption* find_option(const std::vector<MethodOption>& options, const std::string& name) {
  const auto found = std::find_if(options.begin(), options.end(),
                                  [&](const MethodOption& o) { return o.name == name; });
  return found == options.end() ? nullptr : &*found;
}

std::string unknown_option(const std::vector<MethodOption>& options, const std::string& name) {
  if (options.empty()) return "has no option \"" + name + "\" and no other option";
  std::vector<std::string> known;
  for (const MethodOption& option : options) known.push_back(option.name);
  return "has no option \"" + name + "\"; nearest is \"" + nearest_word(name, known) +
         "\", known are " + quoted(known);
}

}  // namespace

double MethodOptions::operator[](const std::string& name) const {
  const auto found = values_.find(name);
  if (found == values_.end())
    throw std::logic_error("option \"" + name + "\" is read but not registered");
  return found->second;
}

std::string nearest_word(const std::string& word, const std::vector<std::string>& known) {
  constexpr std::size_t kLongestWord = 100;  // a longer word is no misspelt name
  const std::string start = word.substr(0, kLongestWord);
  std::string best;
  std::size_t smallest = std::numeric_limits<std::size_t>::max();
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(start, candidate);
    if (distance < smallest) {
      smallest = distance;
      best = candidate;
    }
  }
  return best;
}

std::string option_fault(const std::vector<MethodOption>& options, const std::string& name,
                         double value) {
  const MethodOption* option = find_option(options, name);
  if (option == nullptr) return unknown_option(options, name);
  const std::string must = "needs \"" + name + "\" to be ";
  const std::string is = ", is " + text(value);
  if (!std::isfinite(value)) return must + "finite" + is;
  if (option->kind == OptionKind::boolean && value != 0.0 && value != 1.0)
    return must + "true or false" + is;
  if (option->kind == OptionKind::whole && value != std::floor(value))
    return must + "a whole number" + is;
  if (option->above_least && value <= option->least)
    return must + "greater than " + text(option->least) + is;
  if (value < option->least) return must + "at least " + text(option->least) + is;
  if (value > option->most) return must + "at most " + text(option->most) + is;
  return {};
}

MethodOptions complete_options(const std::string& method, const std::vector<MethodOption>& options,
                               const MethodOptions& given) {
  for (const auto& [name, value] : given)
    if (const std::string fault = option_fault(options, name, value); !fault.empty())
      throw std::invalid_argument(method + ": " + fault);
  MethodOptions all;
  for (const MethodOption& option : options)
    all.set(option.name, given.contains(option.name) ? given[option.name] : option.initial);
  return all;
}

MethodOptions known_options(const std::vector<MethodOption>& options, const MethodOptions& given) {
  MethodOptions known;
  for (const auto& [name, value] : given)
    if (find_option(options, name) != nullptr) known.set(name, value);
  return known;
}

std::string options_text(const std::vector<MethodOption>& options, const MethodOptions& values) {
  std::string list;
  for (const MethodOption& option : options) {
    if (!values.contains(option.name)) continue;
    const double value = values[option.name];
    const std::string shown = option.kind != OptionKind::boolean ? text(value)
                              : value != 0.0                     ? "true"
                                                                 : "false";
    const bool has_unit = !option.unit.empty() && option.unit != "1";
    list += (list.empty() ? "" : ", ") + option.name + " " + shown +
            (has_unit ? " " + option.unit : "");
  }
  return list;
}

std::string unknown_name(const std::string& name, const std::vector<std::string>& known,
                         const std::map<std::string, std::string>& absent) {
  if (const auto found = absent.find(name); found != absent.end())
    return "\"" + name + "\" needs " + found->second + ", which this build does not have";
  if (known.empty()) return "there is no \"" + name + "\" in this build, nor any other method";
  return "there is no \"" + name + "\" in this build; nearest is \"" + nearest_word(name, known) +
         "\", known are " + quoted(known);
}

}  // namespace selvedge
