// SPDX-License-Identifier: MIT
//
// Scenes for the comparison of responses.
#pragma once

#include <selvedge/scene/scene.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <functional>
#include <string>
#include <vector>

namespace selvedge::bench {

/// A scene and its measure: `error` compares the run with a closed form, in `unit`.
struct ResponseCase {
  std::string name;
  Scene scene;
  std::vector<double> added_mass;  ///< kg, per particle; empty: none
  int frames = 60;
  int warm_up = 0;   ///< frames before the measurement starts
  std::string unit;  ///< of the error; empty: no error is measured
  /// Computes the error from the states at the end of the warm-up and of the run.
  std::function<double(const SimulationState& from, const SimulationState& to)> error;
};

/// Result of a run of a case.
struct ResponseRun {
  RunResult result;
  std::vector<Vec3> x;     ///< m, end positions
  double seconds = 0.0;    ///< processor time of the steps
  double error = 0.0;      ///< in the unit of the case
  double rms_speed = 0.0;  ///< m/s, at the end
  std::string stopped;     ///< why the run stopped early
};

ResponseCase ball(int cells);
ResponseCase table(int cells);
/// A sheet slides down 30 degrees with a friction of 0.3; error of its acceleration, per cent.
ResponseCase incline_sliding(int cells);
/// The same slope with a friction of 0.6, at which the sheet sticks; creep in mm/s.
ResponseCase incline_sticking(int cells);
/// A strip over half a cylinder with a friction of 0.3. The ratio of its loads is `share` of the
/// largest ratio that friction holds, 1 to exp(π μ). The measure is the speed of the lighter load,
/// mm/s, which is 0 below a share of 1. (Each step lifts cloth that slides around a bend by
/// v²h²/2r, because it moves on the planes of its contacts. This brakes the cloth, so its speed
/// above a share of 1 does not measure friction.)
ResponseCase capstan(double share);
/// Sheets that fall onto a floor and onto each other.
ResponseCase stack(int sheets, int cells);
/// A sheet falls flat from 20 cm; rebound over that height, per cent.
ResponseCase drop(int cells);

ResponseRun run(ResponseCase c, const std::string& response, const MethodOptions& options = {});

}  // namespace selvedge::bench
