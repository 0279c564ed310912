// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <selvedge/core/base/internal/text.h>

#include <cstdio>
#include <string>
#include <utility>

namespace selvedge {

/// fmt::print for a terminal: names from files and paths may have control characters, which are
/// shown as \xNN. The commands print with this function alone.
template <class... Values>
void print_escaped(std::FILE* to, fmt::format_string<Values...> format, Values&&... values) {
  fmt::print(to, "{}", printable_lines(fmt::format(format, std::forward<Values>(values)...)));
}

template <class... Values>
void print_escaped(fmt::format_string<Values...> format, Values&&... values) {
  print_escaped(stdout, format, std::forward<Values>(values)...);
}

/// A JSON document in lines. Bytes that are no UTF-8 are replaced, and all control characters are
/// escaped as JSON has it.
template <class Json>
void print_document(const Json& json) {
  fmt::print("{}\n", printable_json(json.dump(2, ' ', false, Json::error_handler_t::replace)));
}

}  // namespace selvedge
