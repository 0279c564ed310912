// SPDX-License-Identifier: MIT
//
// The bending spring of R. Zhang, H. Wang, L. Ma, N. Meng, "Modeling and simulation process for
// fabric and skirt based on KES testing", ICCSE 2012: the moment M of Kawabata's bending test is
// transformed into the force F of a spring, and the curvature κ into the distance of its ends
// (survey 3.1.2, which prints no equation). Derived here: a strip of width w bends at the particle
// between two cells of length d. Its cells turn by θ = κ d, so that its ends are
//   r = 2d cos(θ/2)
// apart, and the chord passes the particle at the distance d sin(θ/2). A force along the chord
// with the moment M w about the particle is
//   F = M(κ) w/(d sin(θ/2)).
// Its work F dr is M w dθ, so the energy is w d Ψ(κ), the exact integral of the curve.
//
// As κ -> 0, F -> 2 B w/d²: a straight strip bears a finite load before it bends. As in
// force_buckling.cpp, a linear onset bridges this jump: c (2d - r) while that is the weaker force.
// Under tension a link is slack.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/chord_link.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/grid_mesh.h>
#include <selvedge/core/cloth/detail/law_elements.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <numbers>

namespace selvedge {
namespace {

/// A link with its curve, and where its onset meets the bent strip.
struct Chord {
  detail::ChordLink link;
  MonotoneCurve curve;  // empty: linear
  double onset_gap;     // (2d - r)/(2d)
  double energy_shift;  // J, onset minus bent energy there
};

/// The moment at a curvature: Ψ, M and M', for the strip of width 1.
detail::Tension strip(const Chord& chord, double kappa) {
  const double b = chord.link.rigidity;
  if (chord.curve.empty()) return {0.5 * b * kappa * kappa, b * kappa, b};
  const double scale = b / chord.curve.slope_at_rest();
  return {scale * chord.curve.work(kappa), scale * chord.curve.value(kappa),
          scale * chord.curve.slope(kappa)};
}

/// The bent strip at r = 2d (1 - gap), gap > 0.
detail::Tension bent_strip(const Chord& chord, double gap) {
  const double d = chord.link.spacing, w = chord.link.width;
  // 1 - cos(θ/2) = 2 sin²(θ/4)
  const double quarter = elementary::asin(std::sqrt(0.5 * gap)), half = 2.0 * quarter;
  const double sine = elementary::sin(half), cosine = elementary::cos(half);
  const detail::Tension m = strip(chord, 2.0 * half / d);
  detail::Tension t{};
  t.energy = w * d * m.energy;
  t.force = -w * m.force / (d * sine);
  // dθ/dr = -1/(d sin(θ/2))
  t.slope = w / (d * d * sine * sine) * (m.slope / d - 0.5 * m.force * cosine / sine);
  return t;
}

class ChordLinks {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "chord";

  ChordLinks(std::span<const detail::ChordLink> links, std::span<const SpringCurve> curves) {
    for (std::size_t i = 0; i < links.size(); ++i) {
      const detail::ChordLink& l = links[i];
      detail::require_number_of("spacing", name, i, l.spacing, false);
      detail::require_number_of("width", name, i, l.width, false);
      detail::require_number_of("rigidity", name, i, l.rigidity, false);
      detail::require_number_of("damping", name, i, l.damping);
      if (l.curve >= 0) detail::require_curve(name, i, l.curve, curves);
      chords_.push_back({l, l.curve >= 0 ? curves[l.curve].measured : MonotoneCurve{}, 0.0, 0.0});
      set_onset(i);
    }
  }

  std::size_t size() const { return chords_.size(); }
  std::int32_t particle(std::size_t e, int k) const {
    return k == 0 ? chords_[e].link.a : chords_[e].link.b;
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(chords_, order); }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    const detail::ChordLink& l = chords_[e].link;
    const double stiffness = l.rigidity * l.width / (l.spacing * l.spacing * l.spacing);
    return detail::sample_link(x[l.a], x[l.b], l.damping * stiffness,
                               [&](double r) { return tension(chords_[e], r); });
  }

 private:
  /// The onset is weaker at 0 and must be stronger at full compression; bisection finds a crossing.
  void set_onset(std::size_t i) {
    Chord& chord = chords_[i];
    const double length = 2.0 * chord.link.spacing;
    detail::require_number_of("onset above the force of the folded strip", name, i,
                              chord.link.onset * length + bent_strip(chord, 1.0).force, false);
    double low = 0.0, high = 1.0;
    constexpr int halvings = 100;
    for (int k = 0; k < halvings; ++k) {
      const double middle = 0.5 * (low + high);
      const bool onset =
          middle > 0.0 && chord.link.onset * middle * length < -bent_strip(chord, middle).force;
      (onset ? low : high) = middle;
    }
    const double shortening = high * length;
    chord.onset_gap = high;
    chord.energy_shift =
        0.5 * chord.link.onset * shortening * shortening - bent_strip(chord, high).energy;
  }

  static detail::Tension tension(const Chord& chord, double r) {
    const double length = 2.0 * chord.link.spacing, shortening = length - r;
    if (shortening <= 0.0) return {0.0, 0.0, 0.0};
    const double onset = chord.link.onset;
    if (shortening < chord.onset_gap * length)
      return {0.5 * onset * shortening * shortening, -onset * shortening, onset};
    detail::Tension t = bent_strip(chord, shortening / length);
    t.energy += chord.energy_shift;
    return t;
  }

  std::vector<Chord> chords_;
};

}  // namespace

std::unique_ptr<Force> detail::make_chord_force(std::span<const detail::ChordLink> links,
                                                std::span<const SpringCurve> curves,
                                                std::size_t particles) {
  return std::make_unique<detail::ElementForce<ChordLinks>>(ChordLinks(links, curves), particles);
}

namespace {

// A link over two cells of a row stands for a strip of one cell, on the border of half a cell.
// Before it bends it is as stiff as that strip, and at least strong enough to bear it folded.
void add_chords(ClothMesh& cloth, const GridConfig& grid, const Material& m) {
  const detail::CellConstants c = detail::cell_sides(grid);
  const std::array<double, 2> rigidity{m.bending_stiffness, bending_along_weft(m)};
  const std::array<double, 2> stretch{m.stretch_stiffness, stretch_along_weft(m)};
  std::array<std::int32_t, 2> shapes{-1, -1};
  auto& links = detail::elements_of_law<detail::ChordLink>(cloth);
  if (!m.bending_curve.empty()) shapes = detail::add_bending_shapes(cloth, m);
  const auto add = [&](std::int32_t at, std::int32_t step, int direction, bool inner) {
    const double d = direction == 0 ? c.a : c.b;
    const double w = (direction == 0 ? c.b : c.a) * (inner ? 1.0 : 0.5);
    if (rigidity[direction] <= 0.0) return;
    double folded = rigidity[direction] * std::numbers::pi / d;  // N, M at θ = π
    if (shapes[direction] >= 0) {
      const MonotoneCurve& curve = cloth.curves[shapes[direction]].measured;
      folded = rigidity[direction] / curve.slope_at_rest() * curve.value(std::numbers::pi / d);
    }
    constexpr double steeper = 2.0;
    const double onset =
        std::max(steeper * folded * w / (2.0 * d * d), stretch[direction] * w / (2.0 * d));
    links.push_back({at - step, at + step, d, w, rigidity[direction], onset, m.bending_damping,
                     shapes[direction]});
  };
  const std::int32_t nx = grid.cells_x, ny = grid.cells_y, up = nx + 1;
  for (std::int32_t j = 0; j <= ny; ++j)
    for (std::int32_t i = 0; i <= nx; ++i) {
      const bool inner_x = i > 0 && i<nx, inner_y = j> 0 && j < ny;
      if (inner_x) add(j * up + i, 1, 0, inner_y);
      if (inner_y) add(j * up + i, up, 1, inner_x);
    }
}

}  // namespace

void register_chord(FabricLaws& laws) {
  laws.bending.push_back(
      {.name = "chord",
       .text = "the moment M(kappa) as a force over the distance of the ends of two cells",
       .reads = {"bending_curve"},
       .on_cut_cells = false,
       .add_to_grid = add_chords});
  laws.forces.add(
      "chord", {},
      [](const MethodOptions&, const ClothMesh& cloth) {
        ForceList forces;
        const auto links = detail::elements_of_law<detail::ChordLink>(cloth);
        if (!links.empty())
          forces.push_back(detail::make_chord_force(links, cloth.curves, cloth.mass.size()));
        return forces;
      },
      {.promise = "M(kappa) as a force over the distance of two cells' ends; minus the "
                  "gradient of its energy",
       .source = "Zhang, Wang, Ma, Meng, Fabric and skirt based on KES testing, 2012",
       .energy = "bending"});
}

}  // namespace selvedge
