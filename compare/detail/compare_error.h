// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/compare/compare_plan.h>
#include <selvedge/core/base/types.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge::detail {

/// Root mean square distance between the end positions, over the extent of `b`. If the triangles
/// are the same, vertices correspond by index. Otherwise vertices of `a` are located on the start
/// of `b`, which must be the same surface with another triangulation.
double distance(const ClothEnds& a, const ClothEnds& b);

/// Largest distance of an end vertex of either cloth to the end surface of the other, over the
/// extent of `b`. Cloth that slid along itself has none.
double hausdorff_distance(const ClothEnds& a, const ClothEnds& b);

/// A quantity in which a comparison measures errors: a distance of two shapes, or a number of each
/// run.
struct ErrorQuantity {
  std::string_view name;     ///< as in --error
  std::string_view unit;     ///< as it follows a number: "of the cloth's extent"
  std::string_view meaning;  ///< such as "drape coefficient"
  double (*distance)(const ClothEnds& a, const ClothEnds& b) = nullptr;
  /// Set if `distance` is null. Empty for a run without this quantity.
  std::optional<double> (*value)(const RunResult& result) = nullptr;
};
std::span<const ErrorQuantity> error_quantities();
/// Throws std::invalid_argument for an unknown name, with the nearest known one.
const ErrorQuantity& error_quantity(const std::string& name);

/// The end of a cell: of its first run, or of all members of its ensemble of seeds.
struct CellEnd {
  ClothEnds mean;     ///< mean positions
  double half = 0.0;  ///< half the 90 % interval of the mean shape, over the extent; 0 for one run
  std::vector<RunResult> results;  ///< of the members
};
/// Empty unless all members finished.
std::optional<CellEnd> read_cell_end(const std::filesystem::path& cell, int members);

/// A value, and half of its 90 % interval (Student's t) over the seeds; 0 for one run.
struct Difference {
  double value = 0.0, half = 0.0;
};
/// Difference of two cells: of their mean shapes, or of the means of their numbers.
std::optional<Difference> difference(const ErrorQuantity& quantity, const CellEnd& a,
                                     const CellEnd& b);

/// Richardson's estimate of convergence from three runs, coarse to fine [Roache1998], with the
/// observed order instead of the expected one.
struct Convergence {
  bool converges = false;
  double order = 0.0;        ///< log2 of the ratio of the two differences
  double uncertainty = 0.0;  ///< of the finest; without convergence the larger difference
  std::string sentence;
};
/// Arguments: the difference of the coarse and the middle run, and that of the middle and the fine
/// run. Refinements that differ by less than their interval over the seeds count as converged.
Convergence judge_convergence(const Difference& coarse, const Difference& fine,
                              std::string_view unit);

/// The reference for errors: a closed form or the refined runs.
class Reference {
 public:
  Reference(std::filesystem::path out, const ComparePlan& plan, const Methods& methods);

  /// How accurate the reference is in a quantity. Errors below the uncertainty are not significant;
  /// a closed form has none.
  Convergence convergence(const ErrorQuantity& quantity) const;
  /// Empty without a reference of this quantity.
  std::optional<Difference> error(const ErrorQuantity& quantity, const std::string& cell,
                                  const CellEnd& end) const;

 private:
  double closed_form_error(const std::string& cell, const ClothEnds& ends) const;

  std::filesystem::path out_;
  const Methods& methods_;
  ReferenceKind kind_;
  std::vector<CellEnd> levels_;  // coarse to fine; empty without a converged reference
  std::string fault_;            // why levels are missing; empty if none is
};

/// Distance that cloth slides along a slope in `t` seconds: ½ g (sin θ - μ cos θ) t², 0 if it
/// sticks.
double slide(double gravity, double slope, double friction, double t);

}  // namespace selvedge::detail
