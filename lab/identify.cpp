// SPDX-License-Identifier: MIT
//
// J. Louchet, X. Provot, D. Crochemore, "Evolutionary identification of cloth animation models",
// 1995, and D. Mongus et al., "A hybrid evolutionary algorithm for tuning a cloth-simulation
// model", Applied Soft Computing 12 (2012): identification of the constants of a mass-spring cloth
// from its drape.
#include <selvedge/lab/identify.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

const std::vector<IdentifiedConstant>& known_constants() {
  // Values beyond these bounds describe paper or foam, not cloth.
  static const std::vector<IdentifiedConstant> known = {
      {"bending", &Material::bending_stiffness, 1e-7, 1e-3},
      {"shear", &Material::shear_stiffness, 5.0, 500.0},
      {"stretch", &Material::stretch_stiffness, 50.0, 5000.0}};
  return known;
}

constexpr std::size_t orders = 13;  // of the rim that are compared; a drape has fewer folds

}  // namespace

std::vector<IdentifiedConstant> identified_constants(const std::vector<std::string>& names) {
  std::vector<IdentifiedConstant> chosen;
  for (const std::string& name : names) {
    const auto& known = known_constants();
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const IdentifiedConstant& c) { return c.name == name; });
    if (found == known.end())
      throw std::invalid_argument("identify: there is no constant \"" + name +
                                  "\" to look for; name bending, shear or stretch");
    chosen.push_back(*found);
  }
  if (chosen.empty())
    throw std::invalid_argument("identify: name at least one constant to look for");
  return chosen;
}

Material DrapeSearch::at(const std::vector<double>& logs) const {
  Material material = base;
  const double stretch = stretch_along_weft(base) / base.stretch_stiffness;
  const double bending =
      base.bending_stiffness > 0.0 ? bending_along_weft(base) / base.bending_stiffness : 1.0;
  for (std::size_t k = 0; k < constants.size(); ++k)
    material.*(constants[k].field) = std::pow(10.0, logs[k]);
  // The search varies the constant along warp. The constant along weft keeps its ratio to it.
  if (base.stretch_weft) material.stretch_weft = stretch * material.stretch_stiffness;
  if (base.bending_weft) material.bending_weft = bending * material.bending_stiffness;
  return material;
}

std::vector<double> SearchSpace::middle() const {
  std::vector<double> point;
  for (std::size_t k = 0; k < lowest.size(); ++k) point.push_back(0.5 * (lowest[k] + highest[k]));
  return point;
}

std::vector<double> DrapeSearch::middle() const { return space().middle(); }

SearchSpace DrapeSearch::space() const {
  SearchSpace space;
  for (const IdentifiedConstant& c : constants) {
    space.lowest.push_back(std::log10(c.lowest));
    space.highest.push_back(std::log10(c.highest));
  }
  space.residual = [this](const std::vector<double>& logs) { return residual(logs); };
  return space;
}

void DrapeSearch::aim_at(std::vector<double> values, std::uint32_t seed) {
  if (values.size() != constants.size())
    throw std::invalid_argument("identify: a synthetic target needs a value for each constant");
  std::vector<double> logs;
  for (const double value : values) {
    if (!(value > 0.0))
      throw std::invalid_argument("identify: the values of a synthetic target must be positive");
    logs.push_back(std::log10(value));
  }
  DrapeTrial known = trial;
  known.seed = seed;
  const DrapeOutcome outcome = drape(at(logs), known);
  target = {outcome.coefficient, outcome.rim.amplitude};
  synthetic = std::move(values);
}

double DrapeSearch::residual(const std::vector<double>& logs) const {
  const DrapeOutcome outcome = drape(at(logs), trial);
  const double points = std::abs(outcome.coefficient - target.coefficient);
  if (target.spectrum.empty()) return points;
  double square = 0.0;
  for (std::size_t n = 0; n < std::min(orders, target.spectrum.size()); ++n) {
    const double difference = outcome.rim.amplitude[n] - target.spectrum[n];
    square += difference * difference;
  }
  return points + 100.0 * std::sqrt(square) / trial.specimen;
}

namespace {

/// The simplex of the search, with the best point first.
class Simplex {
 public:
  Simplex(const SearchSpace& space, const NelderMeadConfig& config, int& evaluations)
      : space_(space), config_(config), evaluations_(evaluations) {}

  Candidate run(std::vector<double> start) {
    begin(std::move(start));
    while (left() > 0 && size() > config_.smallest) step();
    return points_.front();
  }

 private:
  using Point = std::vector<double>;

  int left() const { return config_.evaluations - evaluations_; }

  Candidate evaluate(Point logs) {
    for (std::size_t k = 0; k < logs.size(); ++k)
      logs[k] = std::clamp(logs[k], space_.lowest[k], space_.highest[k]);
    ++evaluations_;
    const double residual = space_.residual(logs);
    return {std::move(logs), residual};
  }

  void begin(Point start) {
    points_.push_back(evaluate(start));
    for (std::size_t k = 0; k < start.size(); ++k) {
      Point corner = start;
      corner[k] += config_.size;
      points_.push_back(evaluate(std::move(corner)));
    }
    sort();
  }

  void sort() {
    std::stable_sort(points_.begin(), points_.end(), [](const Candidate& a, const Candidate& b) {
      return a.residual < b.residual;
    });
  }

  double size() const {
    double largest = 0.0;
    for (const Candidate& point : points_)
      for (std::size_t k = 0; k < point.logs.size(); ++k)
        largest = std::max(largest, std::abs(point.logs[k] - points_.front().logs[k]));
    return largest;
  }

  /// Reflection of the worst point in the mean of the others. The result lies beyond the mean by
  /// `along` times the worst point's distance from it, or before it if `along` is negative.
  Point moved(double along) const {
    Point middle(points_.front().logs.size(), 0.0);
    const std::size_t others = points_.size() - 1;
    for (std::size_t i = 0; i < others; ++i)
      for (std::size_t k = 0; k < middle.size(); ++k) middle[k] += points_[i].logs[k] / others;
    for (std::size_t k = 0; k < middle.size(); ++k)
      middle[k] += along * (middle[k] - points_.back().logs[k]);
    return middle;
  }

  void step() {
    const Candidate reflected = evaluate(moved(1.0));
    if (reflected.residual < points_.front().residual) {
      Candidate expanded = evaluate(moved(2.0));
      points_.back() = expanded.residual < reflected.residual ? expanded : reflected;
    } else if (reflected.residual < points_[points_.size() - 2].residual) {
      points_.back() = reflected;
    } else {
      contract(reflected);
    }
    sort();
  }

  void contract(const Candidate& reflected) {
    const bool outside = reflected.residual < points_.back().residual;
    Candidate inner = evaluate(moved(outside ? 0.5 : -0.5));
    if (inner.residual < std::min(reflected.residual, points_.back().residual)) {
      points_.back() = std::move(inner);
      return;
    }
    for (std::size_t i = 1; i < points_.size(); ++i) {  // shrink towards the best
      Point halfway = points_[i].logs;
      for (std::size_t k = 0; k < halfway.size(); ++k)
        halfway[k] = 0.5 * (halfway[k] + points_.front().logs[k]);
      points_[i] = evaluate(std::move(halfway));
    }
  }

  const SearchSpace& space_;
  const NelderMeadConfig& config_;
  int& evaluations_;
  std::vector<Candidate> points_;
};

}  // namespace

Candidate nelder_mead(const SearchSpace& space, std::vector<double> start,
                      const NelderMeadConfig& config, int& evaluations) {
  if (start.size() != space.lowest.size())
    throw std::invalid_argument("nelder_mead: the start needs a coordinate for each constant");
  evaluations = 0;
  return Simplex(space, config, evaluations).run(std::move(start));
}

Candidate nelder_mead(const DrapeSearch& search, std::vector<double> start,
                      const NelderMeadConfig& config, int& evaluations) {
  return nelder_mead(search.space(), std::move(start), config, evaluations);
}

Candidate genetic(const DrapeSearch& search, const GeneticConfig& config, GeneticState state,
                  const std::function<void(const GeneticState&)>& kept) {
  return genetic(search.space(), config, std::move(state), kept);
}

}  // namespace selvedge
