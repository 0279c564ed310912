// SPDX-License-Identifier: MIT
//
// Ordered position correction after Y.-M. Kang, J.-H. Choi, H.-G. Cho, "Fast and stable animation
// of cloth with an approximated implicit method", CGI 2000 [KangChoiCho2000; survey 4.2]: the
// excess of all springs is sorted into buckets over its range, O(n), and the worst springs are
// corrected first; the survey does not say how often. Here each sweep has a new order, and sweeps
// continue as in the other limiters, so their costs for the same strain can be compared. For
// positions and velocities in order the survey names V. Dochev, T. Vassilev 2003
// [DochevVassilev2003] without a description. With priority per node, after C. Zhenfang, H. Bing
// 2012 [ZhenfangBing2012; survey 4.5, Figure 19], the first (worst) spring that moves a particle in
// a sweep moves it in full, and each further one by half as much as the one before, so that small
// corrections do not undo large ones; the survey does not say how much. The ends then no longer
// share a correction by mass: momentum is not conserved. Guarantee: as for the position limiter;
// the order is the same for any number of threads (the sweeps are serial).
#include <selvedge/core/solver/detail/register_limiter.h>
#include <selvedge/core/solver/detail/spring_sweeps.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace selvedge {
namespace {

constexpr int kBuckets = 64;

// Factor on the motion of a particle for each spring that has moved it in this sweep.
constexpr double kLess = 0.5;

class OrderedLimiter final : public StrainLimitMethod {
 public:
  OrderedLimiter(std::span<const Spring> springs, std::span<const double> limits,
                 std::size_t particles, const OrderedConfig& config, LimitedStrain limited)
      : limiter_(springs, limits, particles, limited),
        config_(config),
        excess_(springs.size()),
        order_(springs.size()),
        share_(particles) {}

  LimiterTraits traits() const override {
    if (config_.priority)
      return {.promise =
                  "bounds the strain, worst springs first; a particle moved once moves less; does "
                  "not keep momentum",
              .source = "Zhenfang, Bing, Fast cloth simulation, 2012; survey 4.5",
              .keeps_momentum = false,
              .limits = limiter_.limited()};
    return {
        .promise = "bounds the strain, worst springs first; keeps momentum",
        .source = config_.with_velocity
                      ? "Dochev, Vassilev, Efficient super-elasticity handling, 2003; survey 4.5"
                      : "Kang, Choi, Cho, Fast and stable animation of cloth, 2000; survey 4.2",
        .limits = limiter_.limited()};
  }

  const StrainLimiter* limiter() const override { return &limiter_; }
  StrainReport limit_ends(const LimitStep& step, std::span<Vec3> x_t1) override;
  void limit_velocities(const LimitStep& step, std::span<const Vec3> x,
                        std::span<Vec3> v) override {
    if (config_.with_velocity) detail::stop_stretching(limiter_, step, x, v);
  }

 private:
  std::size_t sort(std::span<const Vec3> x, double worst);
  void correct(const LimitStep& step, std::size_t s, std::span<Vec3> x);

  StrainLimiter limiter_;
  OrderedConfig config_;
  std::vector<double> excess_;       // strain beyond the limit
  std::vector<std::int32_t> order_;  // springs beyond their limit, worst bucket first
  std::vector<double> share_;        // fraction of a correction that the particle follows
};

/// Returns the number of springs beyond their limit.
std::size_t OrderedLimiter::sort(std::span<const Vec3> x, double worst) {
  std::array<std::size_t, kBuckets + 1> begin{};
  const auto bucket = [&](double excess) {  // 0: the worst
    const int k = static_cast<int>(kBuckets * (1.0 - excess / worst));
    return static_cast<std::size_t>(std::clamp(k, 0, kBuckets - 1));
  };
  const auto springs = limiter_.springs();
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const double length = (x[springs[s].b] - x[springs[s].a]).norm();
    const double strain = length / springs[s].rest_length - 1.0;
    excess_[s] = strain - limiter_.limits()[s];
    if (limiter_.limits_compression())
      excess_[s] = std::max(excess_[s], -strain - limiter_.limits()[s]);
    if (excess_[s] > 0.0) ++begin[bucket(excess_[s]) + 1];
  }
  for (int k = 0; k < kBuckets; ++k) begin[k + 1] += begin[k];
  const std::size_t count = begin[kBuckets];
  for (std::size_t s = 0; s < springs.size(); ++s)
    if (excess_[s] > 0.0) order_[begin[bucket(excess_[s])]++] = static_cast<std::int32_t>(s);
  return count;
}

void OrderedLimiter::correct(const LimitStep& step, std::size_t s, std::span<Vec3> x) {
  const Spring& spring = limiter_.springs()[s];
  const Vec3 d = x[spring.b] - x[spring.a];
  const double length = d.norm(), allowed = limiter_.allowed_length(s, length);
  const double wa = step.inv_mass[spring.a] * share_[spring.a];
  const double wb = step.inv_mass[spring.b] * share_[spring.b];
  if (length == allowed || length <= 0.0 || wa + wb <= 0.0) return;
  const Vec3 move = ((1.0 - allowed / length) / (wa + wb)) * d;
  x[spring.a] += wa * move;
  x[spring.b] -= wb * move;
  if (!config_.priority) return;
  share_[spring.a] *= kLess;
  share_[spring.b] *= kLess;
}

StrainReport OrderedLimiter::limit_ends(const LimitStep& step, std::span<Vec3> x_t1) {
  StrainReport report = limiter_.measure(x_t1);
  int sweeps = 0;
  while (report.residual > step.tolerance && sweeps < step.max_sweeps) {
    std::fill(share_.begin(), share_.end(), 1.0);
    const std::size_t count = sort(x_t1, report.residual);
    for (std::size_t k = 0; k < count; ++k) correct(step, order_[k], x_t1);
    report = limiter_.measure(x_t1);
    ++sweeps;
  }
  report.sweeps = sweeps;
  return report;
}

}  // namespace

std::unique_ptr<StrainLimitMethod> make_ordered_limiter(std::span<const Spring> springs,
                                                        std::span<const double> limits,
                                                        std::size_t particles,
                                                        const OrderedConfig& config,
                                                        LimitedStrain limited) {
  return std::make_unique<OrderedLimiter>(springs, limits, particles, config, limited);
}

void register_ordered_limiters(StrainLimiterRegistry& registry) {
  const auto add = [&](const char* name, const OrderedConfig& config) {
    detail::register_method(
        registry, name,
        [config](std::span<const Spring> s, std::span<const double> l, std::size_t n,
                 LimitedStrain limited) { return make_ordered_limiter(s, l, n, config, limited); });
  };
  add("ordered_position", {.priority = false, .with_velocity = false});
  add("ordered_position_velocity", {.priority = false, .with_velocity = true});
  add("priority_position_velocity", {.priority = true, .with_velocity = true});
}

}  // namespace selvedge
