// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/internal/landmarks.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace selvedge::landmarks_test {
namespace {

namespace fs = std::filesystem;

TriangleMesh mannequin(const char* name) {
  return read_mesh(fs::path(SELVEDGE_SOURCE_DIR) / "data" / "bodies" / name);
}

/// Girths that the maker of our patterns measured (scripts/make_patterns.py), m.
TEST(Landmarks, GirthsOfTheMannequinAreThoseOfItsMaker) {
  const BodyLandmarks m = find_landmarks(mannequin("mannequin_arms_out.ply"));
  EXPECT_NEAR(m.waist.girth, 0.650, 0.005);
  EXPECT_NEAR(m.waist.middle.z(), 1.05, 0.01);
  EXPECT_NEAR(m.hips.girth, 0.970, 0.005);
  EXPECT_NEAR(m.bust.girth, 0.825, 0.015);
  EXPECT_NEAR(m.height, 1.69, 0.005);
  EXPECT_NEAR(m.crotch.z(), 0.75, 0.02);
  EXPECT_LT((m.left - Vec3::UnitX()).norm(), 0.05);
  EXPECT_LT((m.forward + Vec3::UnitY()).norm(), 0.05);
  for (int k = 0; k < 2; ++k) {
    const double side = k == 0 ? 1.0 : -1.0;
    EXPECT_NEAR(m.arms[k].upper.girth, 0.29, 0.03);
    EXPECT_GT(side * m.arms[k].tip.x(), 0.65);
    EXPECT_GT(side * m.legs[k].tip.x(), 0.1);
    EXPECT_GT(side * m.shoulder[k].x(), 0.15);
    EXPECT_GT(m.shoulder[k].z(), m.armpit[k].z() + 0.08);
    EXPECT_NEAR(m.neck_side[k].z(), 1.44, 0.02);
  }
}

TEST(Landmarks, GirthsDoNotChangeWithThePose) {
  const BodyLandmarks out = find_landmarks(mannequin("mannequin_arms_out.ply")),
                      down = find_landmarks(mannequin("mannequin.ply"));
  EXPECT_NEAR(out.waist.girth, down.waist.girth, 0.005);
  EXPECT_NEAR(out.hips.girth, down.hips.girth, 0.005);
  EXPECT_NEAR(out.neck.girth, down.neck.girth, 0.005);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(out.arms[k].lower.girth, down.arms[k].lower.girth, 0.01);
    EXPECT_NEAR(out.legs[k].upper.girth, down.legs[k].upper.girth, 0.01);
  }
}

TEST(Landmarks, ABodyThatLiesAndFacesAnywhereHasTheSameOnes) {
  TriangleMesh body = mannequin("mannequin_arms_out.ply");
  const BodyLandmarks upright = find_landmarks(body);
  const Mat3 turn = Eigen::AngleAxisd(1.9, Vec3(0.3, -0.7, 0.5).normalized()).toRotationMatrix();
  for (Vec3& x : body.vertices) x = turn * x + Vec3(0.4, 1.0, -2.0);
  const BodyLandmarks lying = find_landmarks(body);
  EXPECT_LT((lying.up - turn * upright.up).norm(), 1e-6);
  EXPECT_LT((lying.forward - turn * upright.forward).norm(), 1e-6);
  EXPECT_NEAR(lying.waist.girth, upright.waist.girth, 1e-3);
  EXPECT_NEAR(lying.hips.girth, upright.hips.girth, 2e-3);
  EXPECT_LT((lying.shoulder[0] - turn * upright.shoulder[0] - Vec3(0.4, 1.0, -2.0)).norm(), 1e-6);
}

TEST(Landmarks, PartsBesideThePersonAreIgnored) {
  TriangleMesh body = mannequin("mannequin_arms_out.ply");
  const BodyLandmarks alone = find_landmarks(body);
  const auto n = static_cast<std::int32_t>(body.vertices.size());
  for (const Vec3& x : {Vec3(3, 0, 0), Vec3(3.1, 0, 0), Vec3(3, 0.1, 0), Vec3(3, 0, 0.1)})
    body.vertices.push_back(x);
  for (const Triangle& t :
       {Triangle{0, 2, 1}, Triangle{0, 1, 3}, Triangle{0, 3, 2}, Triangle{1, 2, 3}})
    body.triangles.push_back({n + t[0], n + t[1], n + t[2]});
  EXPECT_EQ(find_landmarks(body).waist.girth, alone.waist.girth);
}

std::string fault_of(const TriangleMesh& body) {
  try {
    find_landmarks(body);
  } catch (const std::invalid_argument& fault) {
    return fault.what();
  }
  return "";
}

TEST(Landmarks, ABoxIsNoPerson) {
  TriangleMesh box;
  for (int i = 0; i < 8; ++i) box.vertices.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  EXPECT_NE(fault_of(box).find("not those of a head, two hands and two feet"), std::string::npos)
      << fault_of(box);
  EXPECT_NE(fault_of({}).find("no triangles"), std::string::npos);
}

}  // namespace
}  // namespace selvedge::landmarks_test
