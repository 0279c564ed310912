// SPDX-License-Identifier: MIT
// The pages: README.md, docs/ (the manual) and docs/lab/ (the reports). Links lead to files and
// headings that are there, the manual stays small, and each report begins with its origin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace selvedge::pages_test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = SELVEDGE_SOURCE_DIR;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The lines of a page outside of its code blocks.
std::vector<std::string> prose_of(const std::string& page) {
  std::vector<std::string> lines;
  std::istringstream in(page);
  bool code = false;
  for (std::string line; std::getline(in, line);) {
    const bool fence = line.find("```") == line.find_first_not_of(' ') && !line.empty();
    if (fence) code = !code;
    if (!fence && !code) lines.push_back(line);
  }
  return lines;
}

/// The Markdown files of a folder, sorted.
std::vector<fs::path> pages_in(const fs::path& folder) {
  std::vector<fs::path> pages;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  std::sort(pages.begin(), pages.end());
  return pages;
}

std::vector<fs::path> all_pages() {
  std::vector<fs::path> pages = {kRoot / "README.md", kRoot / "CONTRIBUTING.md",
                                 kRoot / "SECURITY.md"};
  for (const char* folder : {"docs", "docs/lab"})
    for (const fs::path& page : pages_in(kRoot / folder)) pages.push_back(page);
  return pages;
}

/// The anchor of a heading, as GitHub forms it: letters and digits in lower case, - and _; a space
/// becomes -. Bytes of other characters than ASCII stay.
std::string anchor_of(const std::string& heading) {
  const std::string text =
      std::regex_replace(heading, std::regex(R"(\[([^\]]*)\]\([^)]*\))"), "$1");
  std::string anchor;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ') anchor += '-';
    if (std::isalnum(byte) != 0 || c == '-' || c == '_' || byte >= 0x80)
      anchor += static_cast<char>(std::tolower(byte));
  }
  return anchor;
}

std::set<std::string> anchors_of(const std::string& page) {
  std::set<std::string> anchors;
  for (const std::string& line : prose_of(page)) {
    const std::size_t begin = line.find_first_not_of('#');
    if (begin == 0 || begin == std::string::npos || line[begin] != ' ') continue;
    const std::string anchor = anchor_of(line.substr(begin + 1));
    std::string name = anchor;
    for (int again = 1; !anchors.insert(name).second; ++again)
      name = anchor + "-" + std::to_string(again);
  }
  return anchors;
}

/// The targets of the links of a page to files and headings of the repository.
std::vector<std::string> targets_of(const std::string& page) {
  std::vector<std::string> targets;
  const std::regex code("`[^`]*`"), link(R"(\]\(([^)\s]+)\))");
  for (const std::string& line : prose_of(page)) {
    const std::string text = std::regex_replace(line, code, "``");
    for (std::sregex_iterator i(text.begin(), text.end(), link), end; i != end; ++i) {
      const std::string target = (*i)[1];
      if (target.find("://") == std::string::npos && target.rfind("mailto:", 0) != 0)
        targets.push_back(target);
    }
  }
  return targets;
}

/// Why a link of a page leads nowhere; empty: it does not.
std::string fault_of(const fs::path& page, const std::string& target) {
  const std::size_t mark = target.find('#');
  const std::string file = target.substr(0, mark);
  const fs::path to = file.empty() ? page : page.parent_path() / file;
  if (!fs::exists(to)) return "no such file";
  if (mark == std::string::npos || to.extension() != ".md") return "";
  return anchors_of(read(to)).contains(target.substr(mark + 1)) ? "" : "no such heading";
}

/// Words as `wc -w` counts them.
std::size_t words_of(const std::string& page) {
  std::istringstream in(page);
  std::size_t count = 0;
  for (std::string word; in >> word;) ++count;
  return count;
}

TEST(Pages, HaveNoDeadLink) {
  for (const fs::path& page : all_pages())
    for (const std::string& target : targets_of(read(page)))
      EXPECT_EQ(fault_of(page, target), "")
          << page.lexically_relative(kRoot) << " links to " << target;
}

TEST(Pages, ADeadLinkIsFound) {
  const fs::path page = kRoot / "docs/program.md";
  EXPECT_EQ(fault_of(page, "no_such_page.md"), "no such file");
  EXPECT_EQ(fault_of(page, "glossary.md#no-such-heading"), "no such heading");
  EXPECT_EQ(fault_of(page, "glossary.md#distances"), "");
  EXPECT_EQ(targets_of("[a](b.md) `[c](d.md)`\n```\n[e](f.md)\n```\n[g](https://h.org)"),
            (std::vector<std::string>{"b.md"}));
  EXPECT_EQ(anchors_of("# A `b_c`, d\n## [E](f.md) g\n## A `b_c`, d\n"),
            (std::set<std::string>{"a-b_c-d", "a-b_c-d-1", "e-g"}));
}

TEST(Manual, HasAtMostTwentyPagesAnd25000Words) {
  const std::vector<fs::path> pages = pages_in(kRoot / "docs");
  EXPECT_LE(pages.size(), 20u);
  std::size_t words = 0;
  for (const fs::path& page : pages) words += words_of(read(page));
  EXPECT_LE(words, 25000u);
}

TEST(Reports, BeginWithDateMachineAndCommand) {
  const std::regex origin(
      R"(^# [^\n]+\n\nDate: \d{4}-\d\d-\d\d[^\n]*\. Machine: [^\n]+\. Command: [^\n]+\n)");
  for (const fs::path& page : pages_in(kRoot / "docs/lab")) {
    if (page.filename() == "README.md") continue;
    EXPECT_TRUE(std::regex_search(read(page), origin)) << page.lexically_relative(kRoot);
  }
}

TEST(Reports, AreListedOnOnePage) {
  const std::string list = read(kRoot / "docs/lab/README.md");
  for (const fs::path& page : pages_in(kRoot / "docs/lab")) {
    const std::string name = page.filename();
    if (name != "README.md") {
      EXPECT_NE(list.find("(" + name + ")"), std::string::npos) << name;
    }
  }
}

/// The words of a name such as EachWordBeginsWithACapital.
std::ptrdiff_t words_in_name(const std::string& name) {
  return std::count_if(name.begin(), name.end(),
                       [](unsigned char c) { return std::isupper(c) != 0; });
}

TEST(TestNames, HaveAtMostTwelveWords) {
  const std::regex test(R"(\bTEST(_F|_P)?\(\s*(\w+),\s*(\w+)\s*\))");
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "tests")) {
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
    const std::string text = read(entry.path());
    for (std::sregex_iterator i(text.begin(), text.end(), test), end; i != end; ++i)
      EXPECT_LE(words_in_name((*i)[3]), 12) << (*i)[2] << "." << (*i)[3];
  }
}

}  // namespace
}  // namespace selvedge::pages_test
