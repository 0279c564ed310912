// SPDX-License-Identifier: MIT
//
// Scenes of `bench rest`.
#pragma once

#include <selvedge/scene/build.h>

#include <string>
#include <vector>

namespace selvedge::bench {

constexpr double kGravity = 9.81;  // m/s²

struct BenchOptions {
  std::vector<std::string> cases;
  double seconds = 0.0;  // 0: the duration of the case
  int steps_per_frame = 2;
  int cells = 0;
  int threads = 0;
  double tolerance = 1e-3;
  bool verbose = false;
};

/// No cloth and no body.
Scene empty_scene(const BenchOptions& options);
/// A square piece of cloth.
ClothSpec sheet(double size, int cells, const Vec3& where);
BodySpec body(const AnalyticShape& shape, int resolution = 16);
/// kg
double total_mass(const BuiltScene& built);

/// A sheet on a plane that is inclined by `angle`.
Scene incline_scene(const BenchOptions& options, double mu, double angle);
/// A strip that hangs with a load (kg) in jaws with friction 0.5, which press (m) into its rest gap
/// of 2 mm on each side.
Scene jaws_scene(const BenchOptions& options, double load, double press = 0.0008);

inline constexpr double kCapstanLoad = 0.02;         // kg, at the lighter end
inline constexpr double kCapstanLine = 0.02 * 0.04;  // kg/m, of the strip
inline constexpr int kCapstanAcross = 4;             // cells

/// A strip over a cylinder of radius 0.1 m with loads of m1 and ratio·m1 at its ends.
struct Capstan {
  Scene scene;
  BuiltScene built;
  std::vector<std::int32_t> left, right;  // end particles
};

Capstan capstan(const BenchOptions& options, double ratio, double mu, int resolution,
                double stretch);

/// Prints how far cloth creeps that should stick, beside the contact forces: in jaws, around a
/// cylinder and on a slope, with the steps of the options and with shorter ones.
void creep_case(const BenchOptions& options);
/// Prints how fast three scenes of data/scenes come to rest: unbalanced force against time, by
/// dynamics and by quasi-static steps.
void equilibrium_case(const BenchOptions& options);
/// Prints the ends of ten seeds of two scenes, by both.
void spread_case(const BenchOptions& options);

}  // namespace selvedge::bench
