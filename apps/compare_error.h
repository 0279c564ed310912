// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/compare_folder.h>
#include <selvedge/core/triangle_mesh.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// Cloth of one run, at its start and at its end.
struct ClothEnds {
  std::vector<Vec3> start, end;  ///< m
  std::vector<Triangle> triangles;
  double extent() const;  ///< m, diagonal of the box around the start
};

/// None if the run left no end.
std::optional<ClothEnds> read_ends(const std::filesystem::path& cell);

/// Root mean square distance of the ends over the extent of `b`. Vertices correspond by number
/// where the triangles are the same; else vertices of `a` are looked up on the start of `b`, which
/// has to be the same surface cut into other triangles.
double distance(const ClothEnds& a, const ClothEnds& b);

/// How three runs, coarse to fine, close in on an answer: Richardson's estimate [Roache1998], with
/// the order observed and not the one expected.
struct Convergence {
  bool converges = false;
  double order = 0.0;        ///< log2 of the ratio of the two differences
  double uncertainty = 0.0;  ///< of the finest; where it does not converge, the larger difference
  std::string sentence;
};
/// Differences of the coarse and the middle run, and of the middle and the fine one.
Convergence judge_convergence(double coarse, double fine);

/// What errors are measured against: relative to the extent of the cloth.
class ErrorMeasure {
 public:
  ErrorMeasure(std::filesystem::path out, const ComparePlan& plan, const Methods& methods);

  /// None without reference, or if the cell left no end.
  std::optional<double> error(const std::string& cell) const;
  /// Errors below it mean nothing; 0 of a closed form.
  double uncertainty() const { return convergence_.uncertainty; }
  bool converges() const { return convergence_.converges; }
  /// What the reference is, and how good, in a sentence.
  const std::string& sentence() const { return convergence_.sentence; }

 private:
  std::optional<double> closed_form_error(const std::string& cell) const;

  std::filesystem::path out_;
  const Methods& methods_;
  ReferenceKind kind_;
  std::optional<ClothEnds> finest_;
  Convergence convergence_;
};

/// How far cloth slides along a slope in `t` seconds: ½ g (sin θ - μ cos θ) t², 0 where it sticks.
double slide(double gravity, double slope, double friction, double t);

}  // namespace selvedge
