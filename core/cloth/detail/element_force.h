// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <vector>

namespace selvedge::detail {

/// Energy derivatives of one element of N particles in one state. The energy depends on a single
/// measure q(x), a length or an angle: f = -(moment + damping·dq/dt) ∂q/∂x. If q is not linear in
/// x, the second derivative of the energy also has a part across ∂q/∂x. Its positive semidefinite
/// part `across`·(w wᵀ ⊗ plane) is kept.
template <int N>
struct ElementSample {
  /// false if the element is degenerate (two ends coincide) and exerts no force.
  bool valid = false;
  double energy = 0.0;
  double moment = 0.0;   ///< dE/dq
  double slope = 0.0;    ///< d²E/dq²
  double damping = 0.0;  ///< moment per dq/dt, >= 0
  std::array<Vec3, N> gradient;
  double across = 0.0;  ///< >= 0
  /// Bound of the norm of the whole part across ∂q/∂x, including its dropped part.
  double bound = 0.0;
  std::array<double, N> weight;
  Mat3 plane;
};

/// An element kind: the particles and the sample of each element.
template <class Kind>
concept ElementKind = requires(const Kind& kind, std::size_t e, std::span<const Vec3> x) {
  { Kind::arity } -> std::convertible_to<int>;
  { kind.size() } -> std::convertible_to<std::size_t>;
  { kind.particle(e, 0) } -> std::convertible_to<std::int32_t>;
  { kind.sample(e, x) } -> std::same_as<ElementSample<Kind::arity>>;
};

/// A force made of elements of one kind. `Kind::reorder(order)` sorts the elements by colour.
template <ElementKind Kind>
class ElementForce : public Force {
 public:
  static constexpr int arity = Kind::arity;

  ElementForce(Kind kind, std::size_t particles) : kind_(std::move(kind)) {
    std::vector<std::int32_t> corners;
    corners.reserve(arity * kind_.size());
    for (std::size_t e = 0; e < kind_.size(); ++e)
      for (int k = 0; k < arity; ++k) {
        require_particle(Kind::name, e, kind_.particle(e, k), particles);
        for (int j = 0; j < k; ++j)
          if (kind_.particle(e, k) == kind_.particle(e, j))
            throw std::invalid_argument(std::string(Kind::name) + " " + std::to_string(e) +
                                        " names particle " + std::to_string(kind_.particle(e, k)) +
                                        " twice");
        corners.push_back(kind_.particle(e, k));
      }
    Coloring coloring = color_elements(corners, arity, particles);
    kind_.reorder(coloring.order);
    color_begin_ = std::move(coloring.color_begin);
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const auto s = kind_.sample(e, state.x);
        if (!s.valid) continue;
        double rate = 0.0;
        for (int k = 0; k < arity; ++k) rate += s.gradient[k].dot(state.v[kind_.particle(e, k)]);
        const double moment = s.moment + s.damping * rate;
        for (int k = 0; k < arity; ++k) f[kind_.particle(e, k)] -= moment * s.gradient[k];
      }
    });
  }

  double energy(const ForceState& state) const override {
    constexpr std::size_t grain = 2048;
    return parallel_sum(kind_.size(), grain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t e = begin; e < end; ++e) sum += kind_.sample(e, state.x).energy;
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (std::size_t e = 0; e < kind_.size(); ++e)
      for (int i = 0; i < arity; ++i)
        for (int j = 0; j < i; ++j) links.push_back({kind_.particle(e, i), kind_.particle(e, j)});
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.assign(kind_.size(), {});
    for (std::size_t e = 0; e < kind_.size(); ++e)
      for (int i = 0; i < arity; ++i)
        for (int j = 0; j < arity; ++j)
          slots_[e][arity * i + j] = matrix.slot(kind_.particle(e, i), kind_.particle(e, j));
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    const std::span<Mat3> values = a.values();
    for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const auto s = kind_.sample(e, state.x);
        if (!s.valid) continue;
        const double along = h * (h * std::max(0.0, s.slope) + s.damping);
        const double across = h * h * s.across;
        for (int i = 0; i < arity; ++i)
          for (int j = 0; j < arity; ++j) {
            Mat3& block = values[slots_[e][arity * i + j]];
            block += (along * s.gradient[i]) * s.gradient[j].transpose();
            if (across > 0.0) block += (across * s.weight[i] * s.weight[j]) * s.plane;
          }
      }
    });
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    for (std::size_t e = 0; e < kind_.size(); ++e) {
      const auto s = kind_.sample(e, state.x);
      if (!s.valid) continue;
      double gradients = 0.0, weights = 0.0;
      for (int k = 0; k < arity; ++k) {
        gradients += s.gradient[k].norm();
        weights += std::abs(s.weight[k]);
      }
      for (int k = 0; k < arity; ++k) {
        const double row = s.gradient[k].norm() * gradients;
        stiffness[kind_.particle(e, k)] +=
            std::abs(s.slope) * row + s.bound * std::abs(s.weight[k]) * weights;
        damping[kind_.particle(e, k)] += s.damping * row;
      }
    }
  }

 protected:
  Kind kind_;

 private:
  std::vector<std::array<std::int32_t, arity * arity>> slots_;
  std::vector<std::size_t> color_begin_;
};

/// Reorders the elements.
template <class Element>
void reorder(std::vector<Element>& elements, std::span<const std::int32_t> order) {
  std::vector<Element> sorted;
  sorted.reserve(elements.size());
  for (const std::int32_t e : order) sorted.push_back(elements[e]);
  elements = std::move(sorted);
}

/// Energy, tension and slope at one length of a link.
struct Tension {
  double energy, force, slope;  // J, N (positive: pulls the ends together), N/m
};

/// The sample of a link between a and b that pulls with `tension(length)`.
template <class Law>
ElementSample<2> sample_link(const Vec3& a, const Vec3& b, double damping, const Law& tension) {
  ElementSample<2> s;
  const Vec3 d = b - a;
  const double length = d.norm();
  const Tension t = tension(length);
  s.energy = t.energy;
  if (length <= 0.0) return s;
  const Vec3 u = d / length;
  s.valid = true;
  s.moment = t.force;
  s.slope = t.slope;
  s.damping = damping;
  s.gradient = {Vec3(-u), u};
  s.weight = {-1.0, 1.0};
  // ∂²E/∂x² = T' u uᵀ + T/L (I - u uᵀ); the second part is negative under compression [ChoiKo2002].
  s.across = std::max(0.0, t.force / length);
  s.bound = std::abs(t.force / length);
  s.plane = Mat3::Identity() - u * u.transpose();
  return s;
}

}  // namespace selvedge::detail
