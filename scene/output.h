// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>
#include <selvedge/scene/tangle_report.h>
#include <selvedge/scene/vertex_flags.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// All writers but Pc2Writer go through a temporary file beside the target and a rename, and throw
/// std::runtime_error with file and cause (full disk, no permission).

/// How often a part was proved to do nothing and left out (scene/plan.h).
struct PlanFigures {
  std::int64_t asked = 0, left_out = 0;
  double saved_s = 0.0;  ///< s, at the mean of the times it was not; 0 if it always was
};

/// What a run says of itself; written as result.json with these names.
struct RunResult {
  /// No accepted state and no path between two with an intersection; of a run that started
  /// tangled: none from tangle.until_s on, and before it none outside of the tangle.
  bool clean = true;
  bool clean_elsewhere = true;  ///< none that does not belong to a tangle of the start
  int frames = 0;               ///< written, the start frame included
  int steps = 0;                ///< accepted
  int halvings = 0, retried_steps = 0;
  double wall_s = 0.0;
  std::map<std::string, double>
      phase_s;  ///< forces, solve, strain, broad_phase, narrow_phase, response, output
  int worst_self_intersections = 0, worst_body_intersections = 0;
  double max_penetration_m = 0.0;
  double max_stretch = 0.0;  ///< largest (L-L0)/L0 of any edge spring in any accepted state
  double strain_residual =
      0.0;  ///< largest excess over the strain limit left in any accepted state
  double final_max_speed = 0.0;  ///< m/s
  std::size_t peak_bytes = 0;
  TangleReport tangle;
  FlagCounts flags;        ///< vertices of which something is not guaranteed
  std::string state_hash;  ///< of all positions and velocities at the end
  std::string stopped;     ///< "" or why the run ended early
  /// e.g. solver iterations, contacts, zones; max_gap_lack_m: what a contact lacked of its rest gap
  std::map<std::string, double> counters;
  /// What the stages "response" and "fail_safe" gave and took (response/ledger.h has the meanings):
  /// steps, max_momentum_error, max_angular_error, energy_normal_J, energy_friction_J,
  /// energy_gained_J, energy_kinetic_J, and by _x, _y, _z to_particles and to_anchors (N·s),
  /// turn_particles and turn_anchors (N·m·s).
  std::map<std::string, std::map<std::string, double>> ledger;
  std::map<std::string, PlanFigures> plan;  ///< by part, since the run was started or resumed
  /// Of the last state (measures.h): strain_max, strain_rms, spring_strain_*, energy_*_J, and over
  /// an upright cylinder drape_coefficient (%), folds.
  std::map<std::string, double> measures;
};

/// A number that is not finite is written as the string "nan", "inf" or "-inf", never as null.
void write_result(const std::filesystem::path& file, const RunResult& result);

/// Result folder layout:
///   scene.json               the scene file as run (paths made absolute)
///   result.json
///   frames/cloth_00000.ply   double PLY, one per frame
///   frames/bodies_00000.ply  all bodies joined; one file if nothing moves, else one per frame
///   steps/cloth_000000.ply, steps/bodies_000000.ply   with --every-step, one per accepted state
///   pictures/frame_00000.png
///   checkpoint.ply           full state, written with each frame
///   failure/                 of a run that stopped (layout: failure_bundle.h)
///
/// Digits in those names.
inline constexpr int frame_file_digits = 5, step_file_digits = 6;

/// folder / stem_00042.extension; `digits` is the least number of digits.
std::filesystem::path numbered(const std::filesystem::path& folder, const std::string& stem,
                               int number, int digits, const std::string& extension);

/// ParaView: one .vtp (appended raw, double; per-point velocity unless `v` is empty) and the
/// .pvd series that names all, relative to its own folder.
void write_vtp(const std::filesystem::path& file, std::span<const Vec3> x, std::span<const Vec3> v,
               std::span<const Triangle> triangles);
void write_pvd(const std::filesystem::path& file, const std::vector<std::filesystem::path>& pieces,
               std::span<const double> times);

/// Blender: .pc2 point cache (float) for the mesh-cache modifier of a base mesh with the same
/// vertices. Frames go to the file as they come; the count in its header is raised after each, so
/// that at any moment the file is a valid cache of the frames that are complete. Throws
/// std::runtime_error with file and cause.
class Pc2Writer {
 public:
  /// Starts a new file for frames of `points` vertices; sample i belongs to Blender's frame 1 + i.
  Pc2Writer(const std::filesystem::path& file, std::size_t points);
  /// Goes on with a file that has at least `frames_kept` frames and drops what follows them. Throws
  /// std::invalid_argument when it is no cache of `points` vertices or has fewer frames.
  Pc2Writer(const std::filesystem::path& file, std::size_t points, int frames_kept);
  ~Pc2Writer();
  Pc2Writer(const Pc2Writer&) = delete;
  Pc2Writer& operator=(const Pc2Writer&) = delete;

  /// Throws std::invalid_argument for a wrong number of points or one outside the range of float.
  void append(std::span<const Vec3> x);
  int frames() const { return frames_; }

 private:
  std::filesystem::path file_;
  std::size_t points_ = 0;
  int frames_ = 0;
  int descriptor_ = -1;
};

}  // namespace selvedge
