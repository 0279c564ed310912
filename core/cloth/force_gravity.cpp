// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <stdexcept>

namespace selvedge {
namespace {

constexpr std::size_t kParticleGrain = 4096;

class Gravity final : public Force {
 public:
  explicit Gravity(const Vec3& acceleration) : acceleration_(acceleration) {
    if (!acceleration.allFinite()) throw std::invalid_argument("gravity is not finite");
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    parallel_for(f.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) f[i] += state.mass[i] * acceleration_;
    });
  }

  double energy(const ForceState& state) const override {
    return parallel_sum(state.x.size(), kParticleGrain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t i = begin; i < end; ++i)
        sum -= state.mass[i] * acceleration_.dot(state.x[i]);
      return sum;
    });
  }

  bool is_external() const override { return true; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double, BlockMatrix&) const override {}
  void add_stiffness_bound(const ForceState&, std::span<double>, std::span<double>) const override {
  }

 private:
  Vec3 acceleration_;
};

}  // namespace

std::unique_ptr<Force> make_gravity(const Vec3& acceleration) {
  return std::make_unique<Gravity>(acceleration);
}

void register_gravity(FabricLaws& laws) {
  laws.forces.add_keyed("gravity", "gravity",
                        {.promise = "m g on every particle", .source = "survey eq. 6"});
}

}  // namespace selvedge
