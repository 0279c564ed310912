// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/fabric_drape.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// A constant of the cloth that is looked for; searched by its decimal logarithm.
struct IdentifiedConstant {
  std::string name;                    ///< bending, shear or stretch
  double Material::*field;             ///< where it goes
  double lowest = 0.0, highest = 0.0;  ///< SI, > 0
};
/// bending (N·m), shear and stretch (N/m) with the bounds of cloth. Throws std::invalid_argument
/// naming one that is not known.
std::vector<IdentifiedConstant> identified_constants(const std::vector<std::string>& names);

/// What a drape is to come to.
struct DrapeTarget {
  double coefficient = 0.0;      ///< %
  std::vector<double> spectrum;  ///< m, amplitudes of the rim from order 0 on; empty: not known
};

/// A search for constants of cloth whose drape is the target's.
struct DrapeSearch {
  Material base;  ///< all that is not looked for
  DrapeTrial trial;
  DrapeTarget target;
  std::vector<IdentifiedConstant> constants;

  /// Constants of a point of the search, whose coordinates are logarithms to base 10.
  Material at(const std::vector<double>& logs) const;
  /// |DC - DC*| in points, and where the target has a spectrum, the distance of the amplitudes in
  /// percent of the specimen's radius beside it [Mongus2012].
  double misfit(const std::vector<double>& logs) const;
};

/// A point and what it is worth.
struct Candidate {
  std::vector<double> logs;
  double misfit = 0.0;
};

struct NelderMeadConfig {
  int evaluations = 60;    ///< at most
  double size = 0.5;       ///< of the first simplex, decades
  double smallest = 1e-3;  ///< decades: a simplex smaller than this has converged
};
/// Downhill simplex [NelderMead1965], kept within the bounds by clamping. Gradient-free, local.
Candidate nelder_mead(const DrapeSearch& search, std::vector<double> start,
                      const NelderMeadConfig& config, int& evaluations);

/// Populations between two generations; all that a resumed search needs.
struct GeneticState {
  int generation = 0;
  std::vector<std::vector<Candidate>> islands;
};
struct GeneticConfig {
  int generations = 8;
  int islands = 4;     ///< evolved at the same time, a thread each
  int population = 6;  ///< of each island, even, >= 4
  std::uint32_t seed = 1;
};
/// Whether this build has pagmo.
bool has_genetic();
/// Genetic algorithm by pagmo (simple GA: tournament, simulated binary crossover, polynomial
/// mutation) on islands in a ring: the best of each goes on to the next after every generation.
/// `kept` is told the state after every generation. Deterministic for any number of threads, and
/// resumed from `state` the same as in one go. Throws std::invalid_argument where the build has no
/// pagmo.
Candidate genetic(const DrapeSearch& search, const GeneticConfig& config, GeneticState state,
                  const std::function<void(const GeneticState&)>& kept);

}  // namespace selvedge
