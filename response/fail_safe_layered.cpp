// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/inelastic_projection.h>
#include <selvedge/response/separating_planes.h>

#include <algorithm>

namespace selvedge {
namespace {

// Rounds of projection; each costs a look for collisions.
constexpr int kProjectionRounds = 8;

// Projection makes headway while a round leaves at most this share of the collisions before it.
// What it leaves else are corners where one linear constraint for each collision does not say
// enough.
constexpr double kHeadway = 0.5;

// So few collisions may stay as many: a round for them costs little.
constexpr std::size_t kFew = 16;

// Rounds of planes for the pairs that collide, before all that could get one.
constexpr int kPlaneRounds = 40;

// Inelastic projection with friction while it makes headway, then planes, which end by
// construction. The planes start from where the step would have ended without the projection: what
// that has left half done is crumpled, and collides in directions that have nothing to do with the
// motion. The layers before are the response's own: repulsion and contact forces. There is no rigid
// zone: nothing stands still because something else does.
class Layered final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    if (round_ == 0) {
      projection_.begin(step_, x_t1);
      planes_.begin(step_, x_t1);
      wish_.assign(x_t1.begin(),
                   x_t1.begin() + static_cast<std::ptrdiff_t>(step_.motion.particles));
      plane_round_ = -1;
    }
    if (plane_round_ >= 0) return cut(hits, x_t1);
    const bool headway =
        round_ == 0 ||
        hits.size() <=
            std::max(kFew, static_cast<std::size_t>(kHeadway * static_cast<double>(last_)));
    if (round_++ >= kProjectionRounds || !headway) {
      std::copy(wish_.begin(), wish_.end(), x_t1.begin());
      plane_round_ = 0;
      counters_["planes_after_projection"] += 1;
      return true;
    }
    last_ = hits.size();
    projection_.add(hits);
    projection_.apply(x_t1);
    counters_["projection_rounds"] += 1;
    return true;
  }

  const std::string& trouble() const override { return trouble_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {
        "ends by construction where bodies do not turn; keeps linear momentum, gains no energy, "
        "leaves sliding to Coulomb",
        "Harmon, Vouga, Tamstorf, Grinspun, Robust treatment of simultaneous collisions, 2008; "
        "then separating planes"};
  }

 private:
  bool cut(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) {
    const int round = plane_round_++;
    if (round > kPlaneRounds) {
      trouble_ = "neither projection nor planes part what collides";
      return false;
    }
    counters_["plane_rounds"] += 1;
    if (round < kPlaneRounds) {
      clearances_->at_start(hits, pairs_);
    } else {
      const Vec3 shift = shared_shift(hits, step_, x_t1);
      clearances_->all(shift, pairs_);
      planes_.fix_reference(shift);
      counters_["all_pairs_bounded"] += 1;
    }
    planes_.add(pairs_);
    if (planes_.apply(x_t1)) return true;
    trouble_ = planes_.trouble();
    return false;
  }

  ResponseStep step_;
  Clearances* clearances_ = nullptr;
  InelasticProjection projection_;
  SeparatingPlanes planes_;
  std::vector<ContactPoint> pairs_;
  std::vector<Vec3> wish_;  // where all would end
  std::size_t last_ = 0;    // collisions of the round before
  int round_ = 0, plane_round_ = -1;
  std::string trouble_;
  std::map<std::string, double> counters_;
};

}  // namespace

std::unique_ptr<FailSafe> make_layered() { return std::make_unique<Layered>(); }

}  // namespace selvedge
