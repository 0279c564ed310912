// SPDX-License-Identifier: MIT
//
// Tension tests of knitted swatches at the level of their yarn.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/lab/detail/clamped_specimen.h>

#include <cmath>
#include <string>
#include <vector>

namespace selvedge {
namespace {

void validate_trial(const KnitTrial& t) {
  const auto positive = [](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  positive("wales in 1/m", t.wales);
  positive("courses in 1/m", t.courses);
  positive("strain", t.strain);
  require(t.loops >= 4, "loops", t.loops, "at least 4");
  require(t.points >= 2, "points", t.points, "at least 2");
}

GridConfig grid_of(const KnitTrial& t) {
  const std::int32_t cells = t.loops - 1;
  return {cells / t.wales, cells / t.courses, cells, cells};
}

/// Length of the yarn in these places, m.
double yarn_length(const KnitTrial& t, const std::vector<Vec3>& x) {
  const KnitLayout at(grid_of(t), t.knit);
  double length = 0.0;
  for (std::int32_t row = 0; row < at.rows(); ++row)
    for (std::int32_t k = 0; k + 1 < at.on_course(); ++k)
      length += (x[at.on(0, row, k + 1)] - x[at.on(0, row, k)]).norm();
  return length;
}

}  // namespace

KnitLoop KnitTrial::loop() const { return {1.0 / wales, 1.0 / courses, knit.yarn.diameter()}; }

double KnitTrial::density() const {
  constexpr double kg_per_m = 1e-6;  // of a tex
  return kg_per_m * knit.yarn.tex * loop().length() * wales * courses;
}

double KnitTrial::tightness() const { return std::sqrt(knit.yarn.tex) / (100.0 * loop().length()); }

KnitTest pull_knit(const KnitTrial& trial, KnitPull pull) {
  validate_trial(trial);
  Material still;
  still.spring_damping = still.bending_damping = 0.0;
  detail::Specimen s;
  s.cloth = make_knit(grid_of(trial), trial.knit, still);
  s.surface = static_cast<std::size_t>(trial.loops) * trial.loops;
  const std::vector<Vec3> rest = s.cloth.surface.vertices;
  const bool along_courses = pull == KnitPull::course;
  s.along = along_courses ? Vec3::UnitX() : Vec3::UnitY();
  s.across = along_courses ? Vec3::UnitY() : Vec3::UnitX();
  s.length = (trial.loops - 1) / (along_courses ? trial.wales : trial.courses);
  s.width = trial.loops / (along_courses ? trial.courses : trial.wales);
  s.middle = s.width;
  KnitTest test;
  std::vector<Vec3> last;
  test.curve =
      detail::pull_specimen(s, detail::Clamps::flat_ends, trial.strain, trial.points, &last);
  for (std::size_t k = 0; k < test.curve.size(); ++k)
    test.curve[k].strain = trial.strain * static_cast<double>(k) / trial.points;
  test.yarn_strain = yarn_length(trial, last) / yarn_length(trial, rest) - 1.0;
  return test;
}

}  // namespace selvedge
