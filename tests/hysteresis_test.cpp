// SPDX-License-Identifier: MIT
//
// The loops of Kawabata's tests, driven through a scene's material: what the cloth of a scene keeps
// of the work done on it is the area of the loop that the material names.
#include <selvedge/core/force.h>
#include <selvedge/scene/scene.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Vectors = std::vector<Vec3>;

constexpr int cells = 10;
constexpr double size = 0.02, cell = size / cells;  // m: hinges of half a radian at 250 1/m

Scene scene_of(const std::string& material) {
  const fs::path file =
      fs::temp_directory_path() / ("hysteresis_test_" + std::to_string(getpid()) + ".json");
  std::ofstream(file) << R"({"geometry": [{"size": [0.02, 0.02], "cells": [10, 10]}],
    "materials": {"default": )"
                      << material << "}}";
  Scene scene = read_scene(file);
  fs::remove(file);
  return scene;
}

/// A cloth that is deformed step by step, and the work that this takes.
class Instrument {
 public:
  explicit Instrument(const std::string& material)
      : cloth_(build_scene(scene_of(material)).cloth),
        forces_(make_internal_forces(cloth_)),
        x_(cloth_.surface.vertices),
        still_(x_.size(), Vec3::Zero()) {}

  const Vectors& flat() const { return cloth_.surface.vertices; }

  /// J, from the shape it has to `next`.
  double work_to(const Vectors& next) {
    const Vectors before = forces_at(x_), after = forces_at(next);
    double work = 0.0;
    for (std::size_t i = 0; i < x_.size(); ++i)
      work -= 0.5 * (before[i] + after[i]).dot(next[i] - x_[i]);
    x_ = next;
    for (const auto& force : forces_) force->accept({x_, still_, cloth_.mass, 0.0});
    return work;
  }

 private:
  Vectors forces_at(const Vectors& x) const {
    Vectors f = still_;
    for (const auto& force : forces_) force->add_force({x, still_, cloth_.mass, 0.0}, f);
    return f;
  }

  ClothMesh cloth_;
  std::vector<std::unique_ptr<Force>> forces_;
  Vectors x_, still_;
};

/// Work over a closed loop between -most and most, once the loop has closed.
double work_of_loop(Instrument& instrument, double most,
                    const std::function<Vectors(double)>& shape) {
  constexpr int steps = 400;
  const auto go = [&](double from, double to) {
    double work = 0.0;
    for (int i = 1; i <= steps; ++i)
      work += instrument.work_to(shape(from + (to - from) * i / steps));
    return work;
  };
  go(0.0, most);
  return go(most, -most) + go(-most, most);
}

constexpr double yield_curvature = 10.0, yield_shear = 0.0087;  // 1/m, rad: as in the mesh

double bending_loop(const std::string& material) {
  Instrument instrument(material);
  constexpr double most = 250.0;  // 1/m, as KES-FB2 bends to
  return work_of_loop(instrument, most, [&](double curvature) {
    Vectors x = instrument.flat();
    if (curvature == 0.0) return x;
    for (Vec3& p : x) {
      // rolled with the chord of a cell kept: only hinges do work
      const double step = curvature * cell, r = 0.5 * cell / std::sin(0.5 * step);
      const double s = p.x() / cell * step;
      p = Vec3(r * std::sin(s), p.y(), r * (1.0 - std::cos(s)));
    }
    return x;
  });
}

TEST(Hysteresis, ABendingLoopOfASceneHasTheAreaThatItsMaterialSays) {
  constexpr double hb = 2e-4;                     // N
  const double area = (cells - 1) * cell * size;  // of the rows with hinges
  const double loop = 4.0 * hb * (250.0 - yield_curvature) * area;
  EXPECT_NEAR(bending_loop(R"({"bending_stiffness": 1e-5, "bending_friction": 2e-4})") / loop, 1.0,
              0.01);
  EXPECT_NEAR(bending_loop(R"({"bending_stiffness": 1e-5})") / loop, 0.0, 1e-3);
}

TEST(Hysteresis, ASheetInTheSceneBringsItsLoopWithIt) {
  // 2HB = 0.04 gf cm/cm: HB = 1.96133e-4 N
  const std::string sheet = R"json({"fabric": {"kind": "kes", "source": "us",
    "W": {"value": 20, "unit": "mg/cm2"}, "LT": {"value": 0.7, "unit": "1"},
    "EMT": {"value": 5, "unit": "%"}, "G": {"value": 0.7, "unit": "gf/(cm*deg)"},
    "B": {"warp": 0.12, "weft": 0.08, "unit": "gf*cm2/cm"},
    "2HB": {"value": 0.04, "unit": "gf*cm/cm"}}})json";
  const double area = (cells - 1) * cell * size;
  EXPECT_NEAR(bending_loop(sheet) / (4.0 * 1.96133e-4 * (250.0 - yield_curvature) * area), 1.0,
              0.01);
  const Material m = scene_of(sheet).materials.at("default");
  EXPECT_NEAR(m.bending_stiffness, 0.12 * 9.80665e-5, 1e-15);
  EXPECT_NEAR(bending_along_weft(m), 0.08 * 9.80665e-5, 1e-15);
}

TEST(Hysteresis, AShearLoopOfASceneHasTheAreaThatItsMaterialSays) {
  const auto loop_of = [](const std::string& material) {
    Instrument instrument(material);
    return work_of_loop(instrument, std::tan(0.14), [&](double slope) {
      Vectors x = instrument.flat();
      // sides keep their length, so that only corners do work
      const double angle = std::atan(slope);
      for (Vec3& p : x) p = Vec3(p.x() + std::sin(angle) * p.y(), std::cos(angle) * p.y(), 0.0);
      return x;
    });
  };
  constexpr double hg = 0.5;  // N/m
  const double loop = 4.0 * hg * (0.14 - yield_shear) * size * size;
  const std::string head = R"({"shear_law": "twisting", "bending_stiffness": 0)";
  EXPECT_NEAR(loop_of(head + R"(, "shear_friction": 0.5})") / loop, 1.0, 0.01);
  EXPECT_NEAR(loop_of(head + "}") / loop, 0.0, 1e-3);
}

}  // namespace
}  // namespace selvedge
