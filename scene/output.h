// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// What a run says of itself; written as result.json with these names.
struct RunResult {
  bool clean = true;                       ///< no accepted state and no path between two with an intersection
  int frames = 0;                          ///< written, the start frame included
  int steps = 0;                           ///< accepted
  int halvings = 0, retried_steps = 0;
  double wall_s = 0.0;
  std::map<std::string, double> phase_s;   ///< forces, solve, strain, broad_phase, narrow_phase, response, output
  int worst_self_intersections = 0, worst_body_intersections = 0;
  double max_penetration_m = 0.0;
  double max_stretch = 0.0;                ///< largest (L-L0)/L0 of any edge spring in any accepted state
  double strain_residual = 0.0;            ///< largest excess over the strain limit left in any accepted state
  double final_max_speed = 0.0;            ///< m/s
  std::size_t peak_bytes = 0;
  std::string state_hash;                  ///< of all positions and velocities at the end
  std::string stopped;                     ///< "" or why the run ended early
  std::map<std::string, double> counters;  ///< e.g. solver iterations, contacts, zones
};

void write_result(const std::filesystem::path& file, const RunResult& result);

/// Result folder layout:
///   scene.json               the scene file as run (paths made absolute)
///   result.json
///   frames/cloth_00000.ply   double PLY, one per frame
///   frames/bodies_00000.ply  all bodies joined; one file if nothing moves, else one per frame
///   steps/cloth_000000.ply, steps/bodies_000000.ply   with --every-step, one per accepted state
///   pictures/frame_00000.png
///   checkpoint.ply           full state, written with each frame
std::filesystem::path numbered(const std::filesystem::path& folder, const std::string& stem,
                               int number, int digits, const std::string& extension);

/// ParaView: one .vtp (appended raw, double, per-point velocity) and the .pvd series that names all.
void write_vtp(const std::filesystem::path& file, std::span<const Vec3> x,
               std::span<const Vec3> v, std::span<const Triangle> triangles);
void write_pvd(const std::filesystem::path& file, const std::vector<std::filesystem::path>& pieces,
               std::span<const double> times);
/// Blender: .pc2 point cache of all frames (float) for the mesh-cache modifier of the base mesh.
void write_pc2(const std::filesystem::path& file, const std::vector<std::vector<Vec3>>& frames,
               double fps);

}  // namespace selvedge
