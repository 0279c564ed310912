// SPDX-License-Identifier: MIT
// Integrators take no memory after their first steps. A program of its own, because it counts every
// call of operator new.
#include <gtest/gtest.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/core/solver/integrator.h>

#include "count_allocations.h"

namespace selvedge::step_allocation_test {
namespace {

/// Allocations of a step after the second one.
std::size_t allocations_of_a_step(const std::string& name) {
  const GridConfig grid{0.5, 0.5, 12, 12};
  const ClothMesh cloth = make_rectangular(grid, Material{});
  const std::size_t n = cloth.mass.size();
  auto forces = make_internal_forces(cloth);
  forces.push_back(make_gravity({0, 0, -9.81}));
  Particles p{cloth.surface.vertices, std::vector<Vec3>(n, Vec3::Zero()), cloth.mass, {}};
  for (const double m : p.mass) p.inv_mass.push_back(1.0 / m);
  p.inv_mass[0] = 0.0;
  const auto method = integrators().at(name)(std::move(forces), n, {});
  std::vector<Vec3> mean(n, Vec3::Zero()), v(n);
  std::size_t before = 0;
  for (int i = 0; i < 3; ++i) {
    before = allocations;
    method->stable_step(p, 0.0, 1e-4);
    method->begin({p, 1e-4 * i, 1e-4}, {mean, v});
    method->solve({}, {mean, v}, 1.0);
    for (std::size_t k = 0; k < n; ++k) p.x[k] += 1e-4 * mean[k];
    p.v = method->traits().ends_with_mean ? mean : v;
    method->accept({p.x, p.v, p.mass, 0.0});
  }
  return allocations - before;
}

TEST(IntegratorAllocations, AreNoneAfterTheFirstSteps) {
  const ThreadLimit one(1);  // what the scheduler of several threads allocates is its own
  for (const auto& [name, factory] : integrators())
    EXPECT_LE(allocations_of_a_step(name), 0u) << name;
}

}  // namespace

}  // namespace selvedge::step_allocation_test
