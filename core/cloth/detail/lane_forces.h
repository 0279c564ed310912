// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/detail/block_elements.h>
#include <selvedge/core/cloth/detail/lane_groups.h>
#include <selvedge/core/cloth/force.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// Input and output of a kernel. Vectors are stored as 3 doubles each.
struct LaneForce {
  const LaneGroup* groups;
  const std::int32_t* particles;
  const double* numbers;  ///< see lane_numbers
  const double* x;        ///< m
  const double* v;        ///< m/s
  double* f;              ///< N; forces are added
};

/// Target of a Jacobian: 3×3 blocks of 9 doubles, column-major.
struct LaneBlocks {
  const std::int32_t* slots;  ///< arity² of each element, row by row
  double* values;
  double h;  ///< s
};

/// LaneForce for `state` and the forces f. All members are views.
inline LaneForce lane_force(const LaneGroups& lanes, std::span<const double> numbers,
                            const ForceState& state, std::span<Vec3> f) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const auto first = [](auto vectors) { return vectors.empty() ? nullptr : vectors[0].data(); };
  return {lanes.groups.data(), lanes.particles.data(), numbers.data(),
          first(state.x),      first(state.v),         first(f)};
}

/// LaneBlocks for elements with these slots. Both arguments are viewed.
template <std::size_t count>
LaneBlocks lane_blocks(const std::vector<std::array<std::int32_t, count>>& slots, BlockMatrix& a,
                       double h) {
  static_assert(sizeof(Mat3) == 9 * sizeof(double));
  if (slots.empty()) return {nullptr, nullptr, h};
  return {slots[0].data(), a.values()[0].data(), h};
}

/// f += forces of the groups [first, last).
using AddLanes = void (*)(const LaneForce& force, std::size_t first, std::size_t last);

/// Numbers per element from which its blocks of the Jacobian follow. A spring: its direction, then
/// the factors of the block along and across it. A hinge: the gradients of its angle at the four
/// corners, then the factor of their products.
inline constexpr std::size_t kSpringParts = 5, kHingeParts = 13;

/// Computes these numbers for the groups [first, last). `parts` begins with those of element 0; the
/// blocks are -h ∂f/∂v - h² ∂f/∂x without the indefinite part.
using ElementParts = void (*)(const LaneForce& force, double h, double* parts, std::size_t first,
                              std::size_t last);

/// A Jacobian: a view of BlockElements, of the numbers of the elements, and of the blocks, 9
/// doubles each, column-major.
struct LaneJacobian {
  const std::uint32_t* begin;
  const std::int32_t* slot;
  const std::uint32_t* entry;
  const double* parts;
  double* values;
};

inline LaneJacobian lane_jacobian(const BlockElements& blocks, const std::vector<double>& parts,
                                  BlockMatrix& a) {
  static_assert(sizeof(Mat3) == 9 * sizeof(double));
  return {blocks.begin.data(), blocks.slot.data(), blocks.entry.data(), parts.data(),
          blocks.size() > 0 ? a.values()[0].data() : nullptr};
}

/// Adds the blocks of the elements, for the entries [first, last) of BlockElements::slot.
using AddBlocks = void (*)(const LaneJacobian& jacobian, std::size_t first, std::size_t last);

/// The hinges of a triangle and the couplings between them that enter the Jacobian. The corners of
/// a hinge are the three vertices of the triangle and one vertex beyond.
struct LanePatch {
  std::int32_t hinges = 0;                             ///< 1 to 3
  std::array<std::int32_t, 3> hinge{};                 ///< their positions: 8·group + lane
  std::array<std::array<std::int8_t, 4>, 3> corner{};  ///< corners of each hinge in the order above
  std::array<std::array<double, 3>, 3> couple{};       ///< N·m, symmetric
  double damping = 0.0;                                ///< s
};

/// Hinges whose moments are a constant matrix W times their angle changes. Per-hinge arrays are
/// stored lane by lane: lane l of group g is at [kGroupLanes·g + l].
struct LanePlate {
  const std::uint32_t* row_begin;  ///< per group, plus one: rows of `kGroupLanes` couplings
  const std::int32_t* column;      ///< of a coupling: position of the other hinge
  const double* couple;            ///< N·m; 0 if there is no coupling
  const LanePatch* patches;
  double* turn;      ///< rad, written by `bends`
  double* moment;    ///< N·m, written by `moments`
  double* gradient;  ///< 1/m, written by `bends`; see lane_plate_kernel.inc
};

/// Doubles of LanePlate::gradient per group, and the padding after the last group.
inline constexpr std::size_t kLaneGradient = 9 * kGroupLanes, kLaneGradientMore = 1;

/// A pass over the groups [first, last) of such hinges.
using PlateLanes = void (*)(const LaneForce& force, const LanePlate& plate, std::size_t first,
                            std::size_t last);

/// Weighted sums of 3×3 blocks, 9 doubles each: to[b] is the sum of weight[weight_of[c]]
/// from[source[c]] for begin[b] <= c < begin[b+1].
struct LaneSums {
  const std::uint32_t *begin, *source, *weight_of;
  const double *weight, *from;
  double* to;
};

/// The most frequently evaluated forces and the sums over their Jacobians, for one vector width.
struct LaneKernel {
  int width = 0;              ///< doubles per vector
  AddLanes hooke = nullptr;   ///< numbers: rest length, stiffness, damping
  AddLanes hinges = nullptr;  ///< numbers: rest angle in [-π, π], stiffness, damping
  ElementParts spring_parts = nullptr, hinge_parts = nullptr;
  AddBlocks spring_blocks = nullptr, hinge_blocks = nullptr;
  /// θ[l] = atan2(y[l], x[l]) for `kGroupLanes` numbers, with an absolute error of 4e-16.
  void (*angle)(const double* y, const double* x, double* theta) = nullptr;
  /// turn[kGroupLanes·(g - first) + l] = θ - θ0 of the hinges; 0 if a triangle has no area.
  void (*turns)(const LaneForce& force, double* turn, std::size_t first,
                std::size_t last) = nullptr;
  /// plate.turn = θ - θ0 + damping·dθ/dt and plate.gradient = ∂θ/∂x.
  PlateLanes bends = nullptr;
  PlateLanes moments = nullptr;  ///< plate.moment = W turn; the diagonal of W is the stiffness
  PlateLanes turning_forces = nullptr;  ///< f -= moment·gradient
  /// blocks += h (h + damping) ∂θ W ∂θᵀ of the patches [first, last), with 36 slots each: first the
  /// vertices of the triangle, then the vertex beyond each hinge.
  void (*patch_blocks)(const LanePlate& plate, const LaneBlocks& blocks, std::size_t first,
                       std::size_t last) = nullptr;
  /// For the blocks [first, last) of `to`.
  void (*sum_blocks)(const LaneSums& sums, std::size_t first, std::size_t last) = nullptr;
};

/// The kernels that this machine supports, narrowest first. All are bit-identical: they perform the
/// same IEEE 754 operations in the same order.
std::span<const LaneKernel> lane_kernels();
/// The widest of these kernels.
const LaneKernel& lane_kernel();

}  // namespace selvedge::detail
