// SPDX-License-Identifier: MIT
#include <selvedge/run/run.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace selvedge::experiments_test {
namespace {

namespace fs = std::filesystem;
const fs::path folder = fs::path(SELVEDGE_SOURCE_DIR) / "data/experiments";

/// The number of the survey's table that the description of a scene names, such as "XV"; "" for
/// other scenes.
std::string table_of(const fs::path& file) {
  std::ifstream in(file);
  const auto description = nlohmann::json::parse(in).at("description").get<std::string>();
  const std::string mark = " Table ";
  const auto at = description.find(mark);
  if (at == std::string::npos) return "";
  const auto begin = at + mark.size();
  return description.substr(begin, description.find(':', begin) - begin);
}

TEST(Experiments, EveryJsonFileOfTheDataIsReadByAStrictReader) {
  int files = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(SELVEDGE_SOURCE_DIR) / "data")) {
    if (entry.path().extension() != ".json") continue;
    std::ifstream in(entry.path());
    EXPECT_TRUE(nlohmann::json::accept(in)) << entry.path();  // comments are not accepted
    ++files;
  }
  EXPECT_GT(files, 50);
}

TEST(Experiments, EveryTableOfTheSurveyHasAPresetWhoseDescriptionNamesIt) {
  std::set<std::string> tables;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    if (const std::string table = table_of(entry.path()); !table.empty()) tables.insert(table);
  }
  EXPECT_EQ(tables,
            (std::set<std::string>{"X", "XI", "XII", "XIII", "XIV", "XV", "XVI", "XVII", "XVIII"}));
}

TEST(Experiments, EachIsReadAndStartsWithoutACrossing) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const Scene scene = read_scene(entry.path());
    EXPECT_EQ(scene.name, entry.path().stem().string());
    const Methods methods;
    EXPECT_NO_THROW(Simulation(scene, methods)) << scene.name;
  }
}

// -- the tables -----------------------------------------------------------------------------------

/// The rows of a table of the survey, as its preset has them.
struct Printed {
  std::string scene;
  std::string mesh;  ///< rectangular, adaptive, or what the preset's description puts in its place
  std::string extension;   ///< hooke, kawabata: stretch and shear
  std::string bending;     ///< hooke (hinges, nets or beams), kawabata, angle and its rate
  bool damped, wind, wet;  ///< external forces beside gravity
  bool limited;            ///< super-elastic problem: position correction
  bool implicit;           ///< numerical integration
  bool boxes;              ///< collision detection: AABB
  std::string response;    ///< "": the table has none
};

const std::vector<Printed>& printed() {
  static const std::vector<Printed> all = {
      // Table X
      {"x_provot", "rectangular", "hooke", "hooke", true, true, false, true, false, false,
       "inverse_dynamics"},
      {"x_provot_net", "net", "net", "net", true, true, false, true, false, false,
       "inverse_dynamics"},
      // Table XI
      {"xi_villard_corners", "adaptive", "hooke", "beam", true, true, false, true, false, false,
       "inverse_dynamics"},
      {"xi_villard_spheres", "adaptive", "hooke", "beam", true, true, false, true, false, false,
       "inverse_dynamics"},
      {"xi_villard_ball", "adaptive", "hooke", "beam", true, true, false, true, false, false,
       "inverse_dynamics"},
      // Table XII
      {"xii_ji", "rectangular", "kawabata", "kawabata", true, true, false, false, false, false, ""},
      // Tables XIII and XIV, whose rows slipped by one line
      {"xiii_horiba", "rectangular", "hooke", "hooke", true, true, false, false, false, false, ""},
      {"xiv_haiyan", "rectangular", "hooke", "hooke", true, false, false, false, false, false, ""},
      // Table XV; the angle of triangles needs a mesh of triangles
      {"xv_liu", "triangles", "hooke", "bridson", true, false, false, false, true, true, ""},
      // Table XVI; the skirt cannot take explicit steps
      {"xvi_zhang_table", "rectangular", "kawabata", "kawabata", true, false, false, false, false,
       true, "position_velocity"},
      {"xvi_zhang_skirt", "triangles", "kawabata", "kawabata", true, false, false, false, true,
       true, "position_velocity"},
      // Table XVII; friction as the response
      {"xvii_chen", "rectangular", "kawabata", "kawabata", true, false, true, false, true, false,
       "contact_force"},
      {"xvii_chen_garment", "triangles", "kawabata", "kawabata", true, false, true, false, true,
       false, "contact_force"},
      // Table XVIII; the mesh of the paper has one shear spring in a cell
      {"xviii_huang_hang", "simplified", "hooke", "hooke", true, true, false, false, true, true,
       ""},
      {"xviii_huang_ball", "simplified", "hooke", "hooke", true, true, false, false, true, true,
       ""},
  };
  return all;
}

std::string mesh_of(const ClothSpec& cloth) {
  const auto* grid = std::get_if<ClothGrid>(&cloth.shape);
  if (grid == nullptr) return "triangles";
  if (grid->refine.when == RefineSpec::When::curved) return "adaptive";
  return grid->pattern == "rectangular_net" ? "net" : grid->pattern;
}

std::string extension_of(const Material& material) {
  if (material.stretch_law == "hooke") return "hooke";
  if (material.stretch_law != "kawabata") return "another";
  return material.shear_friction > 0.0 ? "kawabata" : "kawabata without a loop";  // 2HG
}

std::string bending_of(const Material& material) {
  if (material.bending_law == "beam") return "beam";
  if (material.bending_law == "bridson") return "bridson";
  return material.bending_friction > 0.0 ? "kawabata" : "hooke";  // the loop 2HB
}

class ExperimentTables : public ::testing::TestWithParam<Printed> {};

TEST_P(ExperimentTables, ThePresetHasWhatTheTablePrints) {
  const Printed& table = GetParam();
  const Scene scene = read_scene(folder / (table.scene + ".json"));
  for (const ClothSpec& cloth : scene.cloths) {
    EXPECT_EQ(mesh_of(cloth), table.mesh);
    const Material& material = scene.materials.at(cloth.material);
    const bool net = table.mesh == "net";  // has its own springs
    EXPECT_EQ(net ? "net" : extension_of(material), table.extension);
    EXPECT_EQ(net ? "net" : bending_of(material), table.bending);
    EXPECT_GT(material.bending_stiffness, 0.0);
  }
  EXPECT_EQ(scene.gravity, Vec3(0.0, 0.0, -9.81));
  EXPECT_EQ(scene.air.viscous_drag > 0.0, table.damped);
  EXPECT_EQ(!scene.air.wind.isZero(0.0), table.wind);
  EXPECT_EQ(scene.water.has_value(), table.wet);
  EXPECT_EQ(scene.solver.limiter, table.limited ? "position" : "none");
  EXPECT_EQ(scene.solver.integrator, table.implicit ? "implicit_euler" : "symplectic_euler");
  EXPECT_TRUE(!table.boxes || scene.contact.broad_phase == "bvh_aabb");
  EXPECT_TRUE(table.response.empty() || scene.contact.response == table.response);
}

INSTANTIATE_TEST_SUITE_P(All, ExperimentTables, ::testing::ValuesIn(printed()),
                         [](const auto& info) { return info.param.scene; });

TEST(Experiments, EveryPresetOfATableIsComparedWithIt) {
  std::set<std::string> compared, presets;
  for (const Printed& table : printed()) compared.insert(table.scene);
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json" && !table_of(entry.path()).empty())
      presets.insert(entry.path().stem().string());
  EXPECT_EQ(compared, presets);
}

}  // namespace
}  // namespace selvedge::experiments_test
