// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_table.h>

#include <filesystem>
#include <string>

namespace selvedge {

struct PageConfig {
  bool pictures = true;    ///< thumbnails of the final frames
  int most_pictures = 60;  ///< for the first rows; more would make the page megabytes large
};

/// A self-contained HTML file with plots, table, bars and pictures.
std::string compare_page(const std::filesystem::path& out, const CompareTable& table,
                         const PageConfig& config = {});

/// The page template without data (compare_page.html, compiled in).
const char* compare_page_template();

}  // namespace selvedge
