// SPDX-License-Identifier: MIT
//
// Finite elements for stretch and shear: triangles of constant strain, the rivals of the
// mass-spring model that the abstract of the survey names. The deformation gradient F = Σ xᵢ gᵢᵀ (3
// × 2) follows from the gradients gᵢ of the three shape functions along warp and weft. With the
// strain e = (e11, e22, 2 e12), the energy is A ½ eᵀ C e, and the stress σ = C (e + damping de/dt)
// gives the forces -A Bᵀ σ with B = ∂e/∂x.
//   st_venant_kirchhoff: Green's strain ½ (FᵀF - I) [BonetWood2008]. A triangle that is squeezed to
//     a point costs finite energy.
//   corotated: U - I with F = R U, U symmetric: linear elasticity in the frame of the triangle
//     [Etzmuss2003]. Deviation: R is the rotation of the polar decomposition, and its derivative is
//     part of the force, so that the force is minus the gradient of the energy.
//
// Second derivative: ∂²E/∂x² = A (Bᵀ C B + Σ σ ∂²e/∂x²). The first part is positive semidefinite.
// The second one is projected in closed form (detail below), as [Teran2005] does for solids.
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;
using Mat32 = Eigen::Matrix<double, 3, 2>;
/// ∂e/∂x for each vertex: row k is the derivative of strain component k.
using StrainRows = std::array<Mat3, 3>;

/// A triangle of constant strain, ready for evaluation.
struct MembraneElement {
  std::array<std::int32_t, 3> v;
  std::array<Vec2, 3> slope;  // 1/m, gradient of the shape function of each vertex
  double area;                // m²
  Mat3 constants;             // N/m, C
  double damping;             // s
};

MembraneElement element_of(const MembraneTriangle& t, std::size_t i) {
  constexpr const char* name = "membrane triangle";
  const Vec2 p(t.rest[0][0], t.rest[0][1]);
  const Vec2 a = Vec2(t.rest[1][0], t.rest[1][1]) - p, b = Vec2(t.rest[2][0], t.rest[2][1]) - p;
  const double doubled = a.x() * b.y() - a.y() * b.x();
  MembraneElement e{t.v, {}, 0.5 * std::abs(doubled), Mat3::Zero(), t.damping};
  detail::require_number_of("area", name, i, e.area, false);
  e.slope[1] = Vec2(b.y(), -b.x()) / doubled;
  e.slope[2] = Vec2(-a.y(), a.x()) / doubled;
  e.slope[0] = -e.slope[1] - e.slope[2];
  detail::require_number_of("c11", name, i, t.c11, false);
  detail::require_number_of("c22", name, i, t.c22, false);
  detail::require_number_of("c33", name, i, t.c33);
  detail::require_number_of("c11 c22 - c12^2", name, i, t.c11 * t.c22 - t.c12 * t.c12, false);
  detail::require_number_of("damping", name, i, t.damping);
  e.constants << t.c11, t.c12, 0.0, t.c12, t.c22, 0.0, 0.0, 0.0, t.c33;
  return e;
}

Mat32 deformation(const MembraneElement& e, std::span<const Vec3> x) {
  const Vec3 a = x[e.v[1]] - x[e.v[0]], b = x[e.v[2]] - x[e.v[0]];
  return a * e.slope[1].transpose() + b * e.slope[2].transpose();
}

Mat2 symmetric(const Vec3& stress) {
  Mat2 s;
  s << stress[0], stress[2], stress[2], stress[1];
  return s;
}

/// The nearest positive semidefinite matrix to a symmetric one: the part of its positive
/// eigenvalues m ± r.
Mat2 positive_part(const Mat2& s) {
  const double m = 0.5 * (s(0, 0) + s(1, 1)), d = 0.5 * (s(0, 0) - s(1, 1));
  const double r = elementary::hypot(d, s(0, 1));
  if (m >= r) return s;
  if (m <= -r) return Mat2::Zero();
  Mat2 toward;  // twice the projector on the eigenvector of m + r
  toward << 1.0 + d / r, s(0, 1) / r, s(0, 1) / r, 1.0 - d / r;
  return (0.5 * (m + r)) * toward;
}

/// The part Σ σ ∂²e/∂x² of the second derivative, per area. With the angles θᵢ = ∂θ/∂xᵢ, block (i,
/// j) is (gᵢᵀ across gⱼ) plane + q θᵢ θⱼᵀ + θᵢ (Bⱼᵀc)ᵀ + (Bᵢᵀc) θⱼᵀ.
struct StressPart {
  Mat2 across = Mat2::Zero();  // N/m
  Mat3 plane = Mat3::Zero();   // projector on the directions that `across` holds for
  double turn = 0.0;           // N/m, q: per square of the rotation θ of the frame
  Vec3 couple = Vec3::Zero();  // N/m, c: per product of θ and the strains
  std::array<Vec3, 3> angle{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // 1/m, ∂θ/∂x
};

/// Green's strain. ∂²E/∂F² has the part dFᵀdF : S, positive semidefinite if the stress S is.
class GreenStrain {
 public:
  static constexpr const char* name = "st_venant_kirchhoff";

  GreenStrain(const MembraneElement& e, std::span<const Vec3> x) : e_(e), f_(deformation(e, x)) {}

  Vec3 strain() const {
    return {0.5 * (f_.col(0).squaredNorm() - 1.0), 0.5 * (f_.col(1).squaredNorm() - 1.0),
            f_.col(0).dot(f_.col(1))};
  }

  StrainRows rows() const {
    StrainRows b;
    for (int i = 0; i < 3; ++i) {
      const Vec2& g = e_.slope[i];
      b[i].row(0) = g[0] * f_.col(0);
      b[i].row(1) = g[1] * f_.col(1);
      b[i].row(2) = g[0] * f_.col(1) + g[1] * f_.col(0);
    }
    return b;
  }

  StressPart stress_part(const Vec3& stress, bool projected) const {
    StressPart part;
    part.across = projected ? positive_part(symmetric(stress)) : symmetric(stress);
    part.plane = Mat3::Identity();
    return part;
  }

 private:
  const MembraneElement& e_;
  Mat32 f_;
};

/// U - I of F = R U. R has the columns r1, r2 in the plane of the triangle. If F changes by dF,
/// then with M = RᵀdF and t = tr U, R rotates in its plane by θ = (M21 - M12)/t, and dU = M - θ J
/// U, where J is the rotation by a right angle. To second order, for a motion dF in the plane,
///   σ:d²U = q θ² + 2 θ c·de,  q = σ:U,  de = (dU11, dU22, 2 dU12),
///   c = (-δ U12 - 2 σ12 U22, -δ U12 + 2 σ12 U11, ½ δ t)/t,  δ = σ11 - σ22,
/// and for a motion η = dFᵀn along the normal n, 2 ηᵀ T η with U T + T U = σ.
class StretchTensor {
 public:
  static constexpr const char* name = "corotated";

  StretchTensor(const MembraneElement& e, std::span<const Vec3> x) : e_(e) {
    const Mat32 f = deformation(e, x);
    const Vec3 normal = f.col(0).cross(f.col(1));
    const int longer = f.col(1).squaredNorm() > f.col(0).squaredNorm() ? 1 : 0;
    const double length = f.col(longer).norm();
    if (length <= 0.0) return;
    // Below about this ratio of the principal stretches, a triangle cannot be told from a line, and
    // has no second direction. Up to there any normal of the line keeps the moment balanced.
    constexpr double thinnest = 1e-15;
    const bool flat = normal.norm() <= thinnest * f.squaredNorm();
    const Vec3 along = f.col(longer) / length;
    // The normal of a thin triangle has an error along it.
    if (!flat) normal_ = (normal - normal.dot(along) * along).normalized();
    Mat32 frame;
    frame.col(longer) = along;
    frame.col(1 - longer) = longer == 0 ? normal_.cross(along) : along.cross(normal_);
    const Mat2 in_frame = frame.transpose() * f;
    const double cosine = in_frame(0, 0) + in_frame(1, 1), sine = in_frame(1, 0) - in_frame(0, 1);
    trace_ = elementary::hypot(cosine, sine);
    Mat2 turn;
    turn << cosine, -sine, sine, cosine;
    turn /= trace_;
    rotation_ = frame * turn;
    stretch_ = turn.transpose() * in_frame;
    stretch_(0, 1) = stretch_(1, 0) = 0.5 * (stretch_(0, 1) + stretch_(1, 0));
  }

  Vec3 strain() const { return {stretch_(0, 0) - 1.0, stretch_(1, 1) - 1.0, 2.0 * stretch_(0, 1)}; }

  StrainRows rows() const {
    StrainRows b{Mat3::Zero(), Mat3::Zero(), Mat3::Zero()};
    if (trace_ <= 0.0) return b;
    for (int i = 0; i < 3; ++i) {
      const Vec2& g = e_.slope[i];
      const Vec3 angle = angle_of(i);
      // -J U = (U12, U22; -U11, -U12)
      b[i].row(0) = g[0] * rotation_.col(0) + stretch_(0, 1) * angle;
      b[i].row(1) = g[1] * rotation_.col(1) - stretch_(0, 1) * angle;
      b[i].row(2) = g[1] * rotation_.col(0) + g[0] * rotation_.col(1) +
                    (stretch_(1, 1) - stretch_(0, 0)) * angle;
    }
    return b;
  }

  // θ and de are independent coordinates of a motion in the plane, so deᵀC de + 2 θ c·de + q θ² is
  // positive semidefinite just if q >= cᵀC⁻¹c: a smaller q is raised to that.
  StressPart stress_part(const Vec3& stress, bool projected) const {
    StressPart part;
    if (trace_ <= 0.0) return part;
    for (int i = 0; i < 3; ++i) part.angle[i] = angle_of(i);
    const double delta = stress[0] - stress[1], u12 = stretch_(0, 1);
    part.turn = stress[0] * stretch_(0, 0) + stress[1] * stretch_(1, 1) + 2.0 * stress[2] * u12;
    part.couple = {(-delta * u12 - 2.0 * stress[2] * stretch_(1, 1)) / trace_,
                   (-delta * u12 + 2.0 * stress[2] * stretch_(0, 0)) / trace_, 0.5 * delta};
    if (projected && e_.constants(2, 2) <= 0.0) part.couple.setZero();
    if (projected) part.turn = std::max(part.turn, compliance(part.couple));
    if (normal_.isZero(0.0)) return part;
    part.across = 2.0 * half_sum(symmetric(stress));
    if (projected) part.across = positive_part(part.across);
    part.plane = normal_ * normal_.transpose();
    return part;
  }

 private:
  Vec3 angle_of(int i) const {
    const Vec2& g = e_.slope[i];
    return (g[0] * rotation_.col(1) - g[1] * rotation_.col(0)) / trace_;
  }

  /// cᵀC⁻¹c, at least 0.
  double compliance(const Vec3& c) const {
    const Mat3& k = e_.constants;
    const double det = k(0, 0) * k(1, 1) - k(0, 1) * k(0, 1);
    const double shear = k(2, 2) > 0.0 ? c[2] * c[2] / k(2, 2) : 0.0;
    return (k(1, 1) * c[0] * c[0] - 2.0 * k(0, 1) * c[0] * c[1] + k(0, 0) * c[1] * c[1]) / det +
           shear;
  }

  /// T with U T + T U = σ: (det U σ + adj U σ adj U)/(2 tr U det U).
  Mat2 half_sum(const Mat2& stress) const {
    const double det = stretch_(0, 0) * stretch_(1, 1) - stretch_(0, 1) * stretch_(0, 1);
    if (det <= 0.0) return Mat2::Zero();
    const Mat2 adjugate = trace_ * Mat2::Identity() - stretch_;
    Mat2 t = (det * stress + adjugate * stress * adjugate) / (2.0 * trace_ * det);
    t(1, 0) = t(0, 1);
    return t;
  }

  const MembraneElement& e_;
  Mat32 rotation_ = Mat32::Zero();
  Mat2 stretch_ = Mat2::Zero();
  Vec3 normal_ = Vec3::Zero();  // zero if the triangle is squeezed to a line
  double trace_ = 0.0;          // of the stretch; zero if it is squeezed to a point
};

template <class Measure>
class MembraneForce final : public Force {
 public:
  MembraneForce(std::span<const MembraneTriangle> triangles, std::size_t particles) {
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < triangles.size(); ++i)
      for (const std::int32_t v : triangles[i].v) {
        detail::require_particle("membrane triangle", i, v, particles);
        corners.push_back(v);
      }
    detail::Coloring coloring = detail::color_elements(corners, 3, particles);
    elements_.reserve(triangles.size());
    for (const std::int32_t i : coloring.order)
      elements_.push_back(element_of(triangles[i], static_cast<std::size_t>(i)));
    color_begin_ = std::move(coloring.color_begin);
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const MembraneElement& e = elements_[k];
        const Measure measure(e, state.x);
        const StrainRows b = measure.rows();
        // Relative velocities, so that a common one leaves no rounding error.
        const Vec3 rate =
            b[1] * (state.v[e.v[1]] - state.v[e.v[0]]) + b[2] * (state.v[e.v[2]] - state.v[e.v[0]]);
        const Vec3 stress = e.area * (e.constants * (measure.strain() + e.damping * rate));
        const Vec3 f1 = b[1].transpose() * stress, f2 = b[2].transpose() * stress;
        f[e.v[0]] += f1 + f2;
        f[e.v[1]] -= f1;
        f[e.v[2]] -= f2;
      }
    });
  }

  double energy(const ForceState& state) const override {
    constexpr std::size_t grain = 2048;
    return parallel_sum(elements_.size(), grain, [&](std::size_t begin, std::size_t end) {
      double sum = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        const MembraneElement& e = elements_[k];
        const Vec3 strain = Measure(e, state.x).strain();
        sum += 0.5 * e.area * strain.dot(e.constants * strain);
      }
      return sum;
    });
  }

  void add_links(std::vector<Edge>& links) const override {
    for (const MembraneElement& e : elements_)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < i; ++j) links.push_back({e.v[i], e.v[j]});
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.assign(elements_.size(), {});
    for (std::size_t k = 0; k < elements_.size(); ++k)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          slots_[k][3 * i + j] = matrix.slot(elements_[k].v[i], elements_[k].v[j]);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    const std::span<Mat3> values = a.values();
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        const MembraneElement& e = elements_[k];
        const double along = h * (h + e.damping) * e.area, stressed = h * h * e.area;
        for_each_block(e, state.x, true, [&](int i, int j, const Mat3& strained, const Mat3& rest) {
          const Mat3 block = along * strained + stressed * rest;
          values[slots_[k][3 * i + j]] += block;
          if (i != j) values[slots_[k][3 * j + i]] += block.transpose();
        });
      }
    });
  }

  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    for (const MembraneElement& e : elements_)
      for_each_block(e, state.x, false, [&](int i, int j, const Mat3& strained, const Mat3& rest) {
        const double norm = e.area * (strained + rest).norm();
        const double damped = e.area * e.damping * strained.norm();
        stiffness[e.v[i]] += norm;
        damping[e.v[i]] += damped;
        if (i == j) return;
        stiffness[e.v[j]] += norm;
        damping[e.v[j]] += damped;
      });
  }

 private:
  /// Calls visit(i, j, BᵢᵀC Bⱼ, the stress part) for the blocks j <= i of the second derivative of
  /// the energy per area.
  static void for_each_block(const MembraneElement& e, std::span<const Vec3> x, bool projected,
                             auto&& visit) {
    const Measure measure(e, x);
    const StrainRows b = measure.rows();
    const StressPart s = measure.stress_part(e.constants * measure.strain(), projected);
    std::array<Vec3, 3> coupled;
    for (int i = 0; i < 3; ++i) coupled[i] = b[i].transpose() * s.couple;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) {
        const Mat3 strained = b[i].transpose() * (e.constants * b[j]);
        const Mat3 rest = e.slope[i].dot(s.across * e.slope[j]) * s.plane +
                          s.turn * s.angle[i] * s.angle[j].transpose() +
                          s.angle[i] * coupled[j].transpose() + coupled[i] * s.angle[j].transpose();
        visit(i, j, strained, rest);
      }
  }

  std::vector<MembraneElement> elements_;
  std::vector<std::array<std::int32_t, 9>> slots_;
  std::vector<std::size_t> color_begin_;
};

}  // namespace

std::unique_ptr<Force> make_membrane_force(std::span<const MembraneTriangle> triangles,
                                           MembraneStrain strain, std::size_t particles) {
  if (strain == MembraneStrain::green)
    return std::make_unique<MembraneForce<GreenStrain>>(triangles, particles);
  return std::make_unique<MembraneForce<StretchTensor>>(triangles, particles);
}

namespace {

template <MembraneStrain strain>
ForceList membrane_forces(const MethodOptions&, const ClothMesh& cloth) {
  std::vector<MembraneTriangle> triangles;
  for (const MembraneTriangle& t : cloth.membranes)
    if (t.strain == strain) triangles.push_back(t);
  ForceList forces;
  if (!triangles.empty())
    forces.push_back(make_membrane_force(triangles, strain, cloth.mass.size()));
  return forces;
}

/// The law of a strain. Its springs follow a curve without force.
template <class Strain, MembraneStrain strain>
StretchLaw membrane_law(const char* text) {
  return {
      .name = Strain::name,
      .text = text,
      .curve = [](const Material&) { return SpringCurve{.law = Strain::name}; },
      .reads = {"poisson"},
      .add_to_triangles = [](ClothMesh& cloth, std::span<const Vec3> rest,
                             const Material& m) { detail::add_membrane(cloth, rest, m, strain); }};
}

}  // namespace

void register_membrane(FabricLaws& laws) {
  using enum MembraneStrain;
  laws.stretch.push_back(membrane_law<GreenStrain, green>(
      "finite elements on the triangles instead of springs, with Green's strain"));
  laws.stretch.push_back(membrane_law<StretchTensor, corotated>(
      "likewise, linear in the frame of each triangle; both serve every constant on any mesh"));
  laws.forces.add(
      GreenStrain::name, {}, membrane_forces<green>,
      {.promise = "finite elements with Green's strain; any constants on any mesh",
       .source = "Bonet, Wood, Nonlinear continuum mechanics for finite element analysis, 2008",
       .energy = "stretch_and_shear"});
  laws.forces.add(
      StretchTensor::name, {}, membrane_forces<corotated>,
      {.promise =
           "finite elements, linear in the frame of each triangle; any constants on any mesh",
       .source =
           "Etzmuss, Keckeisen, Strasser, A fast finite element solution for cloth modeling, 2003",
       .energy = "stretch_and_shear"});
}

}  // namespace selvedge
