// SPDX-License-Identifier: MIT
//
// The hysteresis loop of bending, M = B κ ± HB (S. Kawabata), for triangle meshes: the term ±HB,
// modelled by sliders as in force_friction.cpp for the hinges of grids. Here it acts on the
// curvature tensor K of a triangle as defined in detail/shape_operator.cpp, which is exact for
// constant curvature on any mesh: for a cylinder of any direction |K| = κ. The tensor sticks to a
// value S that changes only when a step is accepted. Within a step the moment is the gradient of
//   E = ½ (M/y) |K - S|² for |K - S| <= y, M (|K - S| - y/2) beyond,  M = HB·area.
// Accepting a step never increases E, so energy can only be lost.
//
// Jacobian: the tensor of a triangle depends on the vertices of its neighbours' neighbours. As in
// force_shape_operator.cpp, couplings between hinges are replaced by diagonal terms that bound
// them.
#include <selvedge/core/cloth/detail/block_jacobian.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/lane_forces.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace selvedge {
namespace {

using detail::kGroupLanes;

// Groups and frictions per task.
constexpr std::size_t kGrain = 128, kFrictionGrain = 512;
constexpr const char* kName = "curvature friction";

/// State of one friction element.
struct Slide {
  Vec3 off;     // distance to S
  double size;  // norm of `off`
  double rate;  // moment per curvature, N·m³
};

class CurvatureFrictionForce final : public Force {
 public:
  CurvatureFrictionForce(std::span<const Hinge> hinges,
                         std::span<const CurvatureFriction> frictions, std::size_t particles) {
    validate(hinges, frictions, particles);
    std::vector<char> used(hinges.size(), 0);
    for (const CurvatureFriction& friction : frictions)
      for (const auto& term : friction.terms) used[term.hinge] = 1;
    std::vector<std::int32_t> place(hinges.size(), -1);
    set_hinges(hinges, used, particles, place);
    begin_.push_back(0);
    for (const CurvatureFriction& friction : frictions) {
      moment_of_.push_back(friction.moment);
      yield_.push_back(friction.yield);
      for (const auto& term : friction.terms) {
        place_.push_back(place[term.hinge]);
        curvature_.push_back(term.curvature);
      }
      begin_.push_back(static_cast<std::uint32_t>(place_.size()));
    }
    set_terms_of_places();
    slip_.assign(frictions.size(), Vec3::Zero());
    tensor_.resize(frictions.size());
    bound_.resize(place_.size());
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    measure(state);
    set_moments();
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, f);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      detail::lane_kernel().turning_forces(force, plate(), detail::group_of(begin),
                                           detail::group_of(end));
    });
  }

  double energy(const ForceState& state) const override {
    measure(state);
    return parallel_sum(size(), kFrictionGrain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t t = begin; t < end; ++t) {
        const double off = slide_of(t).size, y = yield_[t];
        sum += moment_of_[t] * (off <= y ? 0.5 * off * off / y : off - 0.5 * y);
      }
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const Hinge& hinge : hinges_)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j) links.push_back({hinge.v[i], hinge.v[j]});
  }

  void bind(const BlockMatrix& matrix) override {
    std::vector<std::int32_t> corners;
    for (const Hinge& hinge : hinges_)
      corners.insert(corners.end(), hinge.v.begin(), hinge.v.end());
    jacobian_.bind(corners, matrix);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    jacobian_rows(state, h);
    jacobian_.add(a);
  }

  const JacobianRows* jacobian_rows(const ForceState& state, double h) const override {
    measure(state);
    set_bounds(true);
    jacobian_.find_numbers(lanes_, detail::lane_force(lanes_, numbers_, state, {}), h);
    return &jacobian_;
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double>) const override {
    measure(state);
    set_moments();
    set_bounds(false);
    for (std::size_t e = 0; e < hinges_.size(); ++e) {
      const std::size_t p = place_of_[e];
      const double* at =
          gradient_.data() + detail::kLaneGradient * (p / kGroupLanes) + 3 * (p % kGroupLanes);
      const Eigen::Map<const Vec3> g0(at), g1(at + 3 * kGroupLanes), g3(at + 6 * kGroupLanes);
      const std::array<double, 4> norm{g0.norm(), g1.norm(), (g0 + g1 + g3).norm(), g3.norm()};
      // The second derivative of the angle is at most about twice the product of the gradients.
      const double row =
          (stiffness_at(p) + 2.0 * std::abs(moment_[p])) * (norm[0] + norm[1] + norm[2] + norm[3]);
      for (int k = 0; k < 4; ++k) stiffness[hinges_[e].v[k]] += row * norm[k];
    }
  }

  void accept(const ForceState& state) override {
    measure(state);
    for (std::size_t t = 0; t < size(); ++t) {
      const Slide s = slide_of(t);
      if (s.size > yield_[t]) slip_[t] += (1.0 - yield_[t] / s.size) * s.off;
    }
  }

  void save_memory(std::vector<double>& memory) const override {
    for (const Vec3& s : slip_) memory.insert(memory.end(), s.begin(), s.end());
  }

  std::span<const double> restore_memory(std::span<const double> memory) override {
    detail::require_memory(kName, memory.size(), 3 * size());
    for (std::size_t t = 0; t < size(); ++t) slip_[t] = Eigen::Map<const Vec3>(&memory[3 * t]);
    return memory.subspan(3 * size());
  }

 private:
  std::size_t size() const { return yield_.size(); }

  static void validate(std::span<const Hinge> hinges, std::span<const CurvatureFriction> frictions,
                       std::size_t particles) {
    for (std::size_t i = 0; i < hinges.size(); ++i) {
      for (const std::int32_t v : hinges[i].v) detail::require_particle("hinge", i, v, particles);
      detail::require_number_of("size of rest_angle", "hinge", i, std::abs(hinges[i].rest_angle));
    }
    for (std::size_t i = 0; i < frictions.size(); ++i) {
      detail::require_number_of("moment", kName, i, frictions[i].moment);
      detail::require_number_of("yield", kName, i, frictions[i].yield, false);
      for (const auto& term : frictions[i].terms) {
        detail::require_particle(kName, i, term.hinge, hinges.size());
        detail::require_number_of("size of curvature", kName, i, term.curvature.norm());
      }
    }
  }

  void set_hinges(std::span<const Hinge> hinges, const std::vector<char>& used,
                  std::size_t particles, std::vector<std::int32_t>& place) {
    std::vector<std::int32_t> number, corners;
    for (std::size_t i = 0; i < hinges.size(); ++i) {
      if (used[i] == 0) continue;
      number.push_back(static_cast<std::int32_t>(i));
      corners.insert(corners.end(), hinges[i].v.begin(), hinges[i].v.end());
    }
    detail::Coloring coloring = detail::color_elements(corners, 4, particles);
    lanes_ = detail::make_lane_groups(corners, 4, coloring);
    for (const std::int32_t i : coloring.order) hinges_.push_back(hinges[number[i]]);
    color_begin_ = std::move(coloring.color_begin);
    numbers_ = detail::lane_numbers<3>(lanes_, hinges_, [](const Hinge& h) {
      return std::array{std::remainder(h.rest_angle, 2.0 * std::numbers::pi), 0.0, 0.0};
    });
    for (std::size_t g = 0; g < lanes_.groups.size(); ++g)
      for (std::int16_t l = 0; l < lanes_.groups[g].count; ++l) {
        place[number[coloring.order[place_of_.size()]]] =
            static_cast<std::int32_t>(kGroupLanes * g + l);
        place_of_.push_back(kGroupLanes * g + l);
      }
    turn_.assign(kGroupLanes * lanes_.groups.size(), 0.0);
    moment_ = turn_;
    gradient_.resize(detail::kLaneGradient * lanes_.groups.size() + detail::kLaneGradientMore);
  }

  void set_terms_of_places() {
    terms_begin_.assign(turn_.size() + 1, 0);
    for (const std::int32_t p : place_) ++terms_begin_[p + 1];
    for (std::size_t p = 0; p < turn_.size(); ++p) terms_begin_[p + 1] += terms_begin_[p];
    std::vector<std::uint32_t> next(terms_begin_.begin(), terms_begin_.end() - 1);
    terms_.resize(place_.size());
    friction_of_.resize(place_.size());
    for (std::size_t t = 0; t < size(); ++t)
      for (std::uint32_t i = begin_[t]; i < begin_[t + 1]; ++i) {
        terms_[next[place_[i]]++] = i;
        friction_of_[i] = static_cast<std::uint32_t>(t);
      }
  }

  detail::LanePlate plate() const {
    return {nullptr, nullptr, nullptr, nullptr, turn_.data(), moment_.data(), gradient_.data()};
  }

  void measure(const ForceState& state) const {
    const detail::LaneForce force = detail::lane_force(lanes_, numbers_, state, {});
    parallel_for(lanes_.groups.size(), kGrain, [&](std::size_t first, std::size_t last) {
      detail::lane_kernel().bends(force, plate(), first, last);
    });
  }

  Slide slide_of(std::size_t t) const {
    Vec3 off = -slip_[t];
    for (std::uint32_t i = begin_[t]; i < begin_[t + 1]; ++i)
      off += turn_[place_[i]] * curvature_[i];
    const double size = off.norm();
    return {off, size, moment_of_[t] / std::max(size, yield_[t])};
  }

  /// Sets moment_ of all hinges from the moments of the tensors.
  void set_moments() const {
    parallel_for(size(), kFrictionGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Slide s = slide_of(t);
        tensor_[t] = s.rate * s.off;
      }
    });
    parallel_for(turn_.size(), kGroupLanes * kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        moment_[p] = 0.0;
        for (std::uint32_t k = terms_begin_[p]; k < terms_begin_[p + 1]; ++k)
          moment_[p] += curvature_[terms_[k]].dot(tensor_[friction_of_[terms_[k]]]);
      }
    });
  }

  double& stiffness_at(std::size_t p) const {
    return numbers_[kGroupLanes * (3 * (p / kGroupLanes) + 1) + p % kGroupLanes];
  }

  /// Sets the stiffness of all hinges, an upper bound of that of the tensors. A slipping tensor has
  /// no stiffness along its moment (if `slipping`), but keeps it across.
  void set_bounds(bool slipping) const {
    parallel_for(size(), kFrictionGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        const Slide s = slide_of(t);
        Mat3 slope = s.rate * Mat3::Identity();
        if (slipping && s.size > yield_[t])
          slope -= s.rate / (s.size * s.size) * s.off * s.off.transpose();
        for (std::uint32_t i = begin_[t]; i < begin_[t + 1]; ++i) {
          const Vec3 row = slope * curvature_[i];
          bound_[i] = 0.0;
          for (std::uint32_t j = begin_[t]; j < begin_[t + 1]; ++j)
            bound_[i] += std::abs(row.dot(curvature_[j]));
        }
      }
    });
    parallel_for(turn_.size(), kGroupLanes * kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        stiffness_at(p) = 0.0;
        for (std::uint32_t k = terms_begin_[p]; k < terms_begin_[p + 1]; ++k)
          stiffness_at(p) += bound_[terms_[k]];
      }
    });
  }

  std::vector<Hinge> hinges_;
  std::vector<std::size_t> place_of_;  // per hinge: kGroupLanes·group + lane
  detail::LaneGroups lanes_;
  std::vector<std::size_t> color_begin_;
  std::vector<double> moment_of_, yield_;  // per friction
  std::vector<std::uint32_t> begin_;       // start of the terms of each friction
  std::vector<std::int32_t> place_;        // per term: position of its hinge
  std::vector<Vec3> curvature_;            // per term
  std::vector<std::uint32_t> friction_of_;
  std::vector<std::uint32_t> terms_begin_, terms_;  // terms of each position
  std::vector<Vec3> slip_;                          // 1/m, per friction: the value S it sticks to
  mutable std::vector<double> numbers_, turn_, moment_, gradient_, bound_;  // scratch
  mutable detail::BlockJacobian jacobian_{detail::kHingeKind};  // its numbers are scratch
  mutable std::vector<Vec3> tensor_;
};

}  // namespace

std::unique_ptr<Force> make_curvature_friction(std::span<const Hinge> hinges,
                                               std::span<const CurvatureFriction> frictions,
                                               std::size_t particles) {
  return std::make_unique<CurvatureFrictionForce>(hinges, frictions, particles);
}

}  // namespace selvedge
