// SPDX-License-Identifier: MIT
#include <selvedge/core/strain_limiter.h>

namespace selvedge {
namespace {

using Springs = std::span<const Spring>;
using Limits = std::span<const double>;

StrainLimiterEntry method(
    std::function<std::unique_ptr<StrainLimitMethod>(Springs, Limits, std::size_t)> make) {
  const LimiterTraits traits = make({}, {}, 0)->traits();
  return {traits.promise, traits.source, std::move(make), {}};
}

StrainLimiterEntry law(StiffeningLaw which, std::string_view promise, std::string_view source) {
  return {promise, source, {}, [which](Springs springs, Limits limits, std::size_t n) {
            return make_stiffening_force(springs, limits, n, which);
          }};
}

}  // namespace

StrainLimiterRegistry strain_limiters() {
  const auto position = [](bool with_velocity) {
    return method([with_velocity](Springs s, Limits l, std::size_t n) {
      return make_position_limiter(s, l, n, with_velocity);
    });
  };
  const auto ordered = [](const OrderedConfig& config) {
    return method([config](Springs s, Limits l, std::size_t n) {
      return make_ordered_limiter(s, l, n, config);
    });
  };
  const auto velocity = [](bool as_printed) {
    return method([as_printed](Springs s, Limits l, std::size_t n) {
      return make_velocity_limiter(s, l, n, as_printed);
    });
  };
  return {
      {"none", {"springs stretch as their law lets them", "", {}, {}}},
      {"position", position(true)},
      {"position_as_printed", position(false)},
      {"ordered_position", ordered({false, false})},
      {"velocity", velocity(false)},
      {"velocity_as_printed", velocity(true)},
      {"position_velocity", method(make_position_velocity_limiter)},
      {"ordered_position_velocity", ordered({false, true})},
      {"priority_position_velocity", ordered({true, true})},
      {"critical_step",
       {"limits nothing; reports the step and the stiffness that an explicit step bears",
        "Provot 1995; survey eq. 11 mended",
        {},
        {}}},
      {"bayraktar",
       law(StiffeningLaw::bayraktar, "stiffer beyond the limit, continuous; bounds nothing",
           "Bayraktar et al. 2007; survey eq. 12 mended")},
      {"bayraktar_as_printed",
       law(StiffeningLaw::bayraktar_printed,
           "stiffer beyond the limit, where the force jumps; bounds nothing",
           "Bayraktar et al. 2007; survey eq. 12")},
      {"zhibin",
       law(StiffeningLaw::tangent, "41 times as stiff near the limit; slope of Hooke at rest",
           "Zhibin et al.; survey eq. 13 inverted")},
      {"zhibin_as_printed",
       law(StiffeningLaw::tangent_printed, "softens: holds at most 10 % of K L0",
           "Zhibin et al.; survey eq. 13")},
      {"chittaro",
       {"larger constants and shorter steps where the weight of the cloth asks for it",
        "Chittaro, Corvaglia, 3D virtual clothing, 2003; survey 4",
        {},
        {}}},
  };
}

}  // namespace selvedge
