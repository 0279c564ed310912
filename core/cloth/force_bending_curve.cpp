// SPDX-License-Identifier: MIT
//
// Bending by measured curves M(κ) of warp and weft [Kawabata1980]. The plate (hinges, or
// the shape operator on free meshes) bends with B = M'(0). This force adds, for the curvatures κ
// along warp and weft of each triangle (or of each hinge along a row or column of a grid),
//   E = A Σ [Ψ(κ) - ½ B κ²],  Ψ(κ) = ∫ M dκ,
// so that a cylinder along either direction stores A Ψ(κ). Twist remains that of the plate. The
// curvatures are linear in the angles of the hinges, as in detail/shape_operator.cpp.
//
// Jacobian: where a curve is softer than B, this force has a negative stiffness, which is dropped;
// the sum with the plate is then too stiff, never indefinite. A positive one is bounded by diagonal
// terms, as in force_curvature_friction.cpp.
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/dihedral.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace selvedge {
namespace {

constexpr std::size_t kBendingGrain = 512;
constexpr const char* kBendingName = "bending curve";

/// One direction of one element: A (M(κ) - B κ).
struct BendingDeviation {
  double area_rigidity = 0.0;  // N·m·m²
  const MonotoneCurve* curve = nullptr;

  double scale() const { return area_rigidity / curve->slope_at_rest(); }
  double energy(double kappa) const {
    return scale() * curve->work(kappa) - 0.5 * area_rigidity * kappa * kappa;
  }
  double moment(double kappa) const {
    return scale() * curve->value(kappa) - area_rigidity * kappa;
  }
  double slope(double kappa) const { return scale() * curve->slope(kappa) - area_rigidity; }
};

class BendingCurves final : public Force {
 public:
  explicit BendingCurves(const ClothMesh& cloth) : shapes_(cloth.curves) {
    std::vector<std::int32_t> place(cloth.hinges.size(), -1);
    set_hinges(cloth, place);
    begin_.push_back(0);
    for (std::size_t i = 0; i < cloth.curvature_curves.size(); ++i)
      add(cloth.curvature_curves[i], i, place);
    set_terms_of_hinges();
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const Bent bent = bend(state.x);
    const std::vector<double> moment = moments(bent);
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin; h < end; ++h)
        for (int k = 0; k < 4; ++k) f[hinges_[h].v[k]] -= moment[h] * bent.dihedral[h].gradient[k];
    });
  }

  double energy(const ForceState& state) const override {
    const Bent bent = bend(state.x);
    return parallel_sum(size(), kBendingGrain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t e = begin; e < end; ++e)
        for (const int i : {0, 1}) sum += law_[e][i].energy(bent.curvature[e][i]);
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const Hinge& hinge : hinges_)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j) links.push_back({hinge.v[i], hinge.v[j]});
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.assign(hinges_.size(), {});
    for (std::size_t h = 0; h < hinges_.size(); ++h)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          slots_[h][4 * i + j] = matrix.slot(hinges_[h].v[i], hinges_[h].v[j]);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    const Bent bent = bend(state.x);
    const std::vector<double> stiffness =
        stiffnesses(bent, [](double slope) { return std::max(0.0, slope); });
    const std::span<Mat3> values = a.values();
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n) {
        const auto& g = bent.dihedral[n].gradient;
        for (int i = 0; i < 4; ++i)
          for (int j = 0; j < 4; ++j)
            values[slots_[n][4 * i + j]] += (h * h * stiffness[n] * g[i]) * g[j].transpose();
      }
    });
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double>) const override {
    const Bent bent = bend(state.x);
    const std::vector<double> moment = moments(bent);
    const std::vector<double> slope = stiffnesses(bent, [](double s) { return std::abs(s); });
    for (std::size_t h = 0; h < hinges_.size(); ++h) {
      const auto& g = bent.dihedral[h].gradient;
      const double sum = g[0].norm() + g[1].norm() + g[2].norm() + g[3].norm();
      // The second derivative of the angle is at most about twice the product of the gradients.
      const double row = (slope[h] + 2.0 * std::abs(moment[h])) * sum;
      for (int k = 0; k < 4; ++k) stiffness[hinges_[h].v[k]] += row * g[k].norm();
    }
  }

 private:
  using Pair = std::array<double, 2>;  // along warp and weft
  struct Term {
    std::size_t other;  // the hinge of an element, or the element of a hinge
    Pair curvature;     // 1/m per radian
  };
  /// The hinges and the curvatures in one state.
  struct Bent {
    std::vector<detail::Dihedral> dihedral;
    std::vector<Pair> curvature;
  };

  std::size_t size() const { return law_.size(); }

  /// Takes the hinges that elements name, sorted by colour.
  void set_hinges(const ClothMesh& cloth, std::vector<std::int32_t>& place) {
    std::vector<std::int32_t> number, corners;
    for (std::size_t i = 0; i < cloth.curvature_curves.size(); ++i)
      for (const auto& term : cloth.curvature_curves[i].terms) {
        detail::require_particle(kBendingName, i, term.hinge, cloth.hinges.size());
        place[term.hinge] = 0;
      }
    for (std::size_t h = 0; h < place.size(); ++h) {
      if (place[h] < 0) continue;
      number.push_back(static_cast<std::int32_t>(h));
      corners.insert(corners.end(), cloth.hinges[h].v.begin(), cloth.hinges[h].v.end());
    }
    detail::Coloring coloring = detail::color_elements(corners, 4, cloth.mass.size());
    for (const std::int32_t k : coloring.order) {
      place[number[k]] = static_cast<std::int32_t>(hinges_.size());
      hinges_.push_back(cloth.hinges[number[k]]);
    }
    color_begin_ = std::move(coloring.color_begin);
  }

  void add(const CurvatureCurve& element, std::size_t i, const std::vector<std::int32_t>& place) {
    detail::require_number_of("area", kBendingName, i, element.area, false);
    std::array<BendingDeviation, 2> law;
    for (const int k : {0, 1}) {
      detail::require_curve(kBendingName, i, element.curve[k], shapes_);
      detail::require_number_of("rigidity", kBendingName, i, element.rigidity[k]);
      law[k] = {element.area * element.rigidity[k], &shapes_[element.curve[k]].measured};
    }
    law_.push_back(law);
    for (const auto& term : element.terms)
      terms_.push_back(
          {static_cast<std::size_t>(place[term.hinge]), {term.curvature[0], term.curvature[1]}});
    begin_.push_back(terms_.size());
  }

  void set_terms_of_hinges() {
    of_hinge_.assign(hinges_.size(), {});
    for (std::size_t e = 0; e < size(); ++e)
      for (std::size_t t = begin_[e]; t < begin_[e + 1]; ++t)
        of_hinge_[terms_[t].other].push_back({e, terms_[t].curvature});
  }

  Bent bend(std::span<const Vec3> x) const {
    Bent bent{std::vector<detail::Dihedral>(hinges_.size()), std::vector<Pair>(size(), Pair{})};
    parallel_for(hinges_.size(), kBendingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin; h < end; ++h) {
        detail::Dihedral& d = bent.dihedral[h];
        d = detail::dihedral(x, hinges_[h].v);
        d.angle -= hinges_[h].rest_angle;
        if (d.valid) continue;
        d.angle = 0.0;
        d.gradient.fill(Vec3::Zero());
      }
    });
    parallel_for(size(), kBendingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e)
        for (std::size_t t = begin_[e]; t < begin_[e + 1]; ++t)
          for (const int i : {0, 1})
            bent.curvature[e][i] += bent.dihedral[terms_[t].other].angle * terms_[t].curvature[i];
    });
    return bent;
  }

  std::vector<double> moments(const Bent& bent) const {
    std::vector<double> moment(hinges_.size(), 0.0);
    parallel_for(hinges_.size(), kBendingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin; h < end; ++h)
        for (const Term& term : of_hinge_[h])
          for (const int i : {0, 1})
            moment[h] +=
                term.curvature[i] * law_[term.other][i].moment(bent.curvature[term.other][i]);
    });
    return moment;
  }

  /// Diagonal terms that bound the stiffness of the elements, by `part` of their slopes.
  std::vector<double> stiffnesses(const Bent& bent, const auto& part) const {
    std::vector<double> stiffness(hinges_.size(), 0.0);
    parallel_for(hinges_.size(), kBendingGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t h = begin; h < end; ++h)
        for (const Term& term : of_hinge_[h])
          for (const int i : {0, 1}) {
            const std::size_t e = term.other;
            double all = 0.0;
            for (std::size_t t = begin_[e]; t < begin_[e + 1]; ++t)
              all += std::abs(terms_[t].curvature[i]);
            stiffness[h] +=
                part(law_[e][i].slope(bent.curvature[e][i])) * std::abs(term.curvature[i]) * all;
          }
    });
    return stiffness;
  }

  std::vector<SpringCurve> shapes_;
  std::vector<Hinge> hinges_;  // by colour
  std::vector<std::size_t> color_begin_;
  std::vector<std::array<BendingDeviation, 2>> law_;  // per element
  std::vector<std::size_t> begin_;                    // start of the terms of each element
  std::vector<Term> terms_;
  std::vector<std::vector<Term>> of_hinge_;
  std::vector<std::array<std::int32_t, 16>> slots_;
};

}  // namespace

std::unique_ptr<Force> make_bending_curves(const ClothMesh& cloth) {
  return std::make_unique<BendingCurves>(cloth);
}

void register_bending_curves(FabricLaws& laws) {
  laws.forces.add("bending_curve", {},
                  [](const MethodOptions&, const ClothMesh& cloth) {
                    ForceList forces;
                    if (!cloth.curvature_curves.empty())
                      forces.push_back(make_bending_curves(cloth));
                    return forces;
                  },
                  {.promise = "the measured M(kappa) of warp and weft beside the plate; minus the "
                              "gradient of its energy",
                   .source = "Kawabata, KES-F2; Zhong, Wang, 1998",
                   .energy = "bending"});
}

}  // namespace selvedge
