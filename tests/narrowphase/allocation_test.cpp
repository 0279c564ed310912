// SPDX-License-Identifier: MIT
// The filtered path of ccd_exact takes no memory. A program of its own, because it counts every
// call of operator new.
#include <gtest/gtest.h>
#include <selvedge/narrowphase/ccd_methods.h>

#include <random>

#include "count_allocations.h"

namespace selvedge::allocation_test {
namespace {

/// Random motions of the size of the primitives: all stages up to the integers have work.
std::vector<Query> make_queries(std::size_t n) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<Query> queries(n);
  for (std::size_t i = 0; i < n; ++i) {
    queries[i].kind = i % 3 == 0 ? ContactKind::edge_edge : ContactKind::point_triangle;
    for (auto* x : {&queries[i].x_t0, &queries[i].x_t1})
      for (Vec3& v : *x) v = Vec3(unit(random), unit(random), unit(random));
  }
  return queries;
}

TEST(CcdExact, TheFilteredPathAllocatesNothing) {
  const std::vector<Query> queries = make_queries(30000);
  std::vector<double> toi(queries.size());
  const auto method = make_ccd_exact();
  CcdExactStages stages;
  find_times_counting_stages(queries, toi, stages);
  EXPECT_GT(stages.separated, 1000u);
  EXPECT_GT(stages.never_coplanar, 1000u);
  EXPECT_GT(stages.isolated, 1000u);
  ASSERT_EQ(stages.exact, 0u) << "choose queries without any for the integers";
  const std::size_t before = allocations;
  method->find_times(queries, toi);
  EXPECT_EQ(allocations - before, 0u);
}

TEST(CcdExact, TheCountSeesWhatIsAllocated) {
  const std::size_t before = allocations;
  const std::vector<double> some(10);
  EXPECT_EQ(allocations - before, some.size() / 10);
}

}  // namespace

}  // namespace selvedge::allocation_test
