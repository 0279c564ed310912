// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/material.h>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A constant along warp and weft.
struct WarpWeft {
  double warp = 0.0, weft = 0.0;

  double mean() const { return 0.5 * (warp + weft); }
};

/// What a laboratory has measured of a fabric, in SI units; nothing where it has not.
struct FabricConstants {
  std::optional<double> density;             ///< kg/m²
  std::optional<double> thickness;           ///< m
  std::optional<WarpWeft> stretch;           ///< N/m, force per width and strain
  std::optional<double> shear;               ///< N/m, force per width and radian
  std::optional<WarpWeft> bending;           ///< N·m, rigidity per width
  std::optional<double> shear_hysteresis;    ///< N/m, 2HG, the whole width of the loop
  std::optional<double> bending_hysteresis;  ///< N, 2HB, the whole width of the loop
  std::optional<double> friction;            ///< Coulomb coefficient, cloth on cloth
  std::optional<double> drape_coefficient;   ///< percent, 18 cm support, 30 cm specimen
};

/// The fabric as cloth, defaults where nothing was measured. Hysteresis of shear brings twisting
/// springs with it. Throws std::invalid_argument naming a bad value and unit.
Material material_of(const FabricConstants& constants);
/// What `material_of` had to take for granted or to leave out, a sentence each.
std::vector<std::string> notes_on(const FabricConstants& constants);

/// Bending length c = (B/w)^⅓ in m of rigidity B in N·m and density in kg/m² [Peirce1930].
double bending_length(double rigidity, double density);
/// B = w c³ in N·m.
double rigidity_of_length(double bending_length, double density);

/// A strip pushed over an edge until its tip is 41.5° below it (ASTM D1388): the bending length is
/// half the overhang.
struct CantileverTest {
  double overhang_warp = 0.0, overhang_weft = 0.0;  ///< m, > 0
  double density = 0.0;                             ///< kg/m², > 0
};
FabricConstants constants_of(const CantileverTest& test);

/// A FAST sheet, in its own units [DeBoos1994].
struct FastSheet {
  double weight = 0.0;                ///< W, g/m²
  double c_warp = 0.0, c_weft = 0.0;  ///< bending lengths C1, C2, mm (FAST-2)
  WarpWeft e5, e20, e100;             ///< extension, %, at 5, 20 and 100 gf/cm (FAST-3)
  double eb5 = 0.0;                   ///< extension on the bias at 5 gf/cm, %
};
/// Stretch is the secant from 20 to 100 gf/cm, shear 123/EB5 N/m, bending by the bending lengths.
FabricConstants constants_of(const FastSheet& sheet);

/// The bending length, m, at which free radial strips would have this drape coefficient (%, 18 cm
/// support, 30 cm specimen). As shear and hoop stress only add to it, that of the fabric is at most
/// this. In (0, 100).
double longest_bending_length(double drape_coefficient);

/// A measured tension curve, strain [1] and force per width [N/m], both ascending from (0, 0).
struct TensionCurve {
  std::vector<double> strain, force;
};
/// LT of the curve: the work under it over that of a straight line to its end.
double linearity(const TensionCurve& curve);
/// Gives `material` the curve: Kawabata's where LT allows it, else the secant. Throws
/// std::invalid_argument naming the point where the curve falls.
void set_tension(const TensionCurve& curve, Material& material);

}  // namespace selvedge
