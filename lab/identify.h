// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/lab/fabric_drape.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace selvedge {

/// A cloth constant to identify. The search works on its decimal logarithm.
struct IdentifiedConstant {
  std::string name;                    ///< bending, shear or stretch
  double Material::*field;             ///< field of the material that holds it
  double lowest = 0.0, highest = 0.0;  ///< search bounds, SI, > 0
};
/// The named constants with the bounds of real cloth: bending (N·m), shear and stretch (N/m).
/// Throws std::invalid_argument that names an unknown constant.
std::vector<IdentifiedConstant> identified_constants(const std::vector<std::string>& names);

/// The measured drape that the search has to reproduce.
struct DrapeTarget {
  double coefficient = 0.0;      ///< %
  std::vector<double> spectrum;  ///< m, amplitudes of the rim from order 0 upwards; empty: unknown
};

/// A search for cloth constants whose simulated drape equals the target.
struct DrapeSearch {
  Material base;  ///< supplies all other constants
  DrapeTrial trial;
  DrapeTarget target;
  std::vector<IdentifiedConstant> constants;
  std::string fabric{};             ///< name of the fabric that supplies `base`; empty: none
  std::vector<double> synthetic{};  ///< SI, `constants` of a computed target; empty: measured

  /// Makes the drape of these values of `constants` (SI) the target, to test whether a search finds
  /// them again. `seed` selects the folds of that drape. Throws std::invalid_argument unless there
  /// is one positive value for each constant.
  void aim_at(std::vector<double> values, std::uint32_t seed);
  /// The point in the middle of the bounds, where a local search starts.
  std::vector<double> middle() const;
  /// Material at a point of the search space, whose coordinates are decimal logarithms.
  Material at(const std::vector<double>& logs) const;
  /// Residual: |DC - DC*| in percentage points. If the target has a spectrum, the distance between
  /// the amplitudes, in percent of the specimen's radius, is added [Mongus2012].
  double residual(const std::vector<double>& logs) const;
};

/// A point of the search and its residual.
struct Candidate {
  std::vector<double> logs;
  double residual = 0.0;
};

struct NelderMeadConfig {
  int evaluations = 60;    ///< no further step starts after this many
  double size = 0.5;       ///< decades, size of the first simplex
  double smallest = 1e-3;  ///< decades; a smaller simplex counts as converged
};
/// Downhill simplex method [NelderMead1965]: a local search without gradients. Points are clamped
/// to the bounds. Sets `evaluations` to the number of drapes computed.
Candidate nelder_mead(const DrapeSearch& search, std::vector<double> start,
                      const NelderMeadConfig& config, int& evaluations);

/// Populations between two generations. A resumed search needs nothing else.
struct GeneticState {
  int generation = 0;
  std::vector<std::vector<Candidate>> islands;
};
struct GeneticConfig {
  int generations = 8;
  int islands = 4;     ///< evolved in parallel, one thread each
  int population = 6;  ///< per island; even, >= 4
  std::uint32_t seed = 1;
};
/// True if this build includes pagmo.
bool has_genetic();
/// Genetic algorithm by pagmo (simple GA: tournament, simulated binary crossover, polynomial
/// mutation) on islands in a ring. After every generation, a copy of the best candidate of each
/// island moves to the next island, and `kept` is called with the state. The result is the same for
/// any number of threads, and for a search resumed from `state` as for an uninterrupted one. Throws
/// std::invalid_argument if the build has no pagmo, if `population` is odd or below 4, or if
/// `islands` is below 1.
Candidate genetic(const DrapeSearch& search, const GeneticConfig& config, GeneticState state,
                  const std::function<void(const GeneticState&)>& kept);

/// Writes the state and the settings of its search to a file, which is complete or absent.
void write_state(const std::filesystem::path& file, const DrapeSearch& search,
                 const GeneticConfig& config, const GeneticState& state);
/// Reads a state that write_state wrote for the same search; the number of generations may differ.
/// Throws std::invalid_argument, with the file, if it cannot be read or belongs to another search.
GeneticState read_state(const std::filesystem::path& file, const DrapeSearch& search,
                        const GeneticConfig& config);

/// File that keeps the state of a genetic search after every generation.
struct GeneticFile {
  std::filesystem::path file;  ///< empty: keeps nothing
  bool resume = false;         ///< continue from the state in the file
};
/// Result of a search and its cost.
struct SearchResult {
  Candidate best;
  int evaluations = 0;  ///< drapes computed, without those of the search that was resumed
};
/// A genetic search with its state in a file. Calls `kept`, if given, after every generation.
/// Throws std::invalid_argument under the conditions of `genetic` and `read_state`, and if it has
/// no file to resume from.
SearchResult resumable_genetic(const DrapeSearch& search, const GeneticConfig& config,
                               const GeneticFile& keep,
                               const std::function<void(const GeneticState&)>& kept);

}  // namespace selvedge
