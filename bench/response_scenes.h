// SPDX-License-Identifier: MIT
//
// The scenes on which responses are compared.
#pragma once

#include <selvedge/scene/simulation.h>

#include <functional>
#include <string>
#include <vector>

namespace selvedge::bench {

/// A scene, and what it asks: `error` of the run compared with a closed form, in `unit`.
struct ResponseCase {
  std::string name;
  Scene scene;
  std::vector<double> added_mass;  ///< kg, of each particle; empty: none
  int frames = 60;
  int warm_up = 0;   ///< frames before the measurement begins
  std::string unit;  ///< of the error; empty: none asked
  /// From the states at the end of the warm-up and of the run.
  std::function<double(const SimulationState& from, const SimulationState& to)> error;
};

/// What a run of a case came to.
struct ResponseRun {
  RunResult result;
  std::vector<Vec3> x;     ///< m, at the end
  double seconds = 0.0;    ///< of processor time in steps
  double error = 0.0;      ///< in the unit of the case
  double rms_speed = 0.0;  ///< m/s, at the end
  std::string stopped;     ///< why it ended early
};

ResponseCase ball(int cells);
ResponseCase table(int cells);
/// Slides down 30 degrees with a friction of 0.3: error of its acceleration, per cent.
ResponseCase incline_sliding(int cells);
/// The same with 0.6, which holds: creep in mm/s.
ResponseCase incline_sticking(int cells);
/// A strip over half a cylinder with a friction of 0.3, whose loads are `share` of what it holds,
/// 1 to exp(π μ): speed of the lighter one, mm/s, which is 0 below 1. (Cloth that slides around a
/// bend on the planes of its contacts is lifted by v²h²/2r in each step, which brakes it: how fast
/// it slides above 1 is no measure of friction.)
ResponseCase capstan(double share);
/// Sheets that fall on a floor and on each other.
ResponseCase stack(int sheets, int cells);
/// A sheet that falls flat from 20 cm: rebound over that height, per cent.
ResponseCase drop(int cells);

ResponseRun run(ResponseCase c, const std::string& response, const ResponseConfig& config = {});

/// Area of the drape seen from above, m².
double projected_area(const std::vector<Vec3>& x, std::span<const Triangle> triangles);

}  // namespace selvedge::bench
