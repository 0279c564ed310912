// SPDX-License-Identifier: MIT
//
// The exact check (judge/judge.h) of mesh files and of result folders.
#pragma once

#include <selvedge/judge/judge.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// Findings on one mesh: on its state and, if requested, on the path to the next one.
struct CheckFinding {
  std::string file;
  Verdict state;
  std::optional<PathVerdict> path;
  /// Intersections that the run did not report: of triangles without a vertex flagged as tangled.
  /// Only in result folders.
  std::size_t unflagged = 0;
  /// The next state has more vertices, or fewer, and none has moved: cells were split, or joined on
  /// the surface of the whole cell. So there is no path to it.
  bool refined = false, joined = false;
  bool merged = false;  ///< vertices become one on the path, as in a seam that has closed

  /// Whether there is an intersection, a vertex inside the body or a collision. Triangles that only
  /// touch in a state are no fault.
  bool is_faulty() const;
};

/// Mesh files in order of time. An empty name stands for no mesh.
struct MeshList {
  std::vector<std::string> meshes;
  std::vector<std::string> against;  ///< bodies: none, one for all meshes, or one for each
  std::string rest;                  ///< rest shape, from which strain is measured
  bool paths = false;                ///< also check the straight path from each mesh to the next
  std::string next, against_next;    ///< the end of a path from a single mesh, and the body there
};

/// Checks the meshes in order and calls `report` with each finding. Keeps two states in memory.
/// Throws std::invalid_argument with the file for a mesh that cannot be read or checked, and for
/// two ends of a path with different triangles.
void check_meshes(const MeshList& list, const std::function<void(const CheckFinding&)>& report);

/// Findings on a result folder.
struct ResultCheck {
  bool every_step = false;  ///< accepted states and their paths were checked, else frames
  /// The largest of each number over all states; the path numbers are sums.
  CheckFinding worst;
  std::size_t states = 0, paths = 0, refinements = 0, joins = 0, merges = 0;
  std::string first_faulty;  ///< file of the first state at fault or with a path at fault, or ""
  std::string last_faulty;   ///< of the last one
};

/// Checks every state and path of steps/ of a result folder, or every frame if there is no steps/,
/// in parallel. `rest` names the file of the rest shape; "": strains are not measured. `progress`,
/// which may be empty, is called with the number of checked states and of all states, by one thread
/// at a time. Throws std::invalid_argument like check_meshes, for the first state at fault.
ResultCheck check_result(const std::string& folder, const std::string& rest = {},
                         const std::function<void(int done, int of)>& progress = {});

}  // namespace selvedge
