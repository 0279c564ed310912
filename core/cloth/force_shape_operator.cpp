// SPDX-License-Identifier: MIT
//
// Bending of triangle meshes as a plate: energy ½ (θ-θ0)ᵀ W (θ-θ0) of the angles of all hinges,
// with the constant matrix W of detail/shape_operator.cpp, which cites the papers. The force of a
// hinge is that of [Bridson2003] with the moment W (θ-θ0 + damping·dθ/dt).
//
// Jacobian: ∇θ W ∇θᵀ, without the indefinite second derivative of θ. Couplings between hinges of
// two triangles would connect vertices three rings apart. The Jacobian replaces them by an upper
// bound: |W_ef| on the diagonals of e and f. Its blocks then connect only the vertices of a
// triangle and its neighbours, and it is never softer than the force, so steps stay stable. On
// undistorted grids these couplings are small or zero.
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/cloth/detail/shape_operator.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <array>
#include <map>
#include <numbers>
#include <string>

namespace selvedge {
namespace {

using detail::kGroupLanes;
using detail::LanePatch;

constexpr std::size_t kHingeGrain = 128;  // groups
constexpr int kPatchVertices = 6;         // at most: three of a triangle and one beyond each hinge

/// The vertices of a patch in the order of LanePatch::corner; the last one is repeated if there are
/// fewer.
using PatchVertices = std::array<std::int32_t, kPatchVertices>;

void validate(std::span<const Hinge> hinges, std::span<const HingeCouple> couples,
              std::size_t particles) {
  for (std::size_t i = 0; i < hinges.size(); ++i) {
    for (const std::int32_t v : hinges[i].v) detail::require_particle("hinge", i, v, particles);
    detail::require_number_of("stiffness", "hinge", i, hinges[i].stiffness);
    detail::require_number_of("damping", "hinge", i, hinges[i].damping);
    detail::require_number_of("size of rest_angle", "hinge", i, std::abs(hinges[i].rest_angle));
  }
  for (std::size_t i = 0; i < couples.size(); ++i) {
    const auto& [a, b, stiffness] = couples[i];
    detail::require_particle("couple", i, a, hinges.size());
    detail::require_particle("couple", i, b, hinges.size());
    detail::require_number_of("size of stiffness", "couple", i, std::abs(stiffness));
    if (a == b || hinges[a].damping != hinges[b].damping)
      throw std::invalid_argument("couple " + std::to_string(i) +
                                  " must join two hinges of the same damping");
  }
}

class ShapeOperatorForce final : public Force {
 public:
  ShapeOperatorForce(std::span<const Hinge> hinges, std::span<const HingeCouple> couples,
                     std::size_t particles) {
    validate(hinges, couples, particles);
    std::vector<std::int32_t> corners, number(hinges.size());
    for (const Hinge& h : hinges) corners.insert(corners.end(), h.v.begin(), h.v.end());
    detail::Coloring coloring = detail::color_elements(corners, 4, particles);
    lanes_ = detail::make_lane_groups(corners, 4, coloring);
    for (const std::int32_t i : coloring.order) {
      number[i] = static_cast<std::int32_t>(hinges_.size());
      hinges_.push_back(hinges[i]);
    }
    color_begin_ = std::move(coloring.color_begin);
    numbers_ = detail::lane_numbers<3>(lanes_, hinges_, [](const Hinge& h) {
      return std::array{std::remainder(h.rest_angle, 2.0 * std::numbers::pi), h.stiffness,
                        h.damping};
    });
    set_places();
    std::vector<HingeCouple> own(couples.begin(), couples.end());
    for (HingeCouple& c : own) c = {number[c.a], number[c.b], c.stiffness};
    set_rows(own);
    set_patches(own, particles);
    turn_.resize(kGroupLanes * lanes_.groups.size());
    moment_.resize(turn_.size());
    gradient_.resize(detail::kLaneGradient * lanes_.groups.size() + detail::kLaneGradientMore);
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    measure(state);
    const detail::LaneKernel& kernel = detail::lane_kernel();
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, f);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      const std::size_t first = detail::group_of(begin), last = detail::group_of(end);
      kernel.moments(force, plate(), first, last);
      kernel.turning_forces(force, plate(), first, last);
    });
  }

  double energy(const ForceState& state) const override {
    const detail::LaneKernel& kernel = detail::lane_kernel();
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, {});
    parallel_for(lanes_.groups.size(), kHingeGrain, [&](std::size_t first, std::size_t last) {
      kernel.turns(force, turn_.data() + kGroupLanes * first, first, last);
    });
    return parallel_sum(
        lanes_.groups.size(), kHingeGrain, [&](std::size_t first, std::size_t last) {
          kernel.moments(force, plate(), first, last);
          double sum = 0.0;
          for (std::size_t g = first; g < last; ++g)
            for (std::int16_t l = 0; l < lanes_.groups[g].count; ++l)
              sum += 0.5 * turn_[kGroupLanes * g + l] * moment_[kGroupLanes * g + l];
          return sum;
        });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (std::size_t p = 0; p < patches_.size(); ++p)
      for (int i = 0; i < kPatchVertices; ++i)
        for (int j = 0; j < i; ++j)
          if (vertices_[p][i] != vertices_[p][j])
            links.push_back({vertices_[p][i], vertices_[p][j]});
  }

  void bind(const BlockMatrix& matrix) override {
    constexpr int n = kPatchVertices;
    slots_.assign(patches_.size(), {});
    for (std::size_t p = 0; p < patches_.size(); ++p)
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          slots_[p][n * i + j] = matrix.slot(vertices_[p][i], vertices_[p][j]);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    measure(state);
    const detail::LaneBlocks blocks = detail::lane_blocks(slots_, a, h);
    detail::for_each_color(patch_begin_, [&](std::size_t begin, std::size_t end) {
      detail::lane_kernel().patch_blocks(plate(), blocks, begin, end);
    });
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    measure(state);
    std::vector<std::array<double, 4>> norm(hinges_.size());
    std::vector<double> all(turn_.size(), 0.0);  // indexed by position
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      norm[e] = gradient_norms(place_[e]);
      for (const double n : norm[e]) all[place_[e]] += n;
    }
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      const double sum = sum_of_row(place_[e], hinges_[e].stiffness, all);
      for (int k = 0; k < 4; ++k) {
        const double row = sum * norm[e][k];
        stiffness[hinges_[e].v[k]] += row;
        damping[hinges_[e].v[k]] += hinges_[e].damping * row;
      }
    }
  }

 private:
  void set_places() {
    for (std::size_t g = 0; g < lanes_.groups.size(); ++g)
      for (std::int16_t l = 0; l < lanes_.groups[g].count; ++l)
        place_.push_back(static_cast<std::int32_t>(kGroupLanes * g + l));
  }

  /// The couplings of W by groups: as many rows of `kGroupLanes` as the largest hinge of a group
  /// needs. Unused entries are 0 and refer to the hinge itself.
  void set_rows(const std::vector<HingeCouple>& couples) {
    std::vector<std::vector<std::pair<std::int32_t, double>>> of(kGroupLanes *
                                                                 lanes_.groups.size());
    for (const HingeCouple& c : couples) {
      of[place_[c.a]].emplace_back(place_[c.b], c.stiffness);
      of[place_[c.b]].emplace_back(place_[c.a], c.stiffness);
    }
    row_begin_.push_back(0);
    for (std::size_t first = 0; first < of.size(); first += kGroupLanes) {
      std::size_t most = 0;
      for (std::size_t l = 0; l < kGroupLanes; ++l) most = std::max(most, of[first + l].size());
      for (std::size_t r = 0; r < most; ++r)
        for (std::size_t l = first; l < first + kGroupLanes; ++l) {
          const bool has = r < of[l].size();
          column_.push_back(has ? of[l][r].first : static_cast<std::int32_t>(l));
          couple_.push_back(has ? of[l][r].second : 0.0);
        }
      row_begin_.push_back(static_cast<std::uint32_t>(column_.size() / kGroupLanes));
    }
  }

  /// The vertices that two hinges share; hinges of one triangle share its vertices.
  std::vector<std::int32_t> shared(std::int32_t a, std::int32_t b) const {
    std::vector<std::int32_t> common;
    for (const std::int32_t v : hinges_[a].v)
      if (std::find(hinges_[b].v.begin(), hinges_[b].v.end(), v) != hinges_[b].v.end())
        common.push_back(v);
    std::sort(common.begin(), common.end());
    return common;
  }

  /// A patch under construction: its hinges are indices, not positions.
  struct Draft {
    std::vector<std::int32_t> triangle;
    LanePatch patch;
  };

  void set_patches(const std::vector<HingeCouple>& couples, std::size_t particles) {
    std::vector<double> diagonal;
    for (const Hinge& h : hinges_) diagonal.push_back(h.stiffness);
    std::map<std::vector<std::int32_t>, LanePatch> of_triangle;
    for (const HingeCouple& c : couples) {
      const std::vector<std::int32_t> common = shared(c.a, c.b);
      LanePatch* patch = common.size() == 3 ? &of_triangle[common] : nullptr;
      const int i = patch == nullptr ? -1 : place_in(*patch, c.a);
      const int j = patch == nullptr ? -1 : place_in(*patch, c.b);
      if (i < 0 || j < 0) {
        diagonal[c.a] += std::abs(c.stiffness);
        diagonal[c.b] += std::abs(c.stiffness);
      } else {
        patch->couple[i][j] = patch->couple[j][i] = c.stiffness;
      }
    }
    std::vector<Draft> drafts;
    for (const auto& [triangle, patch] : of_triangle)
      if (patch.hinges > 0) drafts.push_back({triangle, patch});
    give_diagonals(diagonal, drafts);
    sort_patches(std::move(drafts), particles);
  }

  static int place_in(LanePatch& patch, std::int32_t hinge) {
    for (int i = 0; i < patch.hinges; ++i)
      if (patch.hinge[i] == hinge) return i;
    if (patch.hinges == static_cast<int>(patch.hinge.size())) return -1;
    patch.hinge[patch.hinges] = hinge;
    return patch.hinges++;
  }

  void give_diagonals(const std::vector<double>& diagonal, std::vector<Draft>& drafts) const {
    std::vector<char> given(hinges_.size(), 0);
    for (auto& [triangle, patch] : drafts)
      for (int i = 0; i < patch.hinges; ++i) {
        if (given[patch.hinge[i]] != 0) continue;
        given[patch.hinge[i]] = 1;
        patch.couple[i][i] = diagonal[patch.hinge[i]];
      }
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      if (given[e] != 0) continue;
      const auto& v = hinges_[e].v;
      Draft& draft = drafts.emplace_back();
      draft.triangle = {v[0], v[2], v[3]};
      std::sort(draft.triangle.begin(), draft.triangle.end());
      draft.patch.hinge[draft.patch.hinges++] = static_cast<std::int32_t>(e);
      draft.patch.couple[0][0] = diagonal[e];
    }
  }

  void sort_patches(std::vector<Draft> drafts, std::size_t particles) {
    std::stable_sort(drafts.begin(), drafts.end(), [](const Draft& a, const Draft& b) {
      return a.triangle < b.triangle;  // neighbours in memory are neighbours on the cloth
    });
    std::vector<PatchVertices> vertices;
    for (Draft& draft : drafts) vertices.push_back(finish(draft));
    std::vector<std::int32_t> corners;
    for (const PatchVertices& v : vertices) corners.insert(corners.end(), v.begin(), v.end());
    detail::Coloring coloring = detail::color_elements(corners, kPatchVertices, particles);
    for (const std::int32_t i : coloring.order) {
      patches_.push_back(drafts[i].patch);
      vertices_.push_back(vertices[i]);
    }
    patch_begin_ = std::move(coloring.color_begin);
  }

  /// Sets the corners of the patch's hinges and replaces their indices by positions.
  PatchVertices finish(Draft& draft) const {
    LanePatch& patch = draft.patch;
    PatchVertices vertices;
    std::copy(draft.triangle.begin(), draft.triangle.end(), vertices.begin());
    for (int a = 0; a < patch.hinges; ++a) {
      const auto& v = hinges_[patch.hinge[a]].v;
      for (std::int8_t k = 0; k < 4; ++k) {
        const auto at = std::find(vertices.begin(), vertices.begin() + 3, v[k]);
        patch.corner[a][at - vertices.begin()] = k;
        if (at == vertices.begin() + 3) vertices[3 + a] = v[k];
      }
      patch.damping = hinges_[patch.hinge[a]].damping;
      patch.hinge[a] = place_[patch.hinge[a]];
    }
    std::fill(vertices.begin() + 3 + patch.hinges, vertices.end(), vertices[2 + patch.hinges]);
    return vertices;
  }

  /// A view of the members, including the scratch arrays of one evaluation.
  detail::LanePlate plate() const {
    return {row_begin_.data(), column_.data(), couple_.data(),  patches_.data(),
            turn_.data(),      moment_.data(), gradient_.data()};
  }

  /// Computes the angle changes, including damping, and the gradients of all hinges.
  void measure(const ForceState& state) const {
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, {});
    parallel_for(lanes_.groups.size(), kHingeGrain, [&](std::size_t first, std::size_t last) {
      detail::lane_kernel().bends(force, plate(), first, last);
    });
  }

  /// Norms of the gradient of a hinge at its four corners, 1/m.
  std::array<double, 4> gradient_norms(std::int32_t place) const {
    const std::size_t group = place / kGroupLanes, lane = place % kGroupLanes;
    const double* at = gradient_.data() + detail::kLaneGradient * group + 3 * lane;
    const Eigen::Map<const Vec3> g0(at), g1(at + 3 * kGroupLanes), g3(at + 6 * kGroupLanes);
    return {g0.norm(), g1.norm(), (g0 + g1 + g3).norm(), g3.norm()};
  }

  /// Σ |W_ab| number_b.
  double sum_of_row(std::int32_t place, double own, const std::vector<double>& number) const {
    const std::size_t group = place / kGroupLanes, lane = place % kGroupLanes;
    double sum = own * number[place];
    for (std::size_t r = row_begin_[group]; r < row_begin_[group + 1]; ++r)
      sum += std::abs(couple_[kGroupLanes * r + lane]) * number[column_[kGroupLanes * r + lane]];
    return sum;
  }

  std::vector<Hinge> hinges_;
  detail::LaneGroups lanes_;
  std::vector<double> numbers_;      // data of lanes_
  std::vector<std::int32_t> place_;  // per hinge: kGroupLanes·group + lane
  std::vector<std::uint32_t> row_begin_;
  std::vector<std::int32_t> column_;
  std::vector<double> couple_;
  std::vector<LanePatch> patches_;
  std::vector<PatchVertices> vertices_;
  std::vector<std::array<std::int32_t, kPatchVertices * kPatchVertices>> slots_;
  std::vector<std::size_t> color_begin_, patch_begin_;
  mutable std::vector<double> turn_, moment_, gradient_;  ///< scratch of one evaluation
};

}  // namespace

std::unique_ptr<Force> make_shape_operator_force(std::span<const Hinge> hinges,
                                                 std::span<const HingeCouple> couples,
                                                 std::size_t particles) {
  return std::make_unique<ShapeOperatorForce>(hinges, couples, particles);
}

void register_shape_operator(FabricLaws& laws) {
  laws.bending.push_back({.name = "shape_operator",
                          .text = "a plate on any mesh, by the curvature of triangles",
                          .reads = {"bending_friction", "bending_curve"},
                          .reads_on_triangles = {"bending_friction", "bending_curve"},
                          .add_to_grid = detail::add_hinged_grid,
                          .add_to_triangles = detail::add_shape_operator,
                          .add_to_side = detail::add_side_hinge});
  laws.forces.add(
      "shape_operator", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        if (cloth.couples.empty()) return forces;
        const std::vector<char> coupled = detail::coupled_hinges(cloth);
        std::vector<std::int32_t> number(cloth.hinges.size(), -1);
        std::vector<Hinge> hinges;
        for (std::size_t i = 0; i < cloth.hinges.size(); ++i) {
          if (!coupled[i]) continue;
          number[i] = static_cast<std::int32_t>(hinges.size());
          hinges.push_back(cloth.hinges[i]);
        }
        std::vector<HingeCouple> couples = cloth.couples;
        for (HingeCouple& c : couples) c = {number[c.a], number[c.b], c.stiffness};
        forces.push_back(make_shape_operator_force(hinges, couples, cloth.mass.size()));
        return forces;
      },
      {.promise = "a plate on any mesh; minus the gradient of its energy",
       .source =
           "Onate, Zarate, Rotation-free triangular plate and shell elements, 2000; Gingold et "
           "al., 2004",
       .energy = "bending"});
}

}  // namespace selvedge
