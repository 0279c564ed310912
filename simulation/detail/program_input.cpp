// SPDX-License-Identifier: MIT
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/detail/program_input.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kProgramForceGrain = 4096;  // particles per task

class ProgramForce final : public Force {
 public:
  explicit ProgramForce(const ProgramInput& input) : input_(&input) {}

  void add_force(const ForceState&, std::span<Vec3> f) const override {
    const std::vector<Vec3>& force = input_->force;
    parallel_for(force.size(), kProgramForceGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) f[i] += force[i];
    });
  }

  double energy(const ForceState& state) const override {
    const std::vector<Vec3>& force = input_->force;
    return parallel_sum(force.size(), kProgramForceGrain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t i = begin; i < end; ++i) sum -= force[i].dot(state.x[i]);
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
  const ProgramInput* input_;
};

auto place_of(auto& held, std::int32_t particle) {
  return std::ranges::lower_bound(held, particle, {}, &HeldByProgram::particle);
}

}  // namespace

Vec3 ProgramInput::total_force() const {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& f : force) sum += f;
  return sum;
}

void ProgramInput::hold(const HeldByProgram& particle) {
  const auto at = place_of(held, particle.particle);
  if (at != held.end() && at->particle == particle.particle)
    *at = particle;
  else
    held.insert(at, particle);
}

void ProgramInput::release(std::int32_t particle) {
  const auto at = place_of(held, particle);
  if (at != held.end() && at->particle == particle) held.erase(at);
}

std::unique_ptr<Force> make_program_force(const ProgramInput& input) {
  return std::make_unique<ProgramForce>(input);
}

}  // namespace selvedge::detail
