// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/detail/step_ledger.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge::detail {
namespace {

// Contacts that one particle is assumed to have before they are known: with a body on one side, and
// cloth on the other.
constexpr double kContactsOfAParticle = 2.0;

}  // namespace

void StepLedger::begin() { try_fail_safe_ = {}; }

void StepLedger::corrected(std::span<const Vec3> x_t1) {
  corrected_.assign(x_t1.begin(), x_t1.end());
}

void StepLedger::parted(const ResponseStep& step, std::span<const Vec3> before,
                        std::span<const Vec3> after) {
  const std::size_t n = step.motion.particles;
  v_before_.resize(n);
  v_after_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    v_before_[i] = (before[i] - step.motion.x_t0[i]) / step.motion.h;
    v_after_[i] = (after[i] - step.motion.x_t0[i]) / step.motion.h;
  }
  try_fail_safe_.add(measure({step.motion, step.mass, {}, v_before_, v_after_}));
}

void StepLedger::accept(const ResponseStep& step, const Response& response,
                        std::span<const Vec3> v_solved, bool in_solve) {
  const std::size_t n = step.motion.particles;
  v_after_.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    v_after_[i] = (corrected_[i] - step.motion.x_t0[i]) / step.motion.h;
  v_before_.assign(v_solved.begin(), v_solved.end());
  if (in_solve) v_before_ = v_after_;
  response.finish(v_after_);
  impulses_.clear();
  response.impulses(step.implicit ? v_solved : std::span<const Vec3>(v_after_), impulses_);
  if (!impulses_.empty() || in_solve)
    response_.add(measure({step.motion, step.mass, impulses_, v_before_, v_after_, in_solve}));
  fail_safe_.add(try_fail_safe_);
}

std::map<std::string, std::map<std::string, double>> StepLedger::figures() const {
  return {{"response", response_.figures()}, {"fail_safe", fail_safe_.figures()}};
}

double contact_inv_mass(std::span<const double> mass) {
  if (mass.empty()) return 0.0;
  return kContactsOfAParticle / *std::min_element(mass.begin(), mass.end());
}

void refuse_unfit_response(const Scene& scene, const Response& response,
                           std::span<const double> mass, double nominal, bool explicit_steps) {
  const ResponseConfig& config = scene.contact.response_config;
  validate(config);
  if (config.restitution > 0.0 && !response.traits().has_restitution)
    throw std::invalid_argument(
        fmt::format("contact.restitution is {}, but contact.response \"{}\" gives nothing back; "
                    "take impulse, reflection or position_velocity",
                    config.restitution, scene.contact.response));
  if (!explicit_steps || mass.empty()) return;
  const double stable = response.stable_step(contact_inv_mass(mass));
  const double shortest = std::ldexp(nominal, -scene.time.max_halvings);
  if (stable < shortest)
    throw std::invalid_argument(fmt::format(
        "contact.stiffness is {:g} N/m and contact.damping {:g} N·s/m, which particles of {:.3g} "
        "kg bear in explicit steps below {:.3g} s; a step of {:.3g} s may be halved {} times, to "
        "{:.3g} s: lower them, raise time.steps_per_frame or take implicit_euler",
        config.stiffness, config.damping, *std::min_element(mass.begin(), mass.end()), stable,
        nominal, scene.time.max_halvings, shortest));
}

}  // namespace selvedge::detail
