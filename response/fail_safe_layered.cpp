// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/inelastic_projection.h>
#include <selvedge/response/detail/separating_planes.h>
#include <selvedge/response/fail_safe.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

// Projection makes progress while a round leaves at most this share of the previous collisions. The
// collisions that remain otherwise are at corners, where one linear constraint per collision is not
// enough.
constexpr double kHeadway = 0.5;

// A collision count this small may stagnate: another round costs little.
constexpr std::size_t kFew = 16;

// Inelastic projection with friction while it makes progress, then separating planes, which
// terminate by construction. The planes start from the end positions before the projection: an
// unfinished projection leaves the cloth crumpled, with collisions in directions unrelated to the
// motion. The layers before this one, repulsion and contact forces, belong to the response. There
// are no rigid zones, so no particle stops only because a neighbour does.
class Layered final : public FailSafe {
 public:
  explicit Layered(const FailSafeRounds& rounds) : rounds_(rounds) {}

  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    if (round_ == 0) {
      projection_.begin(step_, x_t1);
      planes_.begin(step_, x_t1);
      desired_.assign(x_t1.begin(),
                      x_t1.begin() + static_cast<std::ptrdiff_t>(step_.motion.particles));
      plane_round_ = -1;
    }
    if (plane_round_ >= 0) return cut(hits, x_t1);
    const bool headway =
        round_ == 0 ||
        hits.size() <=
            std::max(kFew, static_cast<std::size_t>(kHeadway * static_cast<double>(last_)));
    if (round_++ >= rounds_.projection_rounds || !headway) {
      std::copy(desired_.begin(), desired_.end(), x_t1.begin());
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

  const std::string& failure_reason() const override { return failure_reason_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {
        .promise =
            "ends by construction where bodies do not rotate; keeps linear momentum, gains no "
            "energy, "
            "Coulomb friction",
        .source =
            "Harmon, Vouga, Tamstorf, Grinspun, Robust treatment of simultaneous collisions, 2008; "
            "then separating planes"};
  }

 private:
  bool cut(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) {
    const int round = plane_round_++;
    if (round > rounds_.plane_rounds) {
      failure_reason_ = "projection and separating planes could not resolve all collisions";
      return false;
    }
    counters_["plane_rounds"] += 1;
    if (round < rounds_.plane_rounds) {
      clearances_->at_start(hits, pairs_);
    } else {
      const Vec3 shift = shared_shift(hits, step_, x_t1);
      clearances_->all(shift, pairs_);
      planes_.fix_reference(shift);
      counters_["all_pairs_bounded"] += 1;
    }
    planes_.add(pairs_);
    if (planes_.apply(x_t1)) return true;
    failure_reason_ = planes_.failure_reason();
    return false;
  }

  const FailSafeRounds rounds_;
  ResponseStep step_;
  Clearances* clearances_ = nullptr;
  InelasticProjection projection_;
  SeparatingPlanes planes_;
  std::vector<ContactPoint> pairs_;
  std::vector<Vec3> desired_;  // end positions before the fail-safe
  std::size_t last_ = 0;       // number of collisions in the previous round
  int round_ = 0, plane_round_ = -1;
  std::string failure_reason_;
  std::map<std::string, double> counters_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

std::unique_ptr<FailSafe> make_layered(const FailSafeRounds& rounds) {
  return std::make_unique<detail::Layered>(rounds);
}

void register_layered(FailSafeRegistry& registry) {
  registry.add("layered", {}, [](const MethodOptions&) { return make_layered(); });
}

}  // namespace selvedge
