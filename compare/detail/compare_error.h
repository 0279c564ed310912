// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_plan.h>
#include <selvedge/core/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// Root mean square distance between the end positions, over the extent of `b`. If the triangles
/// are the same, vertices correspond by index. Otherwise vertices of `a` are located on the start
/// of `b`, which must be the same surface with another triangulation.
double distance(const ClothEnds& a, const ClothEnds& b);

/// Richardson's estimate of convergence from three runs, coarse to fine [Roache1998], with the
/// observed order instead of the expected one.
struct Convergence {
  bool converges = false;
  double order = 0.0;        ///< log2 of the ratio of the two differences
  double uncertainty = 0.0;  ///< of the finest; without convergence the larger difference
  std::string sentence;
};
/// Arguments: the difference of the coarse and the middle run, and that of the middle and the fine
/// run.
Convergence judge_convergence(double coarse, double fine);

/// The reference for errors, relative to the extent of the cloth.
class ErrorMeasure {
 public:
  ErrorMeasure(std::filesystem::path out, const ComparePlan& plan, const Methods& methods);

  /// Empty without a reference, or if the cell wrote no end frame.
  std::optional<double> error(const std::string& cell) const;
  /// Errors below this value are not significant; 0 for a closed form.
  double uncertainty() const { return convergence_.uncertainty; }
  bool converges() const { return convergence_.converges; }
  /// A sentence that names the reference and its accuracy.
  const std::string& sentence() const { return convergence_.sentence; }

 private:
  std::optional<double> closed_form_error(const std::string& cell) const;

  std::filesystem::path out_;
  const Methods& methods_;
  ReferenceKind kind_;
  std::optional<ClothEnds> finest_;
  Convergence convergence_;
};

/// Distance that cloth slides along a slope in `t` seconds: ½ g (sin θ - μ cos θ) t², 0 if it
/// sticks.
double slide(double gravity, double slope, double friction, double t);

}  // namespace selvedge
