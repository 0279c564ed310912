// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/force.h>

#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

class Guides final : public Force {
 public:
  explicit Guides(std::vector<Guide> guides) : guides_(std::move(guides)) {
    for (const Guide& g : guides_)
      if (!g.place.allFinite() || !g.stiffness.allFinite() || !g.push.allFinite())
        throw std::invalid_argument("a guide has a number that is not finite");
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (const Guide& g : guides_)
      f[g.particle] += g.push - g.stiffness * (state.x[g.particle] - g.place);
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (const Guide& g : guides_) {
      const Vec3 d = state.x[g.particle] - g.place;
      sum += 0.5 * d.dot(g.stiffness * d) - g.push.dot(d);
    }
    return sum;
  }
  bool is_external() const override { return true; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState&, double h, BlockMatrix& a) const override {
    for (const Guide& g : guides_) a.diagonal(g.particle) += h * h * g.stiffness;
  }
  void add_stiffness_bound(const ForceState&, std::span<double> stiffness,
                           std::span<double>) const override {
    for (const Guide& g : guides_) stiffness[g.particle] += g.stiffness.norm();
  }

 private:
  std::vector<Guide> guides_;
};

}  // namespace

std::unique_ptr<Force> make_guides(std::vector<Guide> guides) {
  return std::make_unique<Guides>(std::move(guides));
}

}  // namespace selvedge
