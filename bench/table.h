// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

/// Rows of text; the first row is the head.
class Table {
 public:
  explicit Table(std::vector<std::string> head) { rows_.push_back(std::move(head)); }
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }

  std::string text() const { return lines("", "  ", "", true, false); }
  std::string markdown() const { return lines("| ", " | ", " |", false, true); }
  std::string csv() const { return lines("", ",", "", false, false); }

 private:
  std::string lines(const char* begin, const char* between, const char* end, bool aligned,
                    bool ruled) const {
    std::vector<std::size_t> width(rows_[0].size(), 0);
    for (const auto& row : rows_)
      for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
    std::string out;
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      out += begin;
      for (std::size_t c = 0; c < rows_[r].size(); ++c) {
        if (c > 0) out += between;
        out += !aligned ? rows_[r][c]
               : c < 2  ? fmt::format("{:<{}}", rows_[r][c], width[c])
                        : fmt::format("{:>{}}", rows_[r][c], width[c]);
      }
      out += std::string(end) + "\n";
      if (ruled && r == 0) {
        for (std::size_t c = 0; c < rows_[0].size(); ++c) out += c < 2 ? "| --- " : "| ---: ";
        out += "|\n";
      }
    }
    return out;
  }

  std::vector<std::vector<std::string>> rows_;
};
