// SPDX-License-Identifier: MIT
//
// docs/lab/survey_map.md against `selvedge list` both ways, against the files and
// docs/lab/methods.md.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace selvedge::survey_map_test {
namespace {

namespace fs = std::filesystem;

const fs::path root = SELVEDGE_SOURCE_DIR;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) {
    const auto begin = cell.find_first_not_of(' '), end = cell.find_last_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

/// Every row of every table of a page but its head; the first cell is the row's name.
std::vector<std::vector<std::string>> rows_of(const std::string& page) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream in(page);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] != '|' || line.compare(0, 6, "| --- ") == 0) continue;
    if (line.compare(0, 7, "| row |") == 0) continue;
    rows.push_back(cells_of(line));
  }
  return rows;
}

std::vector<std::string> in_backticks(const std::string& cell) {
  std::vector<std::string> found;
  std::istringstream in(cell);
  std::string text;
  for (bool quoted = false; std::getline(in, text, '`'); quoted = !quoted)
    if (quoted) found.push_back(text);
  return found;
}

/// The methods of `selvedge list --json`.
nlohmann::json method_list() {
  const fs::path file = fs::path(::testing::TempDir()) /
                        ("selvedge_survey_map_" + std::to_string(getpid()) + ".json");
  const std::string command =
      "'" + std::string(SELVEDGE_PROGRAM) + "' list --json > '" + file.string() + "'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  const auto list = nlohmann::json::parse(read(file));
  fs::remove(file);
  return list["methods"];
}

/// "family: name" of each method; a row of the list may hold several, or a remark in brackets.
std::set<std::string> listed_methods() {
  std::set<std::string> names;
  for (const auto& method : method_list()) {
    const auto family = method["family"].get<std::string>();
    if (family == "body") continue;  // no table of the survey lists bodies
    std::istringstream parts(method["name"].get<std::string>());
    for (std::string name; std::getline(parts, name, ',');) {
      name.erase(0, name.find_first_not_of(' '));
      names.insert(family + ": " + name.substr(0, name.find(" (")));
    }
  }
  return names;
}

class SurveyMap : public ::testing::Test {
 protected:
  const std::vector<std::vector<std::string>> rows_ =
      rows_of(read(root / "docs/lab/survey_map.md"));
};

TEST_F(SurveyMap, NamesOnlyMethodsThatTheProgramLists) {
  const std::set<std::string> listed = listed_methods();
  for (const auto& row : rows_)
    for (const std::string& name : in_backticks(row[1]))
      EXPECT_TRUE(listed.contains(name)) << row[0] << " names " << name;
}

TEST_F(SurveyMap, HasEveryMethodThatTheProgramLists) {
  std::set<std::string> mapped;
  for (const auto& row : rows_)
    for (const std::string& name : in_backticks(row[1])) mapped.insert(name);
  for (const std::string& name : listed_methods())
    EXPECT_TRUE(mapped.contains(name)) << name << " is in no row of docs/lab/survey_map.md";
}

TEST(MethodList, DoesNotCallAMethodCorrectedThatIsAsPrinted) {
  int as_printed = 0;
  for (const auto& method : method_list()) {
    const auto name = method["name"].get<std::string>();
    if (!name.ends_with("_as_printed")) continue;
    ++as_printed;
    const auto says = method["guarantee"].get<std::string>() + method["source"].get<std::string>();
    EXPECT_EQ(says.find("corrected"), std::string::npos) << name << ": " << says;
  }
  EXPECT_GE(as_printed, 5);
}

TEST_F(SurveyMap, NamesFilesThatThereAre) {
  for (const auto& row : rows_) {
    const std::vector<std::string> files = in_backticks(row[2]);
    EXPECT_FALSE(files.empty()) << row[0];
    for (const std::string& file : files) EXPECT_TRUE(fs::exists(root / file)) << row[0] << file;
  }
}

TEST_F(SurveyMap, HasEveryRowOfTheSurveysTables) {
  const std::map<std::string, std::vector<std::string>> tables = {
      {"I", {"1", "2", "3", "4", "5", "6", "7", "8", "9", "10"}},
      {"III", {"1", "2", "3", "4", "5", "6", "7", "8", "9"}},
      {"IV", {"1", "2", "3", "4", "5", "6"}},
      {"V", {"1", "2", "3", "4", "5", "6a", "6b", "6c", "7a", "7b"}},
      {"VII", {"1a", "1b", "1c", "1d", "1e", "2", "3", "4"}},
      {"VIII", {"1a", "1b", "1c", "2", "3", "4", "5", "6"}},
      {"IX", {"1a", "1b", "2a", "2b", "2c", "2d", "3"}}};
  std::multiset<std::string> there;
  for (const auto& row : rows_) there.insert(row[0].substr(0, row[0].find(' ')));
  for (const auto& [table, numbers] : tables)
    for (const std::string& number : numbers)
      EXPECT_EQ(there.count(table + "." + number), 1u) << "row " << table << "." << number;
}

TEST_F(SurveyMap, EveryPaperOfARowIsInTheListOfMethods) {
  const std::string methods = read(root / "docs/lab/methods.md");
  for (const auto& row : rows_) {
    if (row.size() < 5) continue;  // beyond the survey
    const std::string author = row[3].substr(0, row[3].find_first_of(", "));
    EXPECT_NE(methods.find(author), std::string::npos)
        << row[0] << ": " << author << " is not in docs/lab/methods.md";
  }
}

}  // namespace

}  // namespace selvedge::survey_map_test
