// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_table.h>

#include <filesystem>
#include <string>

namespace selvedge {

struct PageConfig {
  bool pictures = true;    ///< thumbnails of the final frames
  int most_pictures = 60;  ///< of the first rows; more would make a page of megabytes
};

/// One HTML file that needs nothing but itself: plots, table, bars, pictures.
std::string compare_page(const std::filesystem::path& out, const CompareTable& table,
                         const PageConfig& config = {});

/// The page without its data (compare_page.html, compiled in).
const char* compare_page_template();

}  // namespace selvedge
