// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/simulation/detail/step_ledger.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace selvedge::detail {
namespace {

// Contacts that one particle is assumed to have before they are known: with a body on one side and
// cloth on the other.
constexpr double kContactsOfAParticle = 2.0;

constexpr std::size_t kLedgerGrain = 2048;  // particles per task

/// The inverse of Ledger::figures; 0 for figures that are missing.
Ledger ledger_of(const std::map<std::string, double>& figures) {
  const auto figure = [&](const std::string& name) {
    const auto found = figures.find(name);
    return found == figures.end() ? 0.0 : found->second;
  };
  const auto vector = [&](const std::string& name) {
    return Vec3(figure(name + "_x"), figure(name + "_y"), figure(name + "_z"));
  };
  return {.steps = static_cast<int>(figure("steps")),
          .to_particles = vector("to_particles"),
          .to_anchors = vector("to_anchors"),
          .turn_particles = vector("turn_particles"),
          .turn_anchors = vector("turn_anchors"),
          .momentum_error = figure("max_momentum_error"),
          .angular_error = figure("max_angular_error"),
          .energy_normal = figure("energy_normal_J"),
          .energy_friction = figure("energy_friction_J"),
          .energy_gained = figure("energy_gained_J"),
          .energy_kinetic = figure("energy_kinetic_J")};
}

}  // namespace

Ledger exchanged_by_ends(const ResponseStep& step, std::span<const Vec3> before,
                         std::span<const Vec3> after) {
  const std::size_t n = step.motion.particles;
  std::vector<Vec3> v_before(n), v_after(n);
  for (std::size_t i = 0; i < n; ++i) {
    v_before[i] = (before[i] - step.motion.x_t0[i]) / step.motion.h;
    v_after[i] = (after[i] - step.motion.x_t0[i]) / step.motion.h;
  }
  return measure({step.motion, step.mass, {}, v_before, v_after});
}

std::optional<Ledger> exchanged_by_response(const ResponseStep& step, const Response& response,
                                            const SolvedVelocities& v, std::span<const Vec3> ends) {
  const std::size_t n = step.motion.particles;
  std::vector<Vec3> v_before(n), v_after(n);
  parallel_for(n, kLedgerGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      v_after[i] = (ends[i] - step.motion.x_t0[i]) / step.motion.h;
      v_before[i] = v.answered ? v_after[i] : v.mean[i];
    }
  });
  response.finish(v_after);
  std::vector<ContactImpulse> impulses;
  response.impulses(step.implicit ? v.mean : v_after, impulses);
  if (impulses.empty() && !v.answered) return std::nullopt;
  return measure({step.motion, step.mass, impulses, v_before, v_after, v.answered});
}

void StepLedger::accept(const StepOutcome& outcome) {
  if (const auto& exchanged = outcome.parting.ends.response) response_.add(*exchanged);
  fail_safe_.add(outcome.parting.fail_safe);
}

void StepLedger::continue_from(
    const std::map<std::string, std::map<std::string, double>>& figures) {
  if (const auto found = figures.find("response"); found != figures.end())
    response_ = ledger_of(found->second);
  if (const auto found = figures.find("fail_safe"); found != figures.end())
    fail_safe_ = ledger_of(found->second);
}

std::map<std::string, std::map<std::string, double>> StepLedger::figures() const {
  return {{"response", response_.figures()}, {"fail_safe", fail_safe_.figures()}};
}

double contact_inv_mass(std::span<const double> mass) {
  if (mass.empty()) return 0.0;
  return kContactsOfAParticle / *std::min_element(mass.begin(), mass.end());
}

void refuse_unfit_response(const Scene& scene, const ResponseRegistry& responses,
                           const Response& response, std::span<const double> mass) {
  if (mass.empty()) return;
  const double stable = response.stable_step(contact_inv_mass(mass));
  const double nominal = 1.0 / (scene.time.fps * scene.time.steps_per_frame);
  const double shortest = std::ldexp(nominal, -scene.time.max_halvings);
  if (stable >= shortest) return;
  const std::vector<MethodOption>& options = responses.at(scene.contact.response).options();
  const MethodOptions values =
      complete_options("contact.response", options, scene.contact.response_options);
  throw std::invalid_argument(fmt::format(
      "contact.response \"{}\" ({}) is stable for particles of {:.3g} kg in explicit steps below "
      "{:.3g} s; a step of {:.3g} s may be halved {} times, to {:.3g} s: soften the contacts, "
      "raise "
      "time.steps_per_frame or take implicit_euler",
      scene.contact.response, options_text(options, values),
      *std::min_element(mass.begin(), mass.end()), stable, nominal, scene.time.max_halvings,
      shortest));
}

}  // namespace selvedge::detail
