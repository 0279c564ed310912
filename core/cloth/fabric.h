// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A measured curve y(x) from (0, 0), both rising: the monotone piecewise cubic of
/// [FritschCarlson1980]. It passes through the points, and its slope is continuous and positive.
/// Beyond the last point it continues straight with the last slope; y(-x) = -y(x).
class MonotoneCurve {
 public:
  MonotoneCurve() = default;  ///< no curve
  /// Throws std::invalid_argument naming the point at which `x` or `y` does not rise.
  MonotoneCurve(std::vector<double> x, std::vector<double> y);

  bool empty() const { return x_.empty(); }
  double value(double x) const;
  double slope(double x) const;
  double work(double x) const;  ///< exact integral of the curve from 0 to x
  double slope_at_rest() const { return slope_.front(); }
  std::span<const double> x() const { return x_; }
  std::span<const double> y() const { return y_; }

  bool operator==(const MonotoneCurve&) const = default;

 private:
  std::size_t piece_of(double size) const;

  std::vector<double> x_, y_, slope_, work_;
};

/// Fabric constants of a cloth, independent of the mesh.
struct Material {
  double density = 0.2;              ///< kg/m², > 0
  double stretch_stiffness = 500.0;  ///< N/m (force per width per strain along warp and weft), > 0
  double shear_stiffness = 100.0;    ///< N/m (force per width per shear angle), >= 0
  double bending_stiffness = 1e-5;   ///< N·m (plate rigidity B), >= 0
  /// s: damping force of a spring per stiffness and rate of length change, >= 0.
  double spring_damping = 0.01;
  /// s: damping moment of a hinge per stiffness and rate of angle, >= 0.
  double bending_damping = 0.01;
  double strain_limit = 0.1;  ///< largest stretch (L-L0)/L0 of a spring, > 0
  double friction = 0.3;      ///< Coulomb coefficient, cloth on cloth, >= 0
  // Names of laws (core/cloth/fabric_laws.h).
  std::string stretch_law = "hooke", shear_law = "springs", bending_law = "shape_operator";
  /// Constants that a law defines (core/cloth/fabric_laws.h), by name, unless they are the usual.
  std::map<std::string, double> of_laws{};
  double kawabata_lt = 0.7;       ///< linearity of the tension curve, in (0.5, 1]
  double kawabata_strain = 0.05;  ///< EMT/100, strain at the end of the tension test, > 0
  double kawabata_rt = 1.0;       ///< RT/100, recovered fraction of the work of tension, in (0, 1]
  /// N/m, HG: half the width of the shear loop; only with `twisting` and `angle`.
  double shear_friction = 0.0;
  /// N, HB: moment per width, half the width of the bending loop; grids and shape_operator only.
  double bending_friction = 0.0;
  /// N/m (> 0) and N·m (>= 0) along the weft, if it differs from the warp; stretch_stiffness and
  /// bending_stiffness then apply to the warp. Meshes without warp and weft use the mean.
  std::optional<double> stretch_weft{}, bending_weft{};
  /// Poisson's ratio of the membrane laws, C12/√(C11 C22), in (-1, 0.999]. Without it C12 = C33, as
  /// in any net of springs.
  std::optional<double> poisson{};
  /// Measured curves; an empty one is not used. Each gives the shape of a law, whose slope at rest
  /// is the stiffness above: set_curves makes both agree. The weft has the curve of the warp unless
  /// it has its own.
  MonotoneCurve tension_curve{}, tension_weft{};        ///< N/m over strain, with `measured`
  MonotoneCurve shear_curve{};                          ///< N/m over rad, with `angle`
  MonotoneCurve bending_curve{}, bending_curve_weft{};  ///< N over 1/m
};

/// Sets the stiffness along warp and weft, of shear and of bending to the slopes at rest of the
/// curves that `material` has.
void set_curves(Material& material);

inline double stretch_along_weft(const Material& m) {
  return m.stretch_weft.value_or(m.stretch_stiffness);
}
inline double bending_along_weft(const Material& m) {
  return m.bending_weft.value_or(m.bending_stiffness);
}

/// A constant with one value along the warp and one along the weft.
struct WarpWeft {
  double warp = 0.0, weft = 0.0;

  double mean() const { return 0.5 * (warp + weft); }
};

/// Measured constants of a fabric in SI units. Constants that were not measured are empty.
struct FabricConstants {
  std::optional<double> density;             ///< kg/m²
  std::optional<double> thickness;           ///< m
  std::optional<WarpWeft> stretch;           ///< N/m, force per width and strain
  std::optional<double> shear;               ///< N/m, force per width and radian
  std::optional<WarpWeft> bending;           ///< N·m, rigidity per width
  std::optional<double> shear_hysteresis;    ///< N/m, 2HG, full width of the loop
  std::optional<double> bending_hysteresis;  ///< N, 2HB, full width of the loop
  std::optional<double> friction;            ///< Coulomb coefficient, cloth on cloth
  std::optional<double> drape_coefficient;   ///< percent, 18 cm support, 30 cm specimen
};

/// Material with these constants and defaults for those not measured. Shear hysteresis selects
/// twisting springs. Throws std::invalid_argument naming the bad value and its unit.
Material material_of(const FabricConstants& constants);
/// The assumptions and omissions of `material_of`, one sentence each.
std::vector<std::string> notes_on(const FabricConstants& constants);

/// Bending length c = (B/w)^⅓ in m, from the rigidity B in N·m and the density in kg/m²
/// [Peirce1930].
double bending_length(double rigidity, double density);
/// Bending rigidity B = w c³ in N·m.
double rigidity_of_length(double bending_length, double density);

/// Cantilever test (ASTM D1388): a strip is pushed over an edge until its tip is 41.5° below the
/// edge. The bending length is half the overhang.
struct CantileverTest {
  double overhang_warp = 0.0, overhang_weft = 0.0;  ///< m, > 0
  double density = 0.0;                             ///< kg/m², > 0
};
/// Bending rigidity and density. Throws std::invalid_argument naming the bad value and its unit.
FabricConstants constants_of(const CantileverTest& test);

/// A FAST sheet in the units of its laboratory report [DeBoos1994].
struct FastSheet {
  double weight = 0.0;                ///< W, g/m²
  double c_warp = 0.0, c_weft = 0.0;  ///< bending lengths C1, C2, mm (FAST-2)
  WarpWeft e5, e20, e100;             ///< extension, %, at 5, 20 and 100 gf/cm (FAST-3)
  double eb5 = 0.0;                   ///< extension on the bias at 5 gf/cm, %
};
/// Stretch is the secant between 20 and 100 gf/cm, shear is 123/EB5 N/m, and bending comes from the
/// bending lengths.
FabricConstants constants_of(const FastSheet& sheet);

/// Upper bound of a fabric's bending length (m) from its drape coefficient (%, in (0, 100); 18 cm
/// support, 30 cm specimen): the bending length at which free radial strips have this coefficient.
/// Shear and hoop stress raise the coefficient, so the fabric's own bending length is not larger.
double longest_bending_length(double drape_coefficient);

/// A measured tension curve: strain [1] and force per width [N/m], both ascending from (0, 0).
struct TensionCurve {
  std::vector<double> strain, force;
};
/// LT of the curve: the work under it divided by the work under a straight line to its end point.
double linearity(const TensionCurve& curve);
/// Sets the stretch law of `material`: Kawabata's curve if LT allows it, else the secant. Throws
/// std::invalid_argument naming the point where the curve decreases.
void set_tension(const TensionCurve& curve, Material& material);

/// The figures of a tension test (KES-F1) as read from its curve.
struct TensionFigures {
  double extension = 0.0;  ///< EMT/100, strain at the end
  double work = 0.0;       ///< WT, N/m: work per area
  double linearity = 0.0;  ///< LT: work divided by that under a straight line to the end
};
TensionFigures figures_of(const MonotoneCurve& pull);
/// RT/100: the work that the curve of return gives back, divided by that of the pull. The points of
/// `release` rise from the strain at which the force is 0 to the end of the pull. Throws
/// std::invalid_argument if the curve of return does not end where the pull does, or lies above it.
double resilience(const MonotoneCurve& pull, const TensionCurve& release);

/// Shear from a tensile test at 45° to the warp [Ji2006]. In the small, the compliances add up to
/// 4/E45 = 1/E1 + 1/E2 + 1/G. Beyond that the yarns, which bear half the load each, stretch by
/// their share of the extension, and turn as in a trellis by the rest: with the strain ε of that
/// rest,
///   √2 cos(π/4 - φ/2) = 1 + ε,  τ = f sin(π/4 - φ/2)/√2.
/// `bias` gives the force per width over the strain; `stretch`, the stiffness of the yarns in N/m.
/// Throws std::invalid_argument if the yarns alone stretch farther than the cloth.
MonotoneCurve shear_of_bias(const TensionCurve& bias, const WarpWeft& stretch);
/// G in N/m from the modulus E45 in N/m.
double shear_of_bias(double modulus, const WarpWeft& stretch);

/// Results of a KES-F test in the units of the instrument, as means of warp and weft.
struct KesSheet {
  double weight = 20.0;              ///< W, mg/cm²
  double lt = 0.7;                   ///< LT, linearity of tension, in (0.5, 1]
  double emt = 5.0;                  ///< EMT, % at 500 gf/cm
  double rt = 100.0;                 ///< RT, %, recovered part of the work of tension, in (0, 100]
  double shear = 0.7;                ///< G, gf/(cm·deg)
  double shear_hysteresis = 1.0;     ///< 2HG, gf/cm
  double bending = 0.1;              ///< B, gf·cm²/cm
  double bending_hysteresis = 0.04;  ///< 2HB, gf·cm/cm
};

/// Factor from gf/cm to N/m: newtons per gram-force divided by metres per centimetre.
inline constexpr double kNewtonPerMetreOfGfPerCm = 0.980665;
/// Factor from gf·cm²/cm to N·m (rigidity per width).
inline constexpr double kNewtonMetreOfGfCm2PerCm = 9.80665e-5;
/// Factor from gf·cm/cm to N (moment per width).
inline constexpr double kNewtonOfGfCmPerCm = 9.80665e-3;
/// Factor from mg/cm² to kg/m².
inline constexpr double kKgPerM2OfMgPerCm2 = 0.01;
/// Load at the end of the KES-F1 tension test, gf/cm.
inline constexpr double kKesEndOfTension = 500.0;

/// Material with these constants in SI units: Kawabata's tension curve, twisting springs for shear,
/// hinges for bending, and hysteresis of both. Throws std::invalid_argument naming the bad field,
/// its value and its unit.
Material material_of(const KesSheet& sheet);

}  // namespace selvedge
