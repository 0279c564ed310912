// SPDX-License-Identifier: MIT
#include <selvedge/core/parallel.h>
#include <selvedge/lab/identify.h>

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

/// A small drape whose bending was 2e-5 N·m.
DrapeSearch small_search() {
  DrapeSearch search;
  search.constants = identified_constants({"bending"});
  search.trial.cells = 5;
  search.trial.most_steps = 40;
  const DrapeOutcome known = drape(search.at({std::log10(2e-5)}), search.trial);
  search.target = {known.coefficient, known.rim.amplitude};
  return search;
}

TEST(Identification, TheMisfitIsNoughtAtTheConstantsOfTheTargetAndNowhereElse) {
  const DrapeSearch search = small_search();
  EXPECT_EQ(search.residual({std::log10(2e-5)}), 0.0);
  EXPECT_GT(search.residual({std::log10(4e-5)}), 1.0);
  EXPECT_GT(search.residual({std::log10(1e-5)}), 0.5);
}

TEST(Identification, NelderMeadFindsTheBendingOfASyntheticDrape) {
  int evaluations = 0;
  const Candidate best = nelder_mead(small_search(), {-5.0}, {25, 0.5, 2e-3}, evaluations);
  EXPECT_NEAR(best.logs[0], std::log10(2e-5), 0.02);
  EXPECT_LE(evaluations, 28);
}

TEST(Identification, AnUnknownConstantIsRefused) {
  EXPECT_THROW(identified_constants({"colour"}), std::invalid_argument);
  EXPECT_THROW(identified_constants({}), std::invalid_argument);
}

TEST(Identification, TheGeneticAlgorithmIsTheSameOnAnyThreadsAndWhenResumed) {
  if (!has_genetic()) {
    EXPECT_THROW(genetic(small_search(), {}, {}, {}), std::invalid_argument);
    return;
  }
  const DrapeSearch search = small_search();
  const GeneticConfig config{3, 2, 4, 1};
  GeneticState after_two;
  Candidate whole, alone;
  {
    const ThreadLimit limit(2);
    whole = genetic(search, config, {}, [&](const GeneticState& s) {
      if (s.generation == 2) after_two = s;
    });
  }
  const ThreadLimit limit(1);
  alone = genetic(search, config, after_two, {});
  EXPECT_EQ(alone.logs, whole.logs);
  EXPECT_EQ(alone.residual, whole.residual);
  EXPECT_LT(whole.residual, 20.0);
}

}  // namespace
}  // namespace selvedge
