// SPDX-License-Identifier: MIT
//
// The loops of Kawabata's tests, driven through a scene's material: what the cloth of a scene keeps
// of the work done on it is the area of the loop that the material names.
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/solver/integrator.h>
#include <selvedge/scene/build.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

namespace selvedge::hysteresis_test {
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

  /// J, of what it has the shape of.
  double energy() const {
    double sum = 0.0;
    for (const auto& force : forces_) sum += force->energy({x_, still_, cloth_.mass, 0.0});
    return sum;
  }

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

TEST(Hysteresis, ABendingLoopOfASceneHasTheAreaOfItsMaterial) {
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

TEST(Hysteresis, AShearLoopOfASceneHasTheAreaOfItsMaterial) {
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
  for (const char* law : {"twisting", "angle"}) {
    const std::string head = R"({"bending_stiffness": 0, "shear_law": ")" + std::string(law) + "\"";
    EXPECT_NEAR(loop_of(head + R"(, "shear_friction": 0.5})") / loop, 1.0, 0.01) << law;
    EXPECT_NEAR(loop_of(head + "}") / loop, 0.0, 1e-3) << law;
  }
}

/// A KES sheet of which only tension counts: LT 0.7, EMT 4 and 6 %.
std::string tension_sheet(const std::string& rt) {
  return R"json({"bending_stiffness": 0, "fabric": {"kind": "kes", "source": "us",
    "W": {"value": 20, "unit": "mg/cm2"}, "LT": {"value": 0.7, "unit": "1"},
    "EMT": {"warp": 4, "weft": 6, "unit": "%"}, "RT": )json" +
         rt + R"json(, "G": {"value": 0.7, "unit": "gf/(cm*deg)"},
    "B": {"value": 0, "unit": "gf*cm2/cm"}}})json";
}

constexpr double emt = 0.05;  // the mean, at which the one curve ends

/// Stretched along warp by `strain`, held along weft.
Vectors stretched(const Instrument& instrument, double strain) {
  Vectors x = instrument.flat();
  for (Vec3& p : x) p.x() *= 1.0 + strain;
  return x;
}

double work_to(Instrument& instrument, double from, double to) {
  constexpr int steps = 400;
  double work = 0.0;
  for (int i = 1; i <= steps; ++i)
    work += instrument.work_to(stretched(instrument, from + (to - from) * i / steps));
  return work;
}

TEST(Hysteresis, ATensionLoopGivesBackWhatTheSheetsResilienceSays) {
  for (const double rt : {35.0, 62.0, 100.0}) {
    const std::string text = R"({"value": )" + std::to_string(rt) + R"(, "unit": "%"})";
    Instrument instrument(tension_sheet(text));
    // WT = LT/2 · 500 gf/cm · EMT, at a slope of rest that is warp's: 5/4 of the mean's.
    const double wt = 0.5 * 0.7 * 500.0 * 0.980665 * emt * 1.25 * size * size;
    const double there = work_to(instrument, 0.0, emt), back = -work_to(instrument, emt, 0.0);
    EXPECT_NEAR(there / wt, 1.0, 0.001) << rt;
    EXPECT_NEAR(back / (0.01 * rt * there), 1.0, 0.001) << rt;
    // So does a loop of half the height, and one beyond the end of the test.
    for (const double most : {0.5 * emt, 1.5 * emt}) {
      const double again = work_to(instrument, 0.0, most);
      EXPECT_NEAR(-work_to(instrument, most, 0.0) / (0.01 * rt * again), 1.0, 0.01) << rt;
    }
  }
}

TEST(Hysteresis, OnPartOfATensionLoopEnergyIsOnlyLost) {
  Instrument instrument(tension_sheet(R"({"warp": 40, "weft": 50, "unit": "%"})"));
  const double wt = 0.5 * 0.7 * 500.0 * 0.980665 * emt * 1.25 * size * size;
  double strain = 0.0, lost = 0.0, most_lost = 0.0;
  for (const double next : {0.03, 0.01, 0.02, 0.04, 0.015, 0.05, 0.0, 0.02, -0.01, 0.03, 0.0}) {
    constexpr int steps = 200;
    for (int i = 1; i <= steps; ++i) {
      const double before = instrument.energy(), at = strain + (next - strain) * i / steps;
      const double work = instrument.work_to(stretched(instrument, at));
      lost += work - (instrument.energy() - before);
      EXPECT_GT(lost, most_lost - 1e-4 * wt) << next << " at " << at;  // a trapezoid's error
      most_lost = std::max(most_lost, lost);
    }
    strain = next;
  }
  EXPECT_GT(lost, 0.55 * wt);
}

TEST(Hysteresis, AnImplicitStepOnATensionLoopIsStableAndLosesEnergy) {
  const std::vector<Spring> spring{{0, 1, 1.0, 1000.0}};
  for (const char* method : {"implicit_euler", "implicit_newton"}) {
    for (const double h : {0.001, 0.05}) {
      std::vector<std::unique_ptr<Force>> forces;
      forces.push_back(make_curve_force(spring, {"kawabata", 0.05, 0.7, 0.4}, 2));
      const auto integrator = integrators().at(method)(std::move(forces), 2, {});
      const auto weighed = make_curve_force(spring, {"kawabata", 0.05, 0.7, 0.4}, 2);
      Particles p{{{0, 0, 0}, {1.06, 0, 0}}, Vectors(2, Vec3::Zero()), {1.0, 1.0}, {0.0, 1.0}};
      double energy = weighed->energy({p.x, p.v, p.mass, 0.0});
      const double first = energy;
      for (int step = 0; step < 1000; ++step) {
        Vectors mean = p.v, v = p.v;
        integrator->begin({p, 0.0, h}, {mean, v});
        integrator->solve({}, {mean, v}, 1.0);
        for (int i = 0; i < 2; ++i) p.x[i] += h * mean[i];
        p.v = std::string(method) == "implicit_euler" ? mean : v;
        const ForceState state{p.x, p.v, p.mass, 0.0};
        integrator->accept(state);
        weighed->accept(state);
        const double now = weighed->energy(state) + 0.5 * p.v[1].squaredNorm();
        EXPECT_LT(now - energy, 1e-3 * first) << method << " " << h << " " << step;
        energy = now;
      }
      EXPECT_LT(energy, 0.1 * first) << method << " " << h;
    }
  }
}

}  // namespace
}  // namespace selvedge::hysteresis_test
