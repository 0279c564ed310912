// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/response.h>
#include <selvedge/scene/scene.h>
#include <selvedge/simulation/detail/step.h>

#include <map>
#include <optional>
#include <span>
#include <string>

namespace selvedge::detail {

/// Sums the ledgers of a run's response and fail-safe over its accepted steps.
class StepLedger {
 public:
  void accept(const StepOutcome& outcome);

  /// Goes on adding to figures of an earlier part of the run, by stage.
  void continue_from(const std::map<std::string, std::map<std::string, double>>& figures);

  /// By stage ("response", "fail_safe"), the figures of its ledger.
  std::map<std::string, std::map<std::string, double>> figures() const;

 private:
  Ledger response_, fail_safe_;
};

/// What a response exchanged that led to these velocities of a solve and then to these ends, m;
/// nullopt: nothing. `response` is as the solve left it.
std::optional<Ledger> exchanged_by_response(const ResponseStep& step, const Response& response,
                                            const SolvedVelocities& v, std::span<const Vec3> ends);

/// What a stage exchanged that moved the ends of the particles from `before` to `after`, m.
Ledger exchanged_by_ends(const ResponseStep& step, std::span<const Vec3> before,
                         std::span<const Vec3> after);

/// Throws std::invalid_argument where explicit steps of the scene, halved as often as it allows,
/// are too long for its response. `mass`: kg, of the particles.
void refuse_unfit_response(const Scene& scene, const ResponseRegistry& responses,
                           const Response& response, std::span<const double> mass);

/// Inverse mass, 1/kg, for the step bound of contacts: the lightest particle in two contacts.
double contact_inv_mass(std::span<const double> mass);

}  // namespace selvedge::detail
