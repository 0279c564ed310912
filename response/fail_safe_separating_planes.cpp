// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/separating_planes.h>
#include <selvedge/response/fail_safe.h>

namespace selvedge::detail {
namespace {

// Separating planes (separating_planes.h) for the pairs that collide and, in the last round, for
// all pairs that could.
class PlanesAlone final : public FailSafe {
 public:
  explicit PlanesAlone(int rounds) : rounds_(rounds) {}

  void begin(const ResponseStep& step, Clearances& clearances) override {
    step_ = step;
    clearances_ = &clearances;
    round_ = 0;
  }

  bool resolve(std::span<const ContactPoint> hits, std::span<Vec3> x_t1) override {
    if (round_ == 0) planes_.begin(step_, x_t1);
    counters_["plane_rounds"] += 1;
    if (round_ < rounds_) {
      clearances_->at_start(hits, pairs_);
    } else if (round_ == rounds_) {
      const Vec3 shift = shared_shift(hits, step_, x_t1);
      clearances_->all(shift, pairs_);
      planes_.fix_reference(shift);
      counters_["all_pairs_bounded"] += 1;
    } else {
      failure_reason_ = "separating planes could not resolve all collisions";
      return false;
    }
    ++round_;
    planes_.add(pairs_);
    if (planes_.apply(x_t1)) return true;
    failure_reason_ = planes_.failure_reason();
    return false;
  }

  const std::string& failure_reason() const override { return failure_reason_; }
  const std::map<std::string, double>& counters() const override { return counters_; }
  ResponseTraits traits() const override {
    return {.promise =
                "ends by construction where bodies do not rotate; keeps linear momentum, gains no "
                "energy, "
                "allows sliding",
            .source = "separating axes of convex sets, one plane for each pair; ours"};
  }

 private:
  const int rounds_;
  ResponseStep step_;
  Clearances* clearances_ = nullptr;
  SeparatingPlanes planes_;
  std::vector<ContactPoint> pairs_;
  int round_ = 0;
  std::string failure_reason_;
  std::map<std::string, double> counters_;
};

}  // namespace
}  // namespace selvedge::detail

namespace selvedge {

std::unique_ptr<FailSafe> make_separating_planes(const FailSafeRounds& rounds) {
  return std::make_unique<detail::PlanesAlone>(rounds.plane_rounds);
}

void register_separating_planes(FailSafeRegistry& registry) {
  registry.add("separating_planes", {},
               [](const MethodOptions&) { return make_separating_planes(); });
}

}  // namespace selvedge
