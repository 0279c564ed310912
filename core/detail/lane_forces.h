// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/detail/lane_groups.h>
#include <selvedge/core/force.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace selvedge::detail {

/// What a kernel walks through. Vectors are given as 3 doubles each.
struct LaneForce {
  const LaneGroup* groups;
  const std::int32_t* particles;
  const double* numbers;  ///< see lane_numbers
  const double* x;        ///< m
  const double* v;        ///< m/s
  double* f;              ///< N, added to
};

/// Where a Jacobian goes: 3×3 blocks of 9 doubles, column by column.
struct LaneBlocks {
  const std::int32_t* slots;  ///< arity² of each element, row by row
  double* values;
  double h;  ///< s
};

/// The same of `state`, f += its forces. Views all of them.
inline LaneForce lane_force(const LaneGroups& lanes, std::span<const double> numbers,
                            const ForceState& state, std::span<Vec3> f) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const auto first = [](auto vectors) { return vectors.empty() ? nullptr : vectors[0].data(); };
  return {lanes.groups.data(), lanes.particles.data(), numbers.data(),
          first(state.x),      first(state.v),         first(f)};
}

/// Where the Jacobian of elements goes whose slots these are. Views both.
template <std::size_t count>
LaneBlocks lane_blocks(const std::vector<std::array<std::int32_t, count>>& slots, BlockMatrix& a,
                       double h) {
  static_assert(sizeof(Mat3) == 9 * sizeof(double));
  if (slots.empty()) return {nullptr, nullptr, h};
  return {slots[0].data(), a.values()[0].data(), h};
}

/// f += the forces of the groups [first, last).
using AddLanes = void (*)(const LaneForce& force, std::size_t first, std::size_t last);

/// blocks += -h ∂f/∂v - h² ∂f/∂x of the groups [first, last), their indefinite part left out.
using AddBlocks = void (*)(const LaneForce& force, const LaneBlocks& blocks, std::size_t first,
                           std::size_t last);

/// The hinges of a triangle, with what a Jacobian has of the couples between them. A hinge's
/// corners are the triangle's three vertices and one beyond.
struct LanePatch {
  std::int32_t hinges = 0;                             ///< 1 to 3
  std::array<std::int32_t, 3> hinge{};                 ///< their places: 8·group + lane
  std::array<std::array<std::int8_t, 4>, 3> corner{};  ///< each one's corners in that order
  std::array<std::array<double, 3>, 3> couple{};       ///< N·m, symmetric
  double damping = 0.0;                                ///< s
};

/// Hinges whose moments are a constant matrix W times their turns. Arrays per hinge are laid out
/// lane by lane, that of lane l of group g at [group_lanes·g + l].
struct LanePlate {
  const std::uint32_t* row_begin;  ///< per group and one more: rows of `group_lanes` couples
  const std::int32_t* column;      ///< of a couple: the place of the other hinge
  const double* couple;            ///< N·m; 0 where there is none
  const LanePatch* patches;
  double* turn;      ///< rad, of `bends`
  double* moment;    ///< N·m, of `moments`
  double* gradient;  ///< 1/m, of `bends`; see lane_plate_kernel.inc
};

/// Doubles of LanePlate::gradient per group, and how many it has more than its groups need.
inline constexpr std::size_t lane_gradient = 9 * group_lanes, lane_gradient_more = 1;

/// A pass over the groups [first, last) of such hinges.
using PlateLanes = void (*)(const LaneForce& force, const LanePlate& plate, std::size_t first,
                            std::size_t last);

/// The forces that are evaluated most often, for one width of vectors.
struct LaneKernel {
  int width = 0;             ///< doubles in a vector; 0: this machine has none such
  AddLanes hooke = nullptr;  ///< numbers: rest length, stiffness, damping
  AddBlocks hinge_blocks = nullptr;
  AddLanes hinges = nullptr;  ///< numbers: rest angle in [-π, π], stiffness, damping
  /// θ[l] = atan2(y[l], x[l]) of `group_lanes` numbers, to 4e-16 absolute.
  void (*angle)(const double* y, const double* x, double* theta) = nullptr;
  /// turn[group_lanes·(g - first) + l] = θ - θ0 of hinges, 0 where a triangle has no area.
  void (*turns)(const LaneForce& force, double* turn, std::size_t first,
                std::size_t last) = nullptr;
  /// plate.turn = θ - θ0 + damping·dθ/dt and plate.gradient = ∂θ/∂x.
  PlateLanes bends = nullptr;
  PlateLanes moments = nullptr;         ///< plate.moment = W turn, stiffness its diagonal
  PlateLanes turning_forces = nullptr;  ///< f -= moment·gradient
  /// blocks += h (h + damping) ∂θ W ∂θᵀ of the patches [first, last), 36 slots each: those of the
  /// triangle's vertices, then of the one beyond each hinge.
  void (*patch_blocks)(const LanePlate& plate, const LaneBlocks& blocks, std::size_t first,
                       std::size_t last) = nullptr;
};

/// Those that this machine has, narrowest first. All give the same bits: the same operations in the
/// same order, each rounded as IEEE 754 has it.
std::span<const LaneKernel> lane_kernels();
/// The widest of them.
const LaneKernel& lane_kernel();

LaneKernel lane_kernel_avx2();
LaneKernel lane_kernel_avx512();

}  // namespace selvedge::detail
