// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/lab/identify.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stdexcept>

namespace selvedge::identify_test {
namespace {

/// A small drape whose bending was 2e-5 N·m.
DrapeSearch small_search() {
  DrapeSearch search;
  search.constants = identified_constants({"bending"});
  search.trial.cells = 5;
  search.trial.most_steps = 40;
  search.aim_at({2e-5}, search.trial.seed);
  return search;
}

TEST(Identification, TheResidualIsZeroAtTheTargetsConstantsOnly) {
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

/// A net that hangs by two corners, whose target another integrator computed, with a quarter of the
/// step, and with another limiter.
NetSearch hanging_search(const std::vector<std::string>& names, NetKinds base,
                         const std::vector<double>& values) {
  NetSearch search{.trial = {}, .base = base, .unknowns = net_unknowns(names), .target = {}};
  std::vector<double> logs;
  for (const double value : values) logs.push_back(std::log10(value));
  search.target = net_motion(search.trial.of_target(), search.at(logs));
  return search;
}

/// The best of a small genetic search, improved by Nelder-Mead; or the latter alone.
Candidate found(const SearchSpace& space) {
  std::vector<double> start = space.middle();
  if (has_genetic()) start = genetic(space, {5, 2, 8, 3}, {}, {}).logs;
  int evaluations = 0;
  return nelder_mead(space, start, {90, 0.1, 2e-3}, evaluations);
}

constexpr NetKinds kLoose = {{{100.0, 1.0, 0.5}, {30.0, 1.0, 0.5}, {5.0, 1.0, 0.5}}};

TEST(NetIdentification, FindsStiffnessAndNaturalLengthOfEachKindOfSprings) {
  const std::vector<std::string> names{"stretch_stiffness", "shear_stiffness", "stretch_length"};
  const std::vector<double> values{150.0, 20.0, 1.04};
  const NetSearch search = hanging_search(names, kLoose, values);
  const Candidate best = found(search.space());
  EXPECT_LT(best.residual, 0.2);
  for (std::size_t k = 0; k < values.size(); ++k)
    EXPECT_NEAR(std::pow(10.0, best.logs[k]) / values[k], 1.0, k == 2 ? 0.01 : 0.1) << names[k];
}

TEST(NetIdentification, FindsTheElongationRateOfSpringsThatReachIt) {
  NetKinds soft = kLoose;
  soft[0].stiffness = 25.0;
  const NetSearch search = hanging_search({"stretch_limit", "shear_stiffness"}, soft, {0.06, 20.0});
  const Candidate best = found(search.space());
  EXPECT_NEAR(std::pow(10.0, best.logs[0]), 0.06, 0.006);
  EXPECT_NEAR(std::pow(10.0, best.logs[1]), 20.0, 3.0);
}

// A net of square cells is the isotropic sheet of finite elements with Young's modulus E and
// Poisson's ratio 1/3 if its diagonals have C12 = 3/8 E and its sides C11 - C12 = 3/4 E.
TEST(NetIdentification, FindsTheSpringsThatDeformAsFiniteElementsDo) {
  NetSearch search{.trial = NetTrial::pulled(),
                   .base = kLoose,
                   .unknowns = net_unknowns({"stretch_stiffness", "shear_stiffness"}),
                   .target = {}};
  search.base[2].stiffness = 1e-6;
  constexpr double young = 200.0;
  search.target = finite_element_motion(search.trial, young, 1.0 / 3.0, 4);
  int evaluations = 0;
  const Candidate best =
      nelder_mead(search.space(), search.space().middle(), {60, 0.2, 1e-3}, evaluations);
  EXPECT_NEAR(std::pow(10.0, best.logs[0]) / young, 0.75, 0.06);
  EXPECT_NEAR(std::pow(10.0, best.logs[1]) / young, 0.375, 0.04);
}

TEST(NetIdentification, NaturalLengthsAreThoseOfTheirOwnKindOfSprings) {
  constexpr double nothing = 1e-9;  // N/m
  for (const std::size_t stiff : {0u, 1u, 2u}) {
    NetKinds kinds = kLoose;
    for (std::size_t k = 0; k < 3; ++k) kinds[k] = {k == stiff ? 30.0 : nothing, 1.0, 100.0};
    const std::vector<Vec3> before = net_motion({}, kinds);
    for (std::size_t k = 0; k < 3; ++k) {
      NetKinds longer = kinds;
      longer[k].length = 1.1;
      const std::vector<Vec3> x = net_motion({}, longer);
      double moved = 0.0;
      for (std::size_t i = 0; i < x.size(); ++i) moved = std::max(moved, (x[i] - before[i]).norm());
      EXPECT_EQ(moved > 1e-4, k == stiff) << stiff << " " << k << " " << moved;
    }
  }
}

TEST(NetIdentification, AnUnknownConstantAndAnUnfitTargetAreRefused) {
  EXPECT_THROW(net_unknowns({"stretch"}), std::invalid_argument);
  EXPECT_THROW(net_unknowns({}), std::invalid_argument);
  NetSearch search = hanging_search({"stretch_stiffness"}, kLoose, {100.0});
  search.target.pop_back();
  EXPECT_THROW(search.residual({2.0}), std::invalid_argument);
  search.trial.samples = 0;
  EXPECT_THROW(search.residual({2.0}), std::invalid_argument);
}

TEST(Identification, AnUnknownConstantIsRefused) {
  EXPECT_THROW(identified_constants({"colour"}), std::invalid_argument);
  EXPECT_THROW(identified_constants({}), std::invalid_argument);
}

TEST(Identification, ASyntheticTargetNeedsAPositiveValueForEachConstant) {
  DrapeSearch search = small_search();
  EXPECT_EQ(search.synthetic, std::vector<double>{2e-5});
  EXPECT_THROW(search.aim_at({2e-5, 30.0}, 1), std::invalid_argument);
  EXPECT_THROW(search.aim_at({0.0}, 1), std::invalid_argument);
  EXPECT_EQ(search.synthetic, std::vector<double>{2e-5});
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

/// A state file of two islands with four candidates each, and its search.
class StateOfASearch : public ::testing::Test {
 protected:
  void SetUp() override {
    state_.generation = 2;
    state_.islands.assign(2, std::vector<Candidate>(4));
    double value = 0.1;  // not representable, nor are its powers
    for (auto& island : state_.islands)
      for (Candidate& c : island) c = {{-5.0 - (value *= 0.7)}, value / 3.0};
    write_state(file_, search_, config_, state_);
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::string fault_of_reading(const DrapeSearch& search, const GeneticConfig& config) const {
    return refusal([&] { read_state(file_, search, config); });
  }
  std::string text() const {
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void replace(const std::string& from, const std::string& to) const {
    std::string all = text();
    const auto at = all.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(file_, std::ios::binary) << all.replace(at, from.size(), to);
  }

  const DrapeSearch search_ = small_search();
  const GeneticConfig config_{3, 2, 4, 1};
  const std::filesystem::path file_ = std::filesystem::path(::testing::TempDir()) /
                                      ("selvedge_search_" + std::to_string(getpid()) + ".json");
  GeneticState state_;
};

TEST_F(StateOfASearch, ReadsBackToTheBit) {
  const GeneticState read = read_state(file_, search_, config_);
  EXPECT_EQ(read.generation, 2);
  ASSERT_EQ(read.islands.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(read.islands[i][k].logs, state_.islands[i][k].logs);
      EXPECT_EQ(read.islands[i][k].residual, state_.islands[i][k].residual);
    }
  replace("\"residual\"", "\"misfit\"");  // the key in files of version 0.1
  EXPECT_EQ(read_state(file_, search_, config_).islands[0][0].residual,
            state_.islands[0][0].residual);
}

TEST_F(StateOfASearch, OfAnotherSearchOrWithoutAllCandidatesIsRefused) {
  EXPECT_EQ(fault_of_reading(search_, {99, 2, 4, 1}), "");  // more generations
  EXPECT_NE(fault_of_reading(search_, {3, 2, 4, 2}).find("belongs to another search"),
            std::string::npos);
  DrapeSearch other = search_;
  other.trial.cells = 6;
  EXPECT_NE(fault_of_reading(other, config_).find("belongs to another search"), std::string::npos);
  other = search_;
  other.fabric = "silk";
  EXPECT_NE(fault_of_reading(other, config_).find("belongs to another search"), std::string::npos);
  replace("\"logs\": [", "\"logs\": [1.0, ");
  EXPECT_NE(fault_of_reading(search_, config_).find("is not the state of a search"),
            std::string::npos);
  std::ofstream(file_) << "{";
  EXPECT_NE(fault_of_reading(search_, config_).find("is not the state of a search"),
            std::string::npos);
  std::filesystem::remove(file_);
  EXPECT_NE(fault_of_reading(search_, config_).find("no such file"), std::string::npos);
}

TEST_F(StateOfASearch, IsKeptAfterEveryGenerationAndResumesToTheSameBits) {
  if (!has_genetic()) GTEST_SKIP() << "this build has no pagmo";
  std::string after_two;
  const SearchResult whole =
      resumable_genetic(search_, config_, {file_, false}, [&](const GeneticState& s) {
        EXPECT_EQ(read_state(file_, search_, config_).generation, s.generation);
        if (s.generation == 2) after_two = text();
      });
  EXPECT_EQ(whole.evaluations, 3 * 2 * 4);
  const std::string after_three = text();
  std::ofstream(file_, std::ios::binary) << after_two;
  const SearchResult rest = resumable_genetic(search_, config_, {file_, true}, {});
  EXPECT_EQ(rest.evaluations, 2 * 4);
  EXPECT_EQ(rest.best.logs, whole.best.logs);
  EXPECT_EQ(rest.best.residual, whole.best.residual);
  EXPECT_EQ(text(), after_three);
  EXPECT_NE(after_two, after_three);
  EXPECT_THROW(resumable_genetic(search_, config_, {{}, true}, {}), std::invalid_argument);
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
}  // namespace selvedge::identify_test
