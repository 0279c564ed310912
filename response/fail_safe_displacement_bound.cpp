// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/follow.h>
#include <selvedge/response/detail/reference_motion.h>
#include <selvedge/response/fail_safe.h>

#include <algorithm>
#include <array>

namespace selvedge::detail {
namespace {

// The two sides of a pair may together use up kShare of the part of their distance that exceeds
// kEndGap rest gaps, and kNearShare of the rest. [Chen2025, section 3.5] uses 0.9 for all of the
// distance (0.45 for each side): a gap that is pressed together step after step then loses a
// decimal digit in each and ends at the last bit.
constexpr double kShare = 0.9;
constexpr double kEndGap = 0.1;
constexpr double kNearShare = 0.1;
// Rounding that a bound may be exceeded by; `usable` leaves more.
constexpr double kRounding = 1.0 + 1e-12;

// Distance that the two sides of a pair may use up together, m; less than the distance of the pair.
double usable(const ContactPoint& pair) {
  const double near = std::min(pair.gap, kEndGap * pair.rest_gap);
  return kShare * (pair.gap - near) + kNearShare * near;
}

// Keeps every particle within a ball around the position to which a shared motion would move it
// [Chen2025, section 3.5, eq. 21].
//
// Let a pair have distance g at x_t0. Let each vertex x of its first side end within a of x + s,
// and each vertex of its second side within b of x + s, with the same s for both. Then at every
// time t in [0,1] every point of the first side is within t·a of its initial position shifted by
// t·s, and every point of the second within t·b. So their distance is at least g - t(a + b) > 0 if
// a + b < g. One round suffices, because pairs that are not listed cannot meet (fail_safe.h).
//
// Two free sides share the usable part of g equally. A side whose anchors need more gets more, and
// the other side the rest. Deviations from the paper: its radius covers a contact query of fixed
// size, ours every pair that can meet; anchors have displacements of their own; all displacements
// are measured relative to the shared motion s, so that cloth in free fall is not held back.
class DisplacementBound final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    if (round_++ > 0) {
      failure_reason_ = "bounds on all displacements could not resolve all collisions";
      return false;
    }
    counters_["bound_rounds"] += 1;
    Vec3 shift = shared_shift(hits, step_, x_t1);
    // Anchors that none of the hits touches may still be near. Then all displacements are measured
    // relative to them.
    if (!share_out(shift, x_t1)) {
      shift = shared_shift(crowded_, step_, x_t1);
      if (!share_out(shift, x_t1)) failure_reason_ = jam(crowded_[0], x_t1);
    }
    clip(shift, x_t1);
    return failure_reason_.empty();
  }

  const std::string& failure_reason() const override { return failure_reason_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {.promise =
                "ends by construction in one round, or the step is halved because bodies move "
                "farther than "
                "the distance; gains no energy; slows all cloth that is near something",
            .source = "Chen, Hsu, Liu, Macklin, Yang, Yuksel, Offset geometric contact, 2025"};
  }

 private:
  // Computes the bounds of all particles. Returns false if some pairs leave no room for their
  // anchors.
  bool share_out(const Vec3& shift, std::span<const Vec3> x_t1) {
    clearances_->all(shift, pairs_);
    bound_.assign(step_.motion.particles, -1.0);
    failure_reason_.clear();
    crowded_.clear();
    for (const ContactPoint& pair : pairs_)
      if (!limit(pair, shift, x_t1)) crowded_.push_back(pair);
    return crowded_.empty();
  }

  // Divides a pair's distance between its sides. Returns false if its anchors need all of it.
  bool limit(const ContactPoint& pair, const Vec3& shift, std::span<const Vec3> x_t1) {
    const ContactMotion& motion = step_.motion;
    const int first = first_count(pair);
    std::array<double, 2> need{0.0, 0.0};
    std::array<bool, 2> is_free{false, false};
    for (int k = 0; k < 4; ++k) {
      const std::int32_t i = pair.vertex[k];
      const int side = k < first ? 0 : 1;
      if (motion.inv_mass[i] > 0.0)
        is_free[side] = true;
      else
        need[side] = std::max(need[side], (x_t1[i] - motion.x_t0[i] - shift).norm());
    }
    if (!is_free[0] && !is_free[1]) return true;
    // The motion of anchors is prescribed: the part that they need beyond `usable` may use up all
    // of the distance.
    const double whole = std::max(usable(pair), std::min(kShare * pair.gap, need[0] + need[1]));
    const double spare = whole - need[0] - need[1];
    std::array<double, 2> part = need;
    if (is_free[0] && is_free[1]) {
      part[0] = std::clamp(0.5 * whole, need[0], std::max(need[0], whole - need[1]));
      part[1] = whole - part[0];
    } else {
      part[is_free[0] ? 0 : 1] += spare;
    }
    for (int k = 0; k < 4; ++k) {
      const std::int32_t i = pair.vertex[k];
      if (motion.inv_mass[i] <= 0.0) continue;
      const double most = std::max(0.0, part[k < first ? 0 : 1]);
      bound_[i] = bound_[i] < 0.0 ? most : std::min(bound_[i], most);
    }
    return spare >= 0.0;
  }

  void clip(const Vec3& shift, std::span<Vec3> x_t1) {
    const ContactMotion& motion = step_.motion;
    Vec3 lost = Vec3::Zero();
    double total = 0.0;
    for (std::size_t i = 0; i < motion.particles; ++i) {
      total += step_.mass[i];
      if (bound_[i] < 0.0) continue;
      const Vec3 delta = x_t1[i] - motion.x_t0[i] - shift;
      const double size = delta.norm();
      if (size <= bound_[i]) continue;
      const Vec3 end = motion.x_t0[i] + shift + bound_[i] / size * delta;
      lost += step_.mass[i] * (x_t1[i] - end);
      x_t1[i] = end;
      counters_["bounded_particles"] += 1;
    }
    keep_followers(shift, x_t1);
    // Without held particles and bodies, all particles may move by a common displacement, which
    // keeps momentum.
    if (std::any_of(motion.inv_mass.begin(), motion.inv_mass.end(),
                    [](double w) { return w <= 0.0; }))
      return;
    for (std::size_t i = 0; i < motion.particles; ++i) x_t1[i] += lost / total;
  }

  /// Followers stay the means of their leaders, within their own balls.
  void keep_followers(const Vec3& shift, std::span<Vec3> x_t1) {
    const ContactMotion& motion = step_.motion;
    if (motion.followers == nullptr) return;
    std::vector<Vec3> delta(motion.particles);
    for (std::size_t i = 0; i < delta.size(); ++i) delta[i] = x_t1[i] - motion.x_t0[i] - shift;
    follow(motion, delta, [&](std::int32_t i, const Vec3& d) {
      const double size = d.norm();
      return bound_[i] < 0.0 || size <= kRounding * bound_[i] ? 1.0 : bound_[i] / size;
    });
    for (std::size_t i = 0; i < delta.size(); ++i)
      if (motion.inv_mass[i] > 0.0) x_t1[i] = motion.x_t0[i] + shift + delta[i];
  }

  std::string jam(const ContactPoint& pair, std::span<const Vec3> x_t1) const {
    ContactGroups groups;
    groups.begin(step_.motion);
    groups.merge(pairs_);
    return jam_sentence(groups.groups()[groups.group_of(pair)], step_.motion, x_t1);
  }

  ResponseStep step_;
  Clearances* clearances_ = nullptr;
  std::vector<ContactPoint> pairs_, crowded_;
  std::vector<double> bound_;  // m, for each particle; negative: not bounded
  int round_ = 0;
  std::string failure_reason_;
  std::map<std::string, double> counters_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

std::unique_ptr<FailSafe> make_displacement_bound() {
  return std::make_unique<detail::DisplacementBound>();
}

void register_displacement_bound(FailSafeRegistry& registry) {
  registry.add("displacement_bound", {},
               [](const MethodOptions&) { return make_displacement_bound(); });
}

}  // namespace selvedge
