// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/block_jacobian.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t kHookeGrain = 4096;

class HookeForce final : public Force {
 public:
  HookeForce(std::span<const Spring> springs, std::size_t particles) {
    std::vector<std::int32_t> ends;
    for (std::size_t i = 0; i < springs.size(); ++i) {
      const Spring& s = springs[i];
      detail::require_particle("spring", i, s.a, particles);
      detail::require_particle("spring", i, s.b, particles);
      if (s.a == s.b)
        throw std::invalid_argument("spring " + std::to_string(i) + " joins particle " +
                                    std::to_string(s.a) + " to itself");
      detail::require_number_of("rest_length", "spring", i, s.rest_length, false);
      detail::require_number_of("stiffness", "spring", i, s.stiffness, false);
      detail::require_number_of("damping", "spring", i, s.damping);
      ends.push_back(s.a);
      ends.push_back(s.b);
    }
    detail::Coloring coloring = detail::color_elements(ends, 2, particles);
    lanes_ = detail::make_lane_groups(ends, 2, coloring);
    springs_.reserve(springs.size());
    for (const std::int32_t i : coloring.order) springs_.push_back(springs[i]);
    color_begin_ = std::move(coloring.color_begin);
    numbers_ = detail::lane_numbers<3>(lanes_, springs_, [](const Spring& s) {
      return std::array{s.rest_length, s.stiffness, s.damping};
    });
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, f);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      detail::lane_kernel().hooke(force, detail::group_of(begin), detail::group_of(end));
    });
  }

  double energy(const ForceState& state) const override {
    return parallel_sum(springs_.size(), kHookeGrain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const Spring& s = springs_[i];
        const double stretch = (state.x[s.b] - state.x[s.a]).norm() - s.rest_length;
        sum += 0.5 * s.stiffness * stretch * stretch;
      }
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const Spring& s : springs_) links.push_back({s.a, s.b});
  }

  void bind(const BlockMatrix& matrix) override {
    std::vector<std::int32_t> ends;
    for (const Spring& s : springs_) ends.insert(ends.end(), {s.a, s.b});
    jacobian_.bind(ends, matrix);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    jacobian_rows(state, h);
    jacobian_.add(a);
  }

  const JacobianRows* jacobian_rows(const ForceState& state, double h) const override {
    jacobian_.find_numbers(lanes_, detail::lane_force(lanes_, numbers_, state, {}), h);
    return &jacobian_;
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    for (const Spring& s : springs_) {
      const double length = (state.x[s.b] - state.x[s.a]).norm();
      // The norm of the block is k along the spring and k |1 - L0/L| across it; it occurs twice in
      // a row.
      const double across = length > 0.0 ? std::abs(1.0 - s.rest_length / length) : 1.0;
      const double norm = 2.0 * s.stiffness * std::max(1.0, across);
      stiffness[s.a] += norm;
      stiffness[s.b] += norm;
      damping[s.a] += 2.0 * s.stiffness * s.damping;
      damping[s.b] += 2.0 * s.stiffness * s.damping;
    }
  }

 private:
  std::vector<Spring> springs_;
  detail::LaneGroups lanes_;
  std::vector<double> numbers_;  // data of lanes_
  std::vector<std::size_t> color_begin_;
  mutable detail::BlockJacobian jacobian_{detail::kSpringKind};  // its numbers are scratch
};

}  // namespace

std::unique_ptr<Force> make_hooke_force(std::span<const Spring> springs, std::size_t particles) {
  return std::make_unique<HookeForce>(springs, particles);
}

void register_hooke(FabricLaws& laws) {
  laws.stretch.push_back(
      {.name = "hooke", .text = "linear", .curve = [](const Material&) { return SpringCurve{}; }});
  laws.shear.push_back(
      {.name = "springs",
       .text = "diagonals, and on free triangles the springs of all edges, whose shear stiffness "
               "is 3/8 of that of stretch whatever shear_stiffness says",
       .by_springs = true});
  laws.forces.add(
      "hooke", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        const std::vector<Spring> springs = springs_of_curve(cloth, -1);
        if (!springs.empty()) forces.push_back(make_hooke_force(springs, cloth.mass.size()));
        for (std::size_t c = 0; c < cloth.curves.size(); ++c)
          if (cloth.curves[c].law == "hooke" && !cloth.curves[c].idle)
            forces.push_back(make_hooke_force(springs_of_curve(cloth, static_cast<std::int32_t>(c)),
                                              cloth.mass.size()));
        return forces;
      },
      {.promise = "minus the gradient of its energy",
       .source = "Hooke's law; Provot, Deformation constraints in a mass-spring model, 1995",
       .energy = "stretch_and_shear"});
}

}  // namespace selvedge
