// SPDX-License-Identifier: MIT
#include <selvedge/response/fail_safe.h>
#include <selvedge/response/inelastic_projection.h>
#include <selvedge/response/separating_planes.h>

namespace selvedge {
namespace {

// Rounds of projection; each costs a look for collisions. What is left after so many are corners
// where one linear constraint for each collision does not say enough.
constexpr int kProjectionRounds = 8;

// Rounds of planes for the pairs that collide, before all that could get one.
constexpr int kPlaneRounds = 40;

// Inelastic projection with friction while it makes headway, then planes, which end by
// construction. The layers before are the response's own: repulsion and contact forces. There is
// no rigid zone: nothing stands still because something else does.
class Layered final : public FailSafe {
 public:
  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    const int round = round_++;
    if (round == 0) projection_.begin(step_, x_t1);
    if (round < kProjectionRounds) {
      projection_.add(hits);
      projection_.apply(x_t1);
      counters_["projection_rounds"] += 1;
      return true;
    }
    if (round == kProjectionRounds) planes_.begin(step_, x_t1);
    return cut(round - kProjectionRounds, hits, x_t1);
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
  bool cut(int round, std::span<const ContactPoint> hits, std::span<Vec3> x_t1) {
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
  int round_ = 0;
  std::string trouble_;
  std::map<std::string, double> counters_;
};

}  // namespace

std::unique_ptr<FailSafe> make_layered() { return std::make_unique<Layered>(); }

}  // namespace selvedge
