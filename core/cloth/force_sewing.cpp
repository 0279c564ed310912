// SPDX-License-Identifier: MIT
//
// Sewing force after Y. Zhong, B. Xu, "Three-dimensional garment dressing simulation", Textile
// Research Journal 2009. It pulls the particles i and j of a seam together [survey eq. 10]: ε X_ij
// - C_air V_i + ΔA_a beyond δ, c X_ij/|X_ij| within δ. The printed equation has these faults: X_ij
// is once a vector and once its length; the second branch is 0/0 when the seam is closed and makes
// the particles oscillate before; C_air V_i slows a garment that moves as a whole (air is the law
// "air"); ΔA_a is an acceleration among forces, so a mass is missing. Here
//   F_i = T(d) X_ij/d + damping·(V_j - V_i along X_ij),  F_j = -F_i,  d = |X_ij|,
// with T = ε d + m ΔA beyond δ and c = ε δ + m ΔA within (T is continuous), decreasing linearly to
// 0 over the last `kClosingShare` of δ. m = m_i m_j/(m_i + m_j), so ΔA is the acceleration with
// which the two approach each other, whatever their masses, and the pair keeps its momentum. So the
// force has an energy, and a closed seam is at rest. Particles that have met become one vertex: see
// SeamMerging (simulation/internal/seam_merging.h).
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

namespace selvedge {
namespace {

/// Fraction of δ over which the pull decreases to 0; small, so seams close to a hundredth of δ.
constexpr double kClosingShare = 0.01;

class Seams {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "seam";

  Seams(std::span<const Edge> seams, const SewingConfig& config, std::span<const double> mass)
      : config_(config), seams_(seams.begin(), seams.end()), push_(seams.size(), 0.0) {
    detail::require_number("pull", config.pull, false);
    detail::require_number("tolerance", config.tolerance, false);
    detail::require_number("damping", config.damping);
    detail::require_number("acceleration", config.acceleration);
    for (std::size_t e = 0; config.acceleration > 0.0 && e < seams.size(); ++e)
      push_[e] = reduced_mass(e, mass) * config.acceleration;
  }

  std::size_t size() const { return seams_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return seams_[e][k]; }
  void reorder(std::span<const std::int32_t> order) {
    detail::reorder(seams_, order);
    detail::reorder(push_, order);
  }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    return detail::sample_link(x[seams_[e][0]], x[seams_[e][1]], config_.damping,
                               [&](double d) { return tension(d, push_[e]); });
  }

 private:
  double reduced_mass(std::size_t e, std::span<const double> mass) const {
    for (int k = 0; k < 2; ++k) detail::require_particle(name, e, seams_[e][k], mass.size());
    const double a = mass[seams_[e][0]], b = mass[seams_[e][1]];
    return a * b / (a + b);
  }

  detail::Tension tension(double d, double push) const {
    const double far = config_.tolerance, near = kClosingShare * far, c = config_.pull * far + push;
    if (d <= near) return {0.5 * c * d * d / near, c * d / near, c / near};
    if (d <= far) return {c * (d - 0.5 * near), c, 0.0};
    return {c * (far - 0.5 * near) + push * (d - far) + 0.5 * config_.pull * (d * d - far * far),
            config_.pull * d + push, config_.pull};
  }

  SewingConfig config_;
  std::vector<Edge> seams_;
  std::vector<double> push_;  // N, m ΔA of each
};

}  // namespace

std::unique_ptr<Force> make_sewing_force(std::span<const Edge> seams, const SewingConfig& config,
                                         std::size_t particles, std::span<const double> mass) {
  return std::make_unique<detail::ElementForce<Seams>>(Seams(seams, config, mass), particles);
}

void register_sewing(FabricLaws& laws) {
  laws.forces.add_keyed(
      "sewing", "seams",
      {.promise = "minus the gradient of its energy; survey eq. 10 corrected",
       .source = "Zhong, Xu, Three-dimensional garment dressing simulation, 2009"});
}

}  // namespace selvedge
