// SPDX-License-Identifier: MIT
// Stops every particle whose contact would end nearer than its rest gap.
#include "additions.h"

namespace adding {
namespace {

using namespace selvedge;

class Stop final : public Response {
 public:
  void begin(const ResponseStep& step) override {
    motion_ = step.motion;
    contacts_.clear();
  }
  void add(std::span<const ContactPoint> contacts) override {
    contacts_.insert(contacts_.end(), contacts.begin(), contacts.end());
  }

  void correct(std::span<Vec3> x_t1) override {
    const std::vector<Vec3> wanted(x_t1.begin(), x_t1.end());
    for (const ContactPoint& c : contacts_) {
      if (relative(c, wanted).dot(c.normal) >= c.rest_gap) continue;
      for (const std::int32_t v : c.vertex)
        if (motion_.inv_mass[v] > 0.0) x_t1[v] = motion_.x_t0[v];  // a free particle
    }
  }

  ResponseTraits traits() const override {
    return {.promise = "particles in a contact that closes do not move",
            .source = "docs/adding.md"};
  }

 private:
  ContactMotion motion_;
  std::vector<ContactPoint> contacts_;
};

}  // namespace

void register_stop(ResponseRegistry& registry) {
  registry.add("stop", {}, [](const MethodOptions&) { return std::make_unique<Stop>(); });
}

}  // namespace adding
