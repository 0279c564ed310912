// SPDX-License-Identifier: MIT
//
// Buckling links after K.-J. Choi, H.-S. Ko, "Stable but responsive cloth", SIGGRAPH 2002. The
// survey prints them for A. ElBadrawy, E. Hemayed, "Speeding up cloth simulation by linearizing the
// bending function of the physical mass-spring model", 2011 [ElBadrawyHemayed2011] ("Asmaa and
// Elsayed"), but not the linear function that is the matter of that paper. When the ends of a link
// of length L and bending stiffness k approach each other, the link keeps its length and bends into
// an arc of curvature κ:
//   r = L sinc(κL/2),  E = ½ k κ² L,  dE/dr = k κ² (cos(κL/2) - sinc(κL/2))⁻¹ < 0.
// [survey eq. 5] prints "k_b k_2" for k_b κ² and "sin c" for sinc(u) = sin(u)/u, and does not say
// that x_ij is the vector and |x_ij| the distance r. The force here is the exact gradient of E.
//
// At r = L the force jumps to -12 k/L² (Euler's load is π² k/L², 21.6 % less, because the arc is
// not the buckled shape). The paper bridges the jump by c_b (r - L) where that force is the weaker
// one, so the force is continuous; the energy here belongs to that force. Under tension a link is
// slack.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/grid_bending.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <numbers>

namespace selvedge {
namespace {

/// sinc(u) and cos(u) - sinc(u) without cancellation near 0.
struct Arc {
  double sinc, difference;
};

Arc arc(double u) {
  // Below this the series is exact to rounding: the next term is u⁸/40320 < 1e-16.
  constexpr double small = 0.03;
  const double u2 = u * u;
  if (u < small)
    return {1.0 - u2 / 6.0 * (1.0 - u2 / 20.0 * (1.0 - u2 / 42.0)),
            -u2 / 3.0 * (1.0 - u2 / 10.0 * (1.0 - u2 / 28.0))};
  const double sinc = elementary::sin(u) / u;
  return {sinc, elementary::cos(u) - sinc};
}

/// The u in [0, π] with 1 - sinc(u) = gap, by Newton's method started from the series and
/// safeguarded by bisection (1 - sinc is increasing there).
double inverse_sinc(double gap) {
  if (gap <= 0.0) return 0.0;
  double low = 0.0, high = std::numbers::pi;
  double u = std::min(high, std::sqrt(6.0 * gap) * (1.0 + 0.15 * gap));
  constexpr int most = 60;
  for (int i = 0; i < most; ++i) {
    const Arc a = arc(u);
    constexpr double small = 0.03;
    const double u2 = u * u;
    const double error =
        (u < small ? u2 / 6.0 * (1.0 - u2 / 20.0 * (1.0 - u2 / 42.0)) : 1.0 - a.sinc) - gap;
    (error > 0.0 ? high : low) = u;
    // d(1 - sinc)/du = -(cos u - sinc u)/u
    double next = a.difference < 0.0 ? u + error * u / a.difference : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double moved = std::abs(next - u);
    u = next;
    constexpr double enough = 4e-16;
    if (moved <= enough * u) break;
  }
  return u;
}

/// Tension and energy of the bent link at length r = L - gap·L.
detail::Tension bent(const BucklingLink& link, double gap) {
  const double u = inverse_sinc(gap);
  const double length = link.rest_length, k = link.rigidity, kappa = 2.0 * u / length;
  // T = k κ²/(cos u - sinc u); at u = 0: -12 k/L², with dT/dr = 4.8·... from the series below.
  const double u2 = u * u;
  constexpr double small = 0.03;
  detail::Tension t{};
  t.energy = 0.5 * k * kappa * kappa * length;
  if (u < small) {
    // (cos u - sinc u) = -u²/3 (1 - u²/10 + u⁴/280): T = -12 k/L² (1 + u²/10 + 9u⁴/1400),
    // r = L (1 - u²/6 + u⁴/120), so dT/dr = 12 k/L³ · (1/5 + 9u²/350)/(1/3 - u²/30).
    t.force = -12.0 * k / (length * length) * (1.0 + u2 / 10.0 + 9.0 * u2 * u2 / 1400.0);
    t.slope =
        12.0 * k / (length * length * length) * (0.2 + 9.0 * u2 / 350.0) / (1.0 / 3.0 - u2 / 30.0);
    return t;
  }
  const double g = arc(u).difference;
  t.force = k * kappa * kappa / g;
  // dT/du / (dr/du), dr/du = L g/u, dg/du = -sin u - g/u
  const double dg = -elementary::sin(u) - g / u;
  const double dt_du = k * (4.0 * kappa / (length * g) - kappa * kappa * dg / (g * g));
  t.slope = dt_du * u / (length * g);
  return t;
}

/// A link and the point where its linear onset meets the bent branch.
struct Link {
  BucklingLink link;
  double onset_gap;     // (L - r)/L
  double energy_shift;  // J, onset minus bent energy there
};

Link with_onset(const BucklingLink& link) {
  // The onset is weaker at 0 and stronger at full compression, so bisection finds the only
  // crossing.
  double low = 0.0, high = 1.0;
  constexpr int halvings = 100;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    const bool onset = link.onset * middle * link.rest_length < -bent(link, middle).force;
    (onset ? low : high) = middle;
  }
  const double shortening = high * link.rest_length;
  return {link, high, 0.5 * link.onset * shortening * shortening - bent(link, high).energy};
}

class BucklingLinks {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "link";

  explicit BucklingLinks(std::span<const BucklingLink> links) {
    for (std::size_t i = 0; i < links.size(); ++i) {
      const BucklingLink& l = links[i];
      detail::require_number_of("rest_length", name, i, l.rest_length, false);
      detail::require_number_of("rigidity", name, i, l.rigidity, false);
      detail::require_number_of("damping", name, i, l.damping);
      // The bent branch ends at κ = 2π/L with 4π² k/L²; a smaller onset might not cross it.
      const double length = l.rest_length;
      detail::require_number_of("onset above 4 pi^2 rigidity/rest_length^3", name, i,
                                l.onset - 4.0 * std::numbers::pi * std::numbers::pi * l.rigidity /
                                              (length * length * length),
                                false);
      links_.push_back(with_onset(l));
    }
  }

  std::size_t size() const { return links_.size(); }
  std::int32_t particle(std::size_t e, int k) const {
    return k == 0 ? links_[e].link.a : links_[e].link.b;
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(links_, order); }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    const Link& l = links_[e];
    const double length = l.link.rest_length;
    const double damping = l.link.damping * 12.0 * l.link.rigidity / (length * length * length);
    return detail::sample_link(x[l.link.a], x[l.link.b], damping,
                               [&](double r) { return tension(l, r); });
  }

 private:
  static detail::Tension tension(const Link& l, double r) {
    const double shortening = l.link.rest_length - r;
    if (shortening <= 0.0) return {0.0, 0.0, 0.0};
    const double gap = shortening / l.link.rest_length;
    if (gap < l.onset_gap)
      return {0.5 * l.link.onset * shortening * shortening, -l.link.onset * shortening,
              l.link.onset};
    detail::Tension t = bent(l.link, gap);
    t.energy += l.energy_shift;
    return t;
  }

  std::vector<Link> links_;
};

}  // namespace

std::unique_ptr<Force> make_buckling_force(std::span<const BucklingLink> links,
                                           std::size_t particles) {
  return std::make_unique<detail::ElementForce<BucklingLinks>>(BucklingLinks(links), particles);
}

namespace {

// A link over two cells bends to an arc of length 2d and stores ½ k κ² 2d: k = (share·area)/(2d).
// Before it buckles it is as stiff as a strip of cloth of its width.
void add_links(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  detail::for_each_line(grid, m, [&](const detail::GridLine& line) {
    const double length = 2.0 * line.spacing;
    const double rigidity = line.rigidity_area / length;
    const double width = line.rigidity_area / (m.bending_stiffness * line.spacing);
    const double onset =
        std::max(detail::least_onset(rigidity, length), m.stretch_stiffness * width / length);
    cloth.links.push_back({line.before, line.after, length, rigidity, onset, m.bending_damping});
  });
}

}  // namespace

double detail::least_onset(double rigidity, double length) {
  // The onset must be steeper than any later slope, with a safety factor; see
  // make_buckling_force.
  constexpr double kSteeper = 2.0 * 4.0 * std::numbers::pi * std::numbers::pi;
  return kSteeper * rigidity / (length * length * length);
}

void register_buckling(FabricLaws& laws) {
  laws.bending.push_back(
      {.name = "buckling", .text = "links that buckle", .add_to_grid = add_links});
  laws.forces.add(
      "buckling", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        if (!cloth.links.empty())
          forces.push_back(make_buckling_force(cloth.links, cloth.mass.size()));
        return forces;
      },
      {.promise = "minus the gradient of its energy; survey eq. 5 corrected",
       .source = "Choi, Ko, Stable but responsive cloth, 2002; in the survey Asmaa, Elsayed "
                 "2011",
       .energy = "buckling"});
}

}  // namespace selvedge
