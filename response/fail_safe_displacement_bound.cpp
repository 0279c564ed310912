// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/reference_motion.h>

#include <algorithm>
#include <array>

namespace selvedge {
namespace {

// Share of a distance beyond kEndGap rest gaps that the two sides of a pair may use up together,
// and of what is below. [Chen2025, section 3.5] has 0.9 for all of it (0.45 for each side): pressed
// together step after step, a gap then loses a decimal in each and ends in the last bit.
constexpr double kShare = 0.9;
constexpr double kEndGap = 0.1;
constexpr double kNearShare = 0.1;

// Distance that the two sides of a pair may use up together, m; below that of the pair.
double usable(const ContactPoint& pair) {
  const double near = std::min(pair.gap, kEndGap * pair.rest_gap);
  return kShare * (pair.gap - near) + kNearShare * near;
}

// Every particle keeps within a ball about where a motion shared by all would bring it
// [Chen2025, section 3.5, eq. 21].
//
// Let a pair have distance g at x_t0, and let each vertex x of its first side end within a of
// x + s, each of its second side within b of x + s, with one s for both. Then at every time
// t in [0,1] every point of the first side is within t·a of where it was, shifted by t·s, and of
// the second within t·b. So their distance is at least g - t(a + b) > 0 if a + b < g. One round
// suffices, for pairs that are not asked about cannot meet (clearances.h).
//
// Free sides share what is usable of g in halves; a side that an anchor needs more of gets that,
// and the other what is left. Deviations from the paper: its radius covers a contact query of fixed
// size, ours every pair that can meet; anchors have displacements of their own; all is counted from
// the shared motion s, so that cloth in free fall is not held back.
class DisplacementBound final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    if (round_++ > 0) {
      trouble_ = "pairs collide that bounds on all displacements should part";
      return false;
    }
    counters_["bound_rounds"] += 1;
    Vec3 shift = shared_shift(hits, step_, x_t1);
    // Anchors that none of the hits meets may be near all the same: then all is counted from them.
    if (!share_out(shift, x_t1)) {
      shift = shared_shift(crowded_, step_, x_t1);
      if (!share_out(shift, x_t1)) trouble_ = jam(crowded_[0], x_t1);
    }
    clip(shift, x_t1);
    return trouble_.empty();
  }

  const std::string& trouble() const override { return trouble_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {
        "ends by construction in one round, or bodies move by more than the distance and the "
        "step is halved; gains no energy; holds up all that is near",
        "Chen, Hsu, Liu, Macklin, Yang, Yuksel, Offset geometric contact, 2025"};
  }

 private:
  // The bounds of all particles. False: some pairs have no room for their anchors.
  bool share_out(const Vec3& shift, std::span<const Vec3> x_t1) {
    clearances_->all(shift, pairs_);
    bound_.assign(step_.motion.particles, -1.0);
    trouble_.clear();
    crowded_.clear();
    for (const ContactPoint& pair : pairs_)
      if (!limit(pair, shift, x_t1)) crowded_.push_back(pair);
    return crowded_.empty();
  }

  // Shares a pair's distance. False: its anchors need all of it.
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
    // Anchors go where they go: what they need beyond `usable` may cost all of the distance.
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
    // Where nothing is held or a body, all may move on together: momentum is kept.
    if (std::any_of(motion.inv_mass.begin(), motion.inv_mass.end(),
                    [](double w) { return w <= 0.0; }))
      return;
    for (std::size_t i = 0; i < motion.particles; ++i) x_t1[i] += lost / total;
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
  std::vector<double> bound_;  // m, of each particle; negative: none
  int round_ = 0;
  std::string trouble_;
  std::map<std::string, double> counters_;
};

}  // namespace

std::unique_ptr<FailSafe> make_displacement_bound() {
  return std::make_unique<DisplacementBound>();
}

}  // namespace selvedge
