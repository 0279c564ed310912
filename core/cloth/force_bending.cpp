// SPDX-License-Identifier: MIT
//
// R. Bridson, S. Marino, R. Fedkiw, "Simulation of clothing with folds and wrinkles", SCA 2003.
// Their bending mode u1..u4 is the gradient of the angle θ between the normals. Deviation: the
// paper's force is k |E|²/(|N1|+|N2|) (sin(θ/2) - sin(θ0/2)) u. Here it is linear in θ, the
// negative gradient of ½ k (θ-θ0)². So it has an energy, sharp folds stay stiff, and the mesh
// determines k from the plate rigidity (see topology_*).
#include <selvedge/core/cloth/detail/block_jacobian.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <numbers>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t kEnergyGrain = 256;  // groups

void validate_hinge(const Hinge& hinge, std::size_t i, std::size_t particles) {
  for (const std::int32_t v : hinge.v) detail::require_particle("hinge", i, v, particles);
  std::array<std::int32_t, 4> sorted = hinge.v;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw std::invalid_argument("hinge " + std::to_string(i) + " names a particle twice");
  detail::require_number_of("stiffness", "hinge", i, hinge.stiffness);
  detail::require_number_of("damping", "hinge", i, hinge.damping);
  if (!std::isfinite(hinge.rest_angle))
    throw std::invalid_argument("hinge " + std::to_string(i) + " has no finite rest_angle");
}

class BendingForce final : public Force {
 public:
  BendingForce(std::span<const Hinge> hinges, std::size_t particles) {
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < hinges.size(); ++i) {
      validate_hinge(hinges[i], i, particles);
      corners.insert(corners.end(), hinges[i].v.begin(), hinges[i].v.end());
    }
    detail::Coloring coloring = detail::color_elements(corners, 4, particles);
    lanes_ = detail::make_lane_groups(corners, 4, coloring);
    hinges_.reserve(hinges.size());
    for (const std::int32_t i : coloring.order) hinges_.push_back(hinges[i]);
    color_begin_ = std::move(coloring.color_begin);
    numbers_ = detail::lane_numbers<3>(lanes_, hinges_, [](const Hinge& h) {
      return std::array{std::remainder(h.rest_angle, 2.0 * std::numbers::pi), h.stiffness,
                        h.damping};
    });
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, f);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      detail::lane_kernel().hinges(force, detail::group_of(begin), detail::group_of(end));
    });
  }

  double energy(const ForceState& state) const override {
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, {});
    const detail::LaneKernel& kernel = detail::lane_kernel();
    return parallel_sum(lanes_.groups.size(), kEnergyGrain,
                        [&](std::size_t first, std::size_t last) {
                          std::array<double, detail::kGroupLanes> turn;
                          double sum = 0.0;
                          for (std::size_t g = first; g < last; ++g) {
                            const detail::LaneGroup& group = lanes_.groups[g];
                            kernel.turns(force, turn.data(), g, g + 1);
                            for (std::int16_t l = 0; l < group.count; ++l)
                              sum += 0.5 * hinges_[group.element + l].stiffness * turn[l] * turn[l];
                          }
                          return sum;
                        });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const Hinge& hinge : hinges_)
      for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) links.push_back({hinge.v[i], hinge.v[j]});
  }

  void bind(const BlockMatrix& matrix) override {
    std::vector<std::int32_t> corners;
    for (const Hinge& h : hinges_) corners.insert(corners.end(), h.v.begin(), h.v.end());
    jacobian_.bind(corners, matrix);
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
    for (const Hinge& hinge : hinges_) {
      const detail::Dihedral d = detail::dihedral(state.x, hinge.v);
      if (!d.valid) continue;
      double sum = 0.0;
      for (const Vec3& g : d.gradient) sum += g.norm();
      for (int k = 0; k < 4; ++k) {
        const double row = hinge.stiffness * d.gradient[k].norm() * sum;
        stiffness[hinge.v[k]] += row;
        damping[hinge.v[k]] += hinge.damping * row;
      }
    }
  }

 private:
  std::vector<Hinge> hinges_;
  detail::LaneGroups lanes_;
  std::vector<double> numbers_;  // data of lanes_
  std::vector<std::size_t> color_begin_;
  mutable detail::BlockJacobian jacobian_{detail::kHingeKind};  // its numbers are scratch
};

}  // namespace

std::unique_ptr<Force> make_bending_force(std::span<const Hinge> hinges, std::size_t particles) {
  return std::make_unique<BendingForce>(hinges, particles);
}

void register_bending(FabricLaws& laws) {
  laws.bending.push_back({.name = "hinge",
                          .text = "moment by the angle between two triangles, which on grids of "
                                  "cells is the same and on free meshes depends on their pattern",
                          .reads = {"bending_friction", "bending_curve"},
                          .add_to_grid = detail::add_hinged_grid,
                          .add_to_triangles = detail::add_edge_hinges,
                          .add_to_side = detail::add_side_hinge});
  laws.forces.add(
      "bending", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        const std::vector<char> coupled = detail::coupled_hinges(cloth);
        std::vector<Hinge> hinges;
        for (std::size_t i = 0; i < cloth.hinges.size(); ++i)
          if (!coupled[i] && !cloth.hinges[i].sine) hinges.push_back(cloth.hinges[i]);
        if (!hinges.empty()) forces.push_back(make_bending_force(hinges, cloth.mass.size()));
        return forces;
      },
      {.promise = "minus the gradient of its energy",
       .source = "Bridson, Marino, Fedkiw, Simulation of clothing with folds and wrinkles, 2003",
       .energy = "bending"});
}

}  // namespace selvedge
