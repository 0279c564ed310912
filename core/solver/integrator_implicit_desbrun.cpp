// SPDX-License-Identifier: MIT
//
// M. Desbrun, P. Schröder, A. Barr, "Interactive animation of structured deformable objects",
// Graphics Interface 1999 [Desbrun1999; survey eq. 35]: implicit Euler with a constant matrix, (M -
// h² H) Δv = h (F + h H v), H_ij = K_ij, H_ii = -Σ_j K_ij (the survey's third line, H_ii = 0, is
// for pairs without a link), as if springs had zero rest length. The matrix is factored once, and
// again only when the step length or the set of held particles changes. This implementation uses a
// sparse Cholesky factorisation instead of the inverse. Each link has its own constants
// (link_constants.h), which include the damping as h (h + d) K.
//
// The constant matrix resists rotation as if it were stretch, so it slows the rotation of the
// cloth. The paper restores the torque, F_i^corr = (x_G - x_i) × δT h, whose units do not match.
// Here a rigid rotation restores the missing angular momentum of pieces that nothing holds (if
// something holds a piece, its torque is unknown). `uncorrected` omits that. Guarantee: no growth
// for any step length while no link becomes stiffer than when the matrix was made; conserves
// momentum and, if corrected, angular momentum to rounding. Contacts act after the step, as with an
// explicit method.
#include <selvedge/core/solver/detail/link_integrator.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace selvedge {
namespace {

class ImplicitDesbrun final : public detail::LinkIntegrator {
 public:
  ImplicitDesbrun(ForceList forces, std::size_t n, bool corrected)
      : LinkIntegrator(std::move(forces), n, corrected),
        right_(static_cast<Eigen::Index>(n), 3),
        sorted_(right_) {}

  IntegratorTraits traits() const override {
    return {
        .promise = corrected_
                       ? "stable at any step; constant matrix, factored once; keeps the angular "
                         "momentum of what nothing holds"
                       : "stable at any step; constant matrix, factored once; brakes rotation",
        .source = "Desbrun, Schröder, Barr, Graphics Interface 1999; survey eq. 35",
        .any_step = true,
        .ends_with_mean = true};
  }

  void begin(const StepStart& start, StepEnd end) override;

 private:
  void factor(const Particles& particles, double h);
  void solve_all(std::span<Vec3> v);
  std::span<const double> restore_history(std::span<const double> memory) override {
    factored_h_ = 0.0;
    return LinkIntegrator::restore_history(memory);
  }

  std::vector<char> free_;   // particles that were free at the factorisation
  double factored_h_ = 0.0;  // s; 0: not factored yet
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> matrix_;
  Eigen::MatrixXd right_, sorted_;  // n x 3
};

void ImplicitDesbrun::factor(const Particles& p, double h) {
  const auto same = [&] {
    if (factored_h_ != h || free_.size() != p.size()) return false;
    for (std::size_t i = 0; i < p.size(); ++i)
      if ((p.inv_mass[i] > 0.0) != (free_[i] != 0)) return false;
    return true;
  };
  if (same()) return;
  free_.resize(p.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < p.size(); ++i) {
    free_[i] = p.inv_mass[i] > 0.0;
    entries.emplace_back(i, i, p.mass[i]);
  }
  const auto links = links_.links();
  for (std::size_t l = 0; l < links.size(); ++l) {
    const auto [i, j] = links[l];
    const double w = weight(l, h);
    // The row of a held particle fixes its velocity.
    if (free_[i]) entries.emplace_back(i, i, w);
    if (free_[j]) entries.emplace_back(j, j, w);
    if (!free_[i] || !free_[j]) continue;
    entries.emplace_back(i, j, -w);
    entries.emplace_back(j, i, -w);
  }
  const auto n = static_cast<Eigen::Index>(p.size());
  Eigen::SparseMatrix<double> a(n, n);
  a.setFromTriplets(entries.begin(), entries.end());
  matrix_.compute(a);
  factored_h_ = h;
}

void ImplicitDesbrun::solve_all(std::span<Vec3> v) {
  for (std::size_t i = 0; i < v.size(); ++i) right_.row(static_cast<Eigen::Index>(i)) = rhs_[i];
  sorted_.noalias() = matrix_.permutationP() * right_;
  matrix_.matrixL().solveInPlace(sorted_);
  matrix_.matrixU().solveInPlace(sorted_);
  right_.noalias() = matrix_.permutationPinv() * sorted_;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (free_[i]) v[i] = right_.row(static_cast<Eigen::Index>(i));
}

// (M + h² K + h D) v⁺ = M v + h F(x, v) + h D v, K and D Laplacians of the links.
void ImplicitDesbrun::begin(const StepStart& start, StepEnd end) {
  const Particles& p = start.particles;
  const double h = start.h;
  links_.fix({p.x, p.v, p.mass, start.time});
  factor(p, h);
  forces_.evaluate({p.x, p.v, p.mass, start.time}, f_);
  for (std::size_t i = 0; i < p.size(); ++i) rhs_[i] = p.mass[i] * p.v[i] + h * f_[i];
  links_.add_laplacian(0.0, h, p.v, rhs_);
  const auto links = links_.links();
  for (std::size_t l = 0; l < links.size(); ++l) {
    const auto [i, j] = links[l];
    const double w = weight(l, h);
    if (free_[i] && !free_[j]) rhs_[i] += w * end.mean[j];
    if (free_[j] && !free_[i]) rhs_[j] += w * end.mean[i];
  }
  solve_all(end.mean);
  if (corrected_) rigid_.apply(p, f_, h, false, end.mean);
}

}  // namespace

void register_implicit_desbrun(IntegratorRegistry& registry) {
  detail::add_link_integrator<ImplicitDesbrun>(registry, "implicit_desbrun",
                                               "implicit_desbrun_uncorrected");
}

}  // namespace selvedge
