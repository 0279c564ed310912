// SPDX-License-Identifier: MIT
//
// Y.-M. Kang, J.-H. Choi, H.-G. Cho, "Fast and stable animation of cloth with an approximated
// implicit method", CGI 2000 [KangChoiCho2000; survey eq. 36], and with D.-H. Lee, C.-J. Park,
// "Real-time animation technique for flexible and thin objects", WSCG 2000 [Kang2000]: the constant
// system of Desbrun, approximated instead of solved. With H_ij = K, H_ii = -n_i K (the survey
// prints + on the diagonal, which would make it indefinite) and F̃ = F + h K Σ_j (v_j - v_i),
//   (m + h² K n_i) Δv_i = h F̃_i + h² K Σ_j Δv_j,   Δv_j ≈ h F̃_j/(m + h² K n_j):
// two Jacobi sweeps, O(n). Each link has its own constants (link_constants.h), which include the
// damping as h (h + d) K.
//
// So few sweeps do not spread information. If h² K n is far above m, only the fraction m/(h² K n)
// of gravity remains, and the whole cloth falls as if in honey. `as_printed` behaves this way; the
// corrected method restores the momentum and angular momentum that the forces give to pieces that
// nothing holds. Held cloth has no such correction and moves too slowly. Neither paper was
// available. Guarantee: no growth for any step length (the sweeps always underestimate); one force
// evaluation and two passes over the links; as accurate as implicit Euler only if h² K n/m is below
// 1.
#include <selvedge/core/solver/detail/link_integrator.h>

namespace selvedge {
namespace {

class ImplicitKang final : public detail::LinkIntegrator {
 public:
  ImplicitKang(ForceList forces, std::size_t n, bool corrected)
      : LinkIntegrator(std::move(forces), n, corrected), gathered_(n), first_(n), diagonal_(n) {}

  IntegratorTraits traits() const override {
    return {
        .promise = corrected_
                       ? "stable at any step, O(n); stiff cloth moves too slowly, free pieces fall "
                         "and turn as they should"
                       : "stable at any step, O(n); stiff cloth moves and falls too slowly",
        .source = corrected_ ? "Kang, Choi, Cho, CGI 2000; survey eq. 36 corrected"
                             : "Kang, Choi, Cho, CGI 2000; survey eq. 36 as printed",
        .any_step = true,
        .ends_with_mean = true};
  }

  void begin(const StepStart& start, StepEnd end) override;

 private:
  std::vector<Vec3> gathered_, first_;  // Σ w Δv, kg·m/s; m/s. rhs_ is h F̃
  std::vector<double> diagonal_;        // kg
};

void ImplicitKang::begin(const StepStart& start, StepEnd end) {
  const Particles& p = start.particles;
  const double h = start.h;
  const auto is_free = [&](std::size_t i) { return p.inv_mass[i] > 0.0; };
  links_.fix({p.x, p.v, p.mass, start.time});
  forces_.evaluate({p.x, p.v, p.mass, start.time}, f_);
  // Held particles change their velocity to the prescribed one.
  for (std::size_t i = 0; i < p.size(); ++i) {
    diagonal_[i] = p.mass[i];
    rhs_[i] = h * f_[i];
    gathered_[i].setZero();
  }
  links_.add_laplacian(-h * h, 0.0, p.v, rhs_);
  const auto links = links_.links();
  for (std::size_t l = 0; l < links.size(); ++l)
    for (const std::int32_t i : links[l]) diagonal_[i] += weight(l, h);
  for (std::size_t i = 0; i < p.size(); ++i)
    first_[i] = is_free(i) ? Vec3(rhs_[i] / diagonal_[i]) : Vec3(end.mean[i] - p.v[i]);
  for (std::size_t l = 0; l < links.size(); ++l) {
    const auto [i, j] = links[l];
    gathered_[i] += weight(l, h) * first_[j];
    gathered_[j] += weight(l, h) * first_[i];
  }
  for (std::size_t i = 0; i < p.size(); ++i)
    if (is_free(i)) end.mean[i] = p.v[i] + (rhs_[i] + gathered_[i]) / diagonal_[i];
  if (corrected_) rigid_.apply(p, f_, h, true, end.mean);
}

}  // namespace

void register_implicit_kang(IntegratorRegistry& registry) {
  detail::add_link_integrator<ImplicitKang>(registry, "implicit_kang", "implicit_kang_as_printed");
}

}  // namespace selvedge
