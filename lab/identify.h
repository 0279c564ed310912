// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/lab/fabric_drape.h>

#include <array>
#include <cstddef>
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

/// A box of numbers, and the residual that is to be least in it.
struct SearchSpace {
  std::vector<double> lowest, highest;                         ///< bounds of each coordinate
  std::function<double(const std::vector<double>&)> residual;  ///< several threads call it

  /// The point in the middle of the bounds.
  std::vector<double> middle() const;
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
  /// The bounds and the residual; refers to this search.
  SearchSpace space() const;
};

/// The springs of one kind in a net [Louchet1995].
struct NetSprings {
  double stiffness = 0.0;  ///< N/m, > 0
  double length = 1.0;     ///< natural length, relative to that of the mesh, > 0
  double limit = 0.5;      ///< elongation rate: largest strain, > 0
};
/// The springs of a net for stretch (sides of cells), shear (diagonals) and bending (across two
/// cells).
using NetKinds = std::array<NetSprings, 3>;

/// An unknown of a net. The search works on its decimal logarithm.
struct NetUnknown {
  std::string name;                    ///< "stretch_stiffness", ..., "bend_limit"
  std::size_t kind;                    ///< index in NetKinds
  double NetSprings::*field;           ///< the member that is unknown
  double lowest = 0.0, highest = 0.0;  ///< search bounds, > 0
};
/// The named unknowns: stretch, shear or bend, with _stiffness (N/m), _length or _limit. Throws
/// std::invalid_argument that names an unknown one.
std::vector<NetUnknown> net_unknowns(const std::vector<std::string>& names);

/// A flat rectangular net in the xy-plane that moves from rest under an acceleration, without
/// bodies and collisions. By default it hangs by two corners, as in [Louchet1995].
struct NetTrial {
  GridConfig grid{0.4, 0.4, 5, 5};
  double density = 0.2;                    ///< kg/m²
  double spring_damping = 1e-3;            ///< s
  bool by_side = false;                    ///< held by the side x0 instead of two corners of y0
  std::vector<Vec3> loads{{0, 0, -9.81}};  ///< m/s²; one motion for each
  double step = 5e-4;                      ///< s
  double duration = 0.4;                   ///< s
  int samples = 8;                         ///< positions are compared at so many equal times
  std::string integrator = "symplectic_euler";
  std::string limiter = "position";  ///< strain limiter for the elongation rates; "": none

  /// The same trial by another code path: shorter steps of runge_kutta_4 instead of explicit ones,
  /// another strain limiter. For targets, so that a search cannot find its own errors again.
  NetTrial of_target() const;
  /// A net that is held by one side and pulled along and across it, at rest, after [Bianchi2004].
  static NetTrial pulled();
};
/// Positions of all particles at all sampled times, m. Deterministic.
std::vector<Vec3> net_motion(const NetTrial& trial, const NetKinds& kinds);
/// The same particles in the motion of finite elements (st_venant_kirchhoff) on a mesh that is
/// `finer` times as fine. `stretch` in N/m: Young's modulus times thickness; `poisson` in (-1, 1).
std::vector<Vec3> finite_element_motion(const NetTrial& trial, double stretch, double poisson,
                                        std::int32_t finer);

/// A search for the springs of a net whose motion equals the target.
struct NetSearch {
  NetTrial trial;
  NetKinds base;  ///< supplies all other constants
  std::vector<NetUnknown> unknowns;
  std::vector<Vec3> target;  ///< m, as net_motion gives it

  NetKinds at(const std::vector<double>& logs) const;
  /// Root mean square of the distances to the target, in percent of the longer side.
  double residual(const std::vector<double>& logs) const;
  /// The bounds and the residual; refers to this search.
  SearchSpace space() const;
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
Candidate nelder_mead(const SearchSpace& space, std::vector<double> start,
                      const NelderMeadConfig& config, int& evaluations);
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
Candidate genetic(const SearchSpace& space, const GeneticConfig& config, GeneticState state,
                  const std::function<void(const GeneticState&)>& kept);
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
