// SPDX-License-Identifier: MIT
#include <selvedge/run/run.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
const fs::path folder = fs::path(SELVEDGE_SOURCE_DIR) / "data/experiments";

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

TEST(Experiments, EveryTableOfTheSurveyHasAPresetWhoseHeaderNamesIt) {
  std::set<std::string> tables;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const std::string line = first_line(entry.path());
    if (!line.starts_with("// Table ")) continue;
    tables.insert(line.substr(9, line.find(':') - 9));
  }
  EXPECT_EQ(tables,
            (std::set<std::string>{"X", "XI", "XII", "XIII", "XIV", "XV", "XVI", "XVII", "XVIII"}));
}

TEST(Experiments, EachIsReadAndStartsWithoutACrossing) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const Scene scene = read_scene(entry.path());
    EXPECT_EQ(scene.name, entry.path().stem().string());
    EXPECT_NO_THROW(Simulation(scene, build_scene(scene))) << scene.name;
  }
}

}  // namespace
}  // namespace selvedge
