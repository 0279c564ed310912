// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/internal/mesh_groups.h>
#include <selvedge/bodies/mesh_file.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace selvedge::mesh_groups_test {
namespace {

namespace fs = std::filesystem;

class MeshGroups : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("selvedge_groups_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  std::string fault(const fs::path& file, const LoadConfig& config) const {
    try {
      load_mesh(file, config);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

const char* const kBody =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 9 9 9\n"
    "f 1 2 5\n"
    "g body torso\nf 1 2 3 4\n"
    "g helper-skirt\nusemtl Blue Cloth \nf 1 2 5\nf 2 3 6\n"
    "o left arm\ng\nusemtl\nf 3 4 5\n"
    "g unused\n";

TEST_F(MeshGroups, HaveTheTrianglesOfTheirFaces) {
  const GroupedMesh grouped = read_grouped_mesh(write("body.obj", kBody));
  EXPECT_EQ(grouped.mesh.triangles, read_mesh(folder_ / "body.obj").triangles);
  ASSERT_EQ(grouped.groups.size(), 6u);
  const auto expect = [&](std::size_t i, MeshGroup::Kind kind, const std::string& name,
                          const std::vector<std::int32_t>& triangles) {
    EXPECT_EQ(grouped.groups[i].kind, kind);
    EXPECT_EQ(grouped.groups[i].name, name);
    EXPECT_EQ(grouped.groups[i].triangles, triangles);
  };
  expect(0, MeshGroup::Kind::group, "body", {1, 2});
  expect(1, MeshGroup::Kind::group, "torso", {1, 2});
  expect(2, MeshGroup::Kind::group, "helper-skirt", {3, 4});
  expect(3, MeshGroup::Kind::material, "Blue Cloth", {3, 4});
  expect(4, MeshGroup::Kind::object, "left arm", {5});
  expect(5, MeshGroup::Kind::group, "unused", {});
}

TEST_F(MeshGroups, AreChosen) {
  const fs::path file = write("body.obj", kBody);
  LoadConfig config;
  EXPECT_EQ(load_mesh(file, config).triangles.size(), 6u);
  config.groups = {"torso"};
  const TriangleMesh torso = load_mesh(file, config);
  EXPECT_EQ(torso.triangles.size(), 2u);
  EXPECT_EQ(torso.vertices.size(), 4u) << "vertices that no face needs are left out";
  config.groups = {"torso", "left arm"};
  EXPECT_EQ(load_mesh(file, config).triangles.size(), 3u);
  config.groups = {"Blue Cloth"};
  EXPECT_EQ(load_mesh(file, config).triangles.size(), 2u);
}

TEST_F(MeshGroups, AWrongChoiceIsRefused) {
  const fs::path file = write("body.obj", kBody), ply = folder_ / "body.ply";
  LoadConfig config;
  config.groups = {"boody"};
  EXPECT_NE(fault(file, config).find("boody"), std::string::npos);
  EXPECT_NE(fault(file, config).find("helper-skirt"), std::string::npos) << "it lists the groups";
  config.groups = {"unused"};
  EXPECT_NE(fault(file, config).find("no triangle is left"), std::string::npos);
  const TriangleMesh mesh = read_mesh(file);
  write_ply(ply, mesh.vertices, mesh.triangles);
  EXPECT_NE(fault(ply, config).find("only OBJ files"), std::string::npos);
  config.groups = {"x"};
  EXPECT_NE(fault(write("quad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), config)
                .find("only OBJ files with statements"),
            std::string::npos);
}

TEST(MeshUnit, IsAskedForWhereTheSizeIsNotThatOfABody) {
  const auto question = [](double size) { return ask_about_unit(Vec3(0.1, size, 0.3)); };
  EXPECT_EQ(question(1.7), "");
  EXPECT_EQ(question(0.05), "");
  EXPECT_NE(question(1700).find("millimetres"), std::string::npos);
  EXPECT_NE(question(1700).find("0.001 m"), std::string::npos);
  EXPECT_NE(question(170).find("centimetres"), std::string::npos);
  EXPECT_NE(question(67).find("inches"), std::string::npos);
  EXPECT_NE(question(17).find("decimetres"), std::string::npos);
  EXPECT_NE(question(5.6).find("feet"), std::string::npos);
}

}  // namespace

}  // namespace selvedge::mesh_groups_test
