// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/response/ledger.h>
#include <selvedge/scene/scene.h>

#include <map>
#include <span>
#include <string>
#include <vector>

namespace selvedge::detail {

/// Keeps the ledgers of a run's response and fail-safe. What a try of a step does counts once that
/// try is accepted.
class StepLedger {
 public:
  /// A try begins.
  void begin();
  /// The response has corrected the ends of the particles.
  void corrected(std::span<const Vec3> x_t1);
  /// The fail-safe moved the ends of the particles.
  void parted(const ResponseStep& step, std::span<const Vec3> before, std::span<const Vec3> after);
  /// The try is accepted; `v_solved` are the velocities before the response corrected anything,
  /// which `in_solve` were answered already.
  void accept(const ResponseStep& step, const Response& response, std::span<const Vec3> v_solved,
              bool in_solve);

  std::map<std::string, std::map<std::string, double>> figures() const;

 private:
  Ledger response_, fail_safe_, try_fail_safe_;
  std::vector<Vec3> corrected_, v_before_, v_after_;
  std::vector<ContactImpulse> impulses_;
};

/// Refuses numbers of the scene that its response cannot serve: one sentence with the number.
/// `nominal` is the step of the scene, s, `explicit_steps` whether the integrator is explicit.
void refuse_unfit_response(const Scene& scene, const Response& response,
                           std::span<const double> mass, double nominal, bool explicit_steps);

/// Inverse mass, 1/kg, for the step bound of contacts: the lightest particle in two at once.
double contact_inv_mass(std::span<const double> mass);

}  // namespace selvedge::detail
