// SPDX-License-Identifier: MIT
//
// Springs that do not follow Hooke's law, with stiffness k at rest and strain ε = (L - L0)/L0:
// - tension_only: k (L - L0) under tension, 0 under compression [ChoiKo2002, type 1];
// - biphasic (Y. Chen et al. 1998, survey section 4): k up to the strain ε*, and above it
//   k (1 + β (ε - ε*)). In the survey the stiffness multiplies the whole elongation, so the force
//   k ΔL (1 + β (ε - ε*)) is continuous, and its slope jumps by k β ε* at ε*;
// - kawabata: the tension curve of KES-F1 from its linearity LT and extension EMT. A cubic
//   f = F (α s + (1-α) s³), s = ε/EMT, has LT = ∫f ds/(½F) = (1 + α)/2, so α = 2 LT - 1, and its
//   slope at rest is F α/EMT; the spring's stiffness gives the slope at rest. Beyond EMT the curve
//   continues straight with its slope at EMT; under compression with its slope at rest.
//
// With a resilience R = RT/100 below 1 the tension test has a loop. From the largest strain ε_m
// since the spring was last slack, the force returns along
//   f_u(ε) = f(ε) (W(ε)/W(ε_m))^(1/R - 1),  W(ε) = ∫ f from 0 to ε.
// Its work from ε_m to 0 is R W(ε_m) for any f, so RT is the same for a loop of any height. f_u
// meets f at ε_m, increases everywhere, and is 0 with slope 0 where the spring is slack. Below ε_m
// the spring follows f_u in both directions without loss; beyond ε_m it follows f and ε_m
// increases. ε_m changes only when a step is accepted. The energy, R W(ε_m) (W(ε)/W(ε_m))^(1/R)
// below ε_m, then decreases by (1 - R) times the work done beyond the old ε_m, so energy can only
// be lost. Kawabata gives RT but not the shape of the unloading curve; this one needs no further
// constant.
//
// - measured: the curve of the test itself as a monotone piecewise cubic (measured_curve.cpp), in
//   place of the polynomials that Zhong and Wang 1998, Ji et al. 2006 and Zhang et al. 2012 fit,
//   which may fall between the points. Under compression it continues with its slope at rest.
// (The rows of the survey's table III are shifted by one.)
//
// A yarn of a triangle (force_yarn.cpp) follows the same laws, as a spring of rest length 1: its
// length is that of a column of the deformation gradient.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/element_force.h>
#include <selvedge/core/cloth/detail/yarn_triangle.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <stdexcept>
#include <variant>

namespace selvedge {
namespace {

using detail::Tension;

struct Hooke {
  Tension operator()(double k, double l0, double length) const {
    const double d = length - l0;
    return {0.5 * k * d * d, k * d, k};
  }
};

struct TensionOnly {
  Tension operator()(double k, double l0, double length) const {
    const double d = length - l0;
    return d > 0.0 ? Tension{0.5 * k * d * d, k * d, k} : Tension{0.0, 0.0, 0.0};
  }
};

struct Biphasic {
  double strain, growth;
  Tension operator()(double k, double l0, double length) const {
    const double d = length - l0, over = d / l0 - strain;
    if (over <= 0.0) return {0.5 * k * d * d, k * d, k};
    // ∫ β (ε - ε*) k ΔL dL from ε*: with y = ε - ε*, β k l0² (y³/3 + ε* y²/2)
    const double extra = growth * k * l0 * l0 * over * over * (over / 3.0 + 0.5 * strain);
    return {0.5 * k * d * d + extra, k * d * (1.0 + growth * over),
            k * (1.0 + growth * (over + d / l0))};
  }
};

struct KawabataTension {
  double lt, emt;
  Tension operator()(double k, double l0, double length) const {
    // In units of the slope at rest: f = k L0 EMT (s + γ s³), γ = (1-α)/α.
    const double alpha = 2.0 * lt - 1.0, gamma = (1.0 - alpha) / alpha;
    const double scale = k * l0 * emt, s = (length / l0 - 1.0) / emt;
    const double energy_scale = scale * emt * l0, slope_scale = k;
    if (s <= 0.0) return {0.5 * energy_scale * s * s, scale * s, slope_scale};
    if (s <= 1.0)
      return {energy_scale * s * s * (0.5 + 0.25 * gamma * s * s),
              scale * s * (1.0 + gamma * s * s), slope_scale * (1.0 + 3.0 * gamma * s * s)};
    const double end = 1.0 + gamma, slope = 1.0 + 3.0 * gamma, beyond = s - 1.0;
    return {energy_scale * (0.5 + 0.25 * gamma + beyond * (end + 0.5 * slope * beyond)),
            scale * (end + slope * beyond), slope_scale * slope};
  }
};

struct MeasuredTension {
  MonotoneCurve curve;
  Tension operator()(double k, double l0, double length) const {
    const double d = length - l0;
    if (d <= 0.0) return {0.5 * k * d * d, k * d, k};
    const double scale = k * l0 / curve.slope_at_rest(), strain = d / l0;
    return {scale * l0 * curve.work(strain), scale * curve.value(strain),
            scale / l0 * curve.slope(strain)};
  }
};

/// Energy, tension and slope of a spring of stiffness k and rest length l0 at a length. A value,
/// not a template parameter, because a template would compile each force below once for each law.
struct Law {
  std::variant<Hooke, TensionOnly, Biphasic, KawabataTension, MeasuredTension> kind;
  Tension operator()(double k, double l0, double length) const {
    return std::visit([&](const auto& law) { return law(k, l0, length); }, kind);
  }
};

class CurveSprings {
 public:
  static constexpr int arity = 2;
  static constexpr const char* name = "spring";

  CurveSprings(std::span<const Spring> springs, Law law)
      : law_(std::move(law)), springs_(springs.begin(), springs.end()) {
    for (std::size_t i = 0; i < springs.size(); ++i) {
      detail::require_number_of("rest_length", name, i, springs[i].rest_length, false);
      detail::require_number_of("stiffness", name, i, springs[i].stiffness, false);
      detail::require_number_of("damping", name, i, springs[i].damping);
    }
  }

  std::size_t size() const { return springs_.size(); }
  std::int32_t particle(std::size_t e, int k) const {
    return k == 0 ? springs_[e].a : springs_[e].b;
  }
  double rest_length(std::size_t e) const { return springs_[e].rest_length; }
  Tension tension(std::size_t e, double length) const {
    return law_(springs_[e].stiffness, springs_[e].rest_length, length);
  }
  double length(std::size_t e, std::span<const Vec3> x) const {
    return (x[springs_[e].b] - x[springs_[e].a]).norm();
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(springs_, order); }

  detail::ElementSample<2> sample(std::size_t e, std::span<const Vec3> x) const {
    return sample_with(e, x, [&](double length) { return tension(e, length); });
  }
  /// The sample with another tension.
  detail::ElementSample<2> sample_with(std::size_t e, std::span<const Vec3> x,
                                       const auto& at) const {
    const Spring& s = springs_[e];
    return detail::sample_link(x[s.a], x[s.b], s.stiffness * s.damping, at);
  }

 private:
  Law law_;
  std::vector<Spring> springs_;
};

/// Yarns of one direction in triangles, as springs of rest length 1.
class CurveYarns {
 public:
  static constexpr int arity = 3;
  static constexpr const char* name = "yarn triangle";

  /// The yarns along `direction` (0: warp, 1: weft) that follow `curve`.
  CurveYarns(std::span<const YarnTriangle> triangles, std::int32_t curve, int direction, Law law)
      : law_(std::move(law)) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const YarnTriangle& t = triangles[i];
      if (t.curve[direction] != curve) continue;
      const double stiffness = direction == 0 ? t.warp : t.weft;
      detail::require_number_of(direction == 0 ? "warp" : "weft", name, i, stiffness, false);
      detail::require_number_of("damping", name, i, t.damping);
      const detail::YarnFrame f = detail::frame_of(t, i);
      yarns_.push_back({t.v, direction == 0 ? f.warp : f.weft, stiffness * f.area, t.damping});
    }
  }

  std::size_t size() const { return yarns_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return yarns_[e].v[k]; }
  double rest_length(std::size_t) const { return 1.0; }
  Tension tension(std::size_t e, double length) const {
    return law_(yarns_[e].stiffness, 1.0, length);
  }
  double length(std::size_t e, std::span<const Vec3> x) const {
    return detail::column_of(yarns_[e].v, yarns_[e].weight, x).norm();
  }
  void reorder(std::span<const std::int32_t> order) { detail::reorder(yarns_, order); }

  detail::ElementSample<3> sample(std::size_t e, std::span<const Vec3> x) const {
    return sample_with(e, x, [&](double length) { return tension(e, length); });
  }
  detail::ElementSample<3> sample_with(std::size_t e, std::span<const Vec3> x,
                                       const auto& at) const {
    const Yarn& yarn = yarns_[e];
    const Vec3 column = detail::column_of(yarn.v, yarn.weight, x);
    const detail::ElementSample<2> link =
        detail::sample_link(Vec3::Zero(), column, yarn.stiffness * yarn.damping, at);
    detail::ElementSample<3> s;
    s.valid = link.valid;
    s.energy = link.energy;
    if (!s.valid) return s;
    s.moment = link.moment;
    s.slope = link.slope;
    s.damping = link.damping;
    for (int k = 0; k < 3; ++k) s.gradient[k] = yarn.weight[k] * link.gradient[1];
    s.across = link.across;
    s.bound = link.bound;
    s.weight = yarn.weight;
    s.plane = link.plane;
    return s;
  }

 private:
  struct Yarn {
    std::array<std::int32_t, 3> v;
    std::array<double, 3> weight;  // 1/m
    double stiffness;              // N·m: per strain, with the area
    double damping;                // s
  };
  Law law_;
  std::vector<Yarn> yarns_;
};

/// A spring counts as slack at this fraction of its largest elongation, because lengths are
/// rounded. On the loading curve the remaining work is the square of this fraction: below rounding.
constexpr double kSlack = 1e-8;

/// Springs (or yarns) that unload along another curve.
template <class Springs>
class Resilient {
 public:
  static constexpr int arity = Springs::arity;
  static constexpr const char* name = Springs::name;

  Resilient(Springs springs, double resilience)
      : springs_(std::move(springs)), resilience_(resilience), longest_(springs_.size()) {
    for (std::size_t e = 0; e < size(); ++e) longest_[e] = springs_.rest_length(e);
  }

  std::size_t size() const { return springs_.size(); }
  std::int32_t particle(std::size_t e, int k) const { return springs_.particle(e, k); }
  void reorder(std::span<const std::int32_t> order) {
    springs_.reorder(order);
    detail::reorder(longest_, order);
  }

  detail::ElementSample<arity> sample(std::size_t e, std::span<const Vec3> x) const {
    const double rest_length = springs_.rest_length(e);
    return springs_.sample_with(e, x, [&](double length) {
      const Tension load = springs_.tension(e, length);
      if (!(load.energy > 0.0) || length <= rest_length) return load;
      const Tension top = springs_.tension(e, longest_[e]);
      if (length >= longest_[e])
        return Tension{load.energy - (1.0 - resilience_) * top.energy, load.force, load.slope};
      const double more = 1.0 / resilience_ - 1.0,
                   share = elementary::pow(load.energy / top.energy, more);
      // The limit of f²/W where the spring becomes slack is finite: 2 k.
      const double steeper = more * load.force * (load.force / load.energy);
      return Tension{resilience_ * load.energy * share, load.force * share,
                     share * (load.slope + steeper)};
    });
  }

  void stretch(std::span<const Vec3> x) {
    for (std::size_t e = 0; e < size(); ++e) {
      const double rest_length = springs_.rest_length(e), length = springs_.length(e, x);
      const double slack = rest_length + kSlack * (longest_[e] - rest_length);
      longest_[e] = length <= slack ? rest_length : std::max(longest_[e], length);
    }
  }

  void save(std::vector<double>& memory) const {
    memory.insert(memory.end(), longest_.begin(), longest_.end());
  }

  std::span<const double> restore(std::span<const double> memory) {
    detail::require_memory("resilient spring", memory.size(), size());
    std::copy_n(memory.begin(), size(), longest_.begin());
    return memory.subspan(size());
  }

 private:
  Springs springs_;
  double resilience_;
  std::vector<double> longest_;  // m, largest length since the spring was last slack
};

template <class Springs>
class ResilientForce final : public detail::ElementForce<Resilient<Springs>> {
 public:
  using detail::ElementForce<Resilient<Springs>>::ElementForce;
  void accept(const ForceState& state) override { this->kind_.stretch(state.x); }
  void save_memory(std::vector<double>& memory) const override { this->kind_.save(memory); }
  std::span<const double> restore_memory(std::span<const double> memory) override {
    return this->kind_.restore(memory);
  }
};

/// The force of springs or yarns, with a loop if the resilience is below 1.
template <class Springs>
std::unique_ptr<Force> make(Springs springs, double resilience, std::size_t particles) {
  if (resilience >= 1.0)
    return std::make_unique<detail::ElementForce<Springs>>(std::move(springs), particles);
  return std::make_unique<ResilientForce<Springs>>(Resilient(std::move(springs), resilience),
                                                   particles);
}

void check_resilience(const SpringCurve& curve) {
  detail::require_number("kawabata_rt", curve.resilience, false);
  detail::require_number("1 less kawabata_rt", 1.0 - curve.resilience);
}

/// A checked law and the resilience of its loop (1: no loop).
struct LawOfCurve {
  Law law;
  double resilience = 1.0;
};

LawOfCurve tension_only(const SpringCurve&) { return {.law = {TensionOnly{}}}; }

LawOfCurve biphasic(const SpringCurve& curve) {
  detail::require_number("biphasic_strain", curve.strain);
  detail::require_number("biphasic_growth", curve.shape);
  return {.law = {Biphasic{curve.strain, curve.shape}}};
}

LawOfCurve kawabata(const SpringCurve& curve) {
  detail::require_number("kawabata_strain", curve.strain, false);
  // Below 1/2 the cubic has a decreasing part.
  detail::require_number("kawabata_lt above 0.5", curve.shape - 0.5, false);
  detail::require_number("1 less kawabata_lt", 1.0 - curve.shape);
  check_resilience(curve);
  return {.law = {KawabataTension{curve.shape, curve.strain}}, .resilience = curve.resilience};
}

LawOfCurve measured(const SpringCurve& curve) {
  if (curve.measured.empty()) throw std::invalid_argument("a measured law has no curve");
  check_resilience(curve);
  return {.law = {MeasuredTension{curve.measured}}, .resilience = curve.resilience};
}

/// A stretch law of springs, and the force of its curve.
struct CurveLaw {
  StretchLaw law;
  LawOfCurve (*make)(const SpringCurve&);
  const char *promise, *source;
};

std::vector<CurveLaw> curve_laws() {
  constexpr const char* gradient = "minus the gradient of its energy";
  return {
      {.law = {.name = "tension_only",
               .text = "nothing under compression",
               .curve = [](const Material&) { return SpringCurve{.law = "tension_only"}; }},
       .make = tension_only,
       .promise = gradient,
       .source = "Choi, Ko, Stable but responsive cloth, 2002"},
      {.law = {.name = "biphasic",
               .text = "stiffer above a strain",
               .curve =
                   [](const Material& m) {
                     return SpringCurve{.law = "biphasic",
                                        .strain = constant_of_law(m, "biphasic_strain"),
                                        .shape = constant_of_law(m, "biphasic_growth")};
                   }},
       .make = biphasic,
       .promise = gradient,
       .source = "Chen, Zhu, Kaufman, Physically based animation, 1998"},
      {.law = {.name = "kawabata",
               .text = "the curve of a tension test by its figures",
               .curve =
                   [](const Material& m) {
                     return SpringCurve{.law = "kawabata",
                                        .strain = m.kawabata_strain,
                                        .shape = m.kawabata_lt,
                                        .resilience = m.kawabata_rt};
                   }},
       .make = kawabata,
       .promise = "tension curve of KES-F1 by LT and EMT; minus the gradient of its energy",
       .source = "Zhong, Wang, 1998; Ji et al., 2006; Zhang et al., 2012"},
      {.law = {.name = "measured",
               .text = "that curve itself, tension_curve",
               .curve =
                   [](const Material& m) {
                     return SpringCurve{.law = "measured",
                                        .resilience = m.kawabata_rt,
                                        .measured = m.tension_curve};
                   },
               .reads = {"tension_curve"}},
       .make = measured,
       .promise = "measured curves of warp and weft, monotone; minus the gradient of its energy",
       .source =
           "Fritsch, Carlson, Monotone piecewise cubic interpolation, 1980; Zhong, Wang, 1998"}};
}

LawOfCurve law_of(const SpringCurve& curve) {
  if (curve.law == "hooke") return {.law = {Hooke{}}};
  for (const CurveLaw& known : curve_laws())
    if (known.law.name == curve.law) return known.make(curve);
  throw std::invalid_argument("springs cannot follow the law \"" + curve.law + "\"");
}

}  // namespace

std::unique_ptr<Force> make_curve_force(std::span<const Spring> springs, const SpringCurve& curve,
                                        std::size_t particles) {
  if (curve.law == "hooke") return make_hooke_force(springs, particles);
  const auto [law, resilience] = law_of(curve);
  return make(CurveSprings(springs, law), resilience, particles);
}

ForceList make_yarn_stretch(std::span<const YarnTriangle> triangles,
                            std::span<const SpringCurve> curves, std::size_t particles) {
  ForceList forces;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (const std::int32_t curve : triangles[i].curve)
      detail::require_curve("yarn triangle", i, curve, curves, false);
  for (std::size_t c = 0; c < curves.size(); ++c)
    for (const int direction : {0, 1}) {
      const auto curve = static_cast<std::int32_t>(c);
      if (std::none_of(triangles.begin(), triangles.end(),
                       [&](const YarnTriangle& t) { return t.curve[direction] == curve; }))
        continue;
      const auto [law, resilience] = law_of(curves[c]);
      forces.push_back(make(CurveYarns(triangles, curve, direction, law), resilience, particles));
    }
  return forces;
}

namespace {

ForceList forces_of_law(const ClothMesh& cloth, const std::string& law) {
  ForceList forces;
  for (std::size_t c = 0; c < cloth.curves.size(); ++c)
    if (cloth.curves[c].law == law && !cloth.curves[c].idle)
      forces.push_back(make_curve_force(springs_of_curve(cloth, static_cast<std::int32_t>(c)),
                                        cloth.curves[c], cloth.mass.size()));
  return forces;
}

}  // namespace

void register_spring_curves(FabricLaws& laws) {
  laws.constants.push_back({"biphasic_strain",
                            0.02,
                            {.unit = "1",
                             .range = {0, 100},
                             .text = "Strain above which biphasic springs become stiffer"}});
  laws.constants.push_back(
      {"biphasic_growth",
       10.0,
       {.unit = "1",
        .range = {0, 1e6},
        .text = "Growth of the stiffness of biphasic springs per strain above that"}});
  for (const CurveLaw& known : curve_laws()) {
    laws.stretch.push_back(known.law);
    laws.forces.add(
        known.law.name, {},
        [name = known.law.name](const MethodOptions&, const ClothMesh& cloth) {
          return forces_of_law(cloth, name);
        },
        {.promise = known.promise, .source = known.source, .energy = "stretch_and_shear"});
  }
}

}  // namespace selvedge
