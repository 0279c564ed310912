// SPDX-License-Identifier: MIT
// A spring from every particle to the plane z = 0, with the energy ½ m ω² z².
#include "additions.h"

namespace adding {
namespace {

using namespace selvedge;

class WeightSpring final : public Force {
 public:
  explicit WeightSpring(double omega) : omega_(omega) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (std::size_t i = 0; i < f.size(); ++i) f[i].z() -= stiffness(state, i) * state.x[i].z();
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (std::size_t i = 0; i < state.x.size(); ++i)
      sum += 0.5 * stiffness(state, i) * state.x[i].z() * state.x[i].z();
    return sum;
  }
  // The Jacobian has blocks on the diagonal only, which every matrix has.
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    for (std::size_t i = 0; i < state.x.size(); ++i)
      a.diagonal(i)(2, 2) += h * h * stiffness(state, i);
  }
  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness_sum,
                           std::span<double>) const override {
    for (std::size_t i = 0; i < state.x.size(); ++i) stiffness_sum[i] += stiffness(state, i);
  }

 private:
  double stiffness(const ForceState& state, std::size_t i) const {
    return omega_ * omega_ * state.mass[i];  // N/m
  }

  double omega_;
};

}  // namespace

void register_weight_spring(ForceLawRegistry& registry) {
  registry.add("weight_spring",
               {{.name = "omega",
                 .initial = 2.0,
                 .unit = "1/s",
                 .least = 0.0,
                 .meaning = "frequency of a free particle; more pulls harder"}},
               [](const MethodOptions& o, const ClothMesh&) {
                 ForceList forces;
                 forces.push_back(std::make_unique<WeightSpring>(o["omega"]));
                 return forces;
               },
               {.promise = "minus the gradient of its energy",
                .source = "docs/adding.md",
                .energy = "weight_spring"});
}

}  // namespace adding
