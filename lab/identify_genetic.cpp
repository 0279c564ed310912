// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>

#include <stdexcept>

#include <selvedge/lab/identify.h>

#ifdef SELVEDGE_HAS_PAGMO

#include <algorithm>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

namespace selvedge {
namespace {

/// Adapts the search to pagmo's problem interface.
struct SpaceProblem {
  const SearchSpace* space = nullptr;

  pagmo::vector_double fitness(const pagmo::vector_double& point) const {
    return {space->residual(point)};
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {space->lowest, space->highest};
  }
};

std::vector<Candidate> candidates_of(const pagmo::population& population) {
  std::vector<Candidate> all;
  for (pagmo::population::size_type i = 0; i < population.size(); ++i)
    all.push_back({population.get_x()[i], population.get_f()[i][0]});
  return all;
}

/// Seed of one generation on one island. Apart from `config.seed`, it depends on nothing else, so a
/// resumed search draws the same random numbers as an uninterrupted one.
unsigned seed_of(const GeneticConfig& config, int generation, std::size_t island) {
  constexpr unsigned stride = 7919;
  return config.seed + stride * static_cast<unsigned>(generation) + static_cast<unsigned>(island);
}

std::vector<Candidate> next_generation(const SearchSpace& space, const GeneticConfig& config,
                                       int generation, std::size_t island,
                                       const std::vector<Candidate>& former) {
  const unsigned seed = seed_of(config, generation, island);
  const pagmo::problem problem{SpaceProblem{&space}};
  if (former.empty())
    return candidates_of(pagmo::population{
        problem, static_cast<pagmo::population::size_type>(config.population), seed});
  pagmo::population population{problem, 0, seed};
  for (const Candidate& c : former) population.push_back(c.logs, {c.residual});
  constexpr double crossover = 0.9, spread = 5.0, mutation = 0.3, mutation_spread = 5.0;
  constexpr unsigned tournament = 2;
  const pagmo::algorithm algorithm{pagmo::sga{1u, crossover, spread, mutation, mutation_spread,
                                              tournament, "sbx", "polynomial", "tournament", seed}};
  return candidates_of(algorithm.evolve(population));
}

bool better(const Candidate& a, const Candidate& b) { return a.residual < b.residual; }

/// The best of each island replaces the worst of the next one.
void migrate(std::vector<std::vector<Candidate>>& islands) {
  std::vector<Candidate> best;
  for (const auto& island : islands)
    best.push_back(*std::min_element(island.begin(), island.end(), better));
  for (std::size_t i = 0; i < islands.size(); ++i) {
    auto& next = islands[(i + 1) % islands.size()];
    *std::max_element(next.begin(), next.end(), better) = best[i];
  }
}

}  // namespace

bool has_genetic() { return true; }

Candidate genetic(const SearchSpace& space, const GeneticConfig& config, GeneticState state,
                  const std::function<void(const GeneticState&)>& kept) {
  constexpr int least = 4;
  if (config.population < least || config.population % 2 != 0 || config.islands < 1)
    throw std::invalid_argument(
        "identify: an island needs an even population of at least 4, and there must be one");
  state.islands.resize(config.islands);
  for (; state.generation < config.generations; ++state.generation) {
    parallel_for(state.islands.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        state.islands[i] = next_generation(space, config, state.generation, i, state.islands[i]);
    });
    migrate(state.islands);
    if (kept) {
      GeneticState done = state;
      ++done.generation;
      kept(done);
    }
  }
  Candidate best = state.islands.front().front();
  for (const auto& island : state.islands)
    for (const Candidate& c : island)
      if (better(c, best)) best = c;
  return best;
}

}  // namespace selvedge

#else

namespace selvedge {

bool has_genetic() { return false; }

Candidate genetic(const SearchSpace&, const GeneticConfig&, GeneticState,
                  const std::function<void(const GeneticState&)>&) {
  throw std::invalid_argument(
      "identify: this build has no genetic algorithm; install libpagmo-dev and build again, or "
      "take "
      "--method nelder_mead");
}

}  // namespace selvedge

#endif
