// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/detail/lane_groups.h>
#include <selvedge/core/force.h>

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

/// The forces that are evaluated most often, for one width of vectors.
struct LaneKernel {
  int width = 0;             ///< doubles in a vector; 0: this machine has none such
  AddLanes hooke = nullptr;  ///< numbers: rest length, stiffness, damping
  AddBlocks hinge_blocks = nullptr;
  AddLanes hinges = nullptr;  ///< numbers: rest angle in [-π, π], stiffness, damping
  /// θ[l] = atan2(y[l], x[l]) of `group_lanes` numbers, to 4e-16 absolute.
  void (*angle)(const double* y, const double* x, double* theta) = nullptr;
};

/// Those that this machine has, narrowest first. All give the same bits: the same operations in the
/// same order, each rounded as IEEE 754 has it.
std::span<const LaneKernel> lane_kernels();
/// The widest of them.
const LaneKernel& lane_kernel();

LaneKernel lane_kernel_avx2();
LaneKernel lane_kernel_avx512();

}  // namespace selvedge::detail
