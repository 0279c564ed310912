// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric.h>
#include <selvedge/core/cloth/measure.h>

#include <cmath>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr double kGravity = 9.81;  // m/s², the default of scenes

void require_positive(const char* name, double value) {
  require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
}

void require_not_negative(const char* name, double value) {
  require(std::isfinite(value) && value >= 0.0, name, value, "at least 0 and finite");
}

void validate(const FabricConstants& c) {
  if (c.density) require_positive("density in kg/m2", *c.density);
  if (c.thickness) require_positive("thickness in m", *c.thickness);
  if (c.shear) require_not_negative("shear in N/m", *c.shear);
  if (c.shear_hysteresis) require_not_negative("shear hysteresis in N/m", *c.shear_hysteresis);
  if (c.bending_hysteresis) require_not_negative("bending hysteresis in N", *c.bending_hysteresis);
  if (c.friction) require_not_negative("friction", *c.friction);
  if (c.stretch) {
    require_positive("stretch along warp in N/m", c.stretch->warp);
    require_positive("stretch along weft in N/m", c.stretch->weft);
  }
  if (c.bending) {
    require_not_negative("bending along warp in N*m", c.bending->warp);
    require_not_negative("bending along weft in N*m", c.bending->weft);
  }
  if (c.drape_coefficient)
    require(*c.drape_coefficient > 0.0 && *c.drape_coefficient <= 100.0, "drape coefficient in %",
            *c.drape_coefficient, "above 0 and at most 100");
}

}  // namespace

Material material_of(const FabricConstants& c) {
  validate(c);
  Material m;
  if (c.density) m.density = *c.density;
  if (c.stretch) m.stretch_stiffness = c.stretch->warp;
  if (c.stretch && c.stretch->weft != c.stretch->warp) m.stretch_weft = c.stretch->weft;
  if (c.shear) m.shear_stiffness = *c.shear;
  if (c.bending) m.bending_stiffness = c.bending->warp;
  if (c.bending && c.bending->weft != c.bending->warp) m.bending_weft = c.bending->weft;
  if (c.friction) m.friction = *c.friction;
  if (c.bending_hysteresis) m.bending_friction = 0.5 * *c.bending_hysteresis;
  if (c.shear_hysteresis && *c.shear_hysteresis > 0.0) {
    m.shear_friction = 0.5 * *c.shear_hysteresis;
    m.shear_law = "twisting";
  }
  return m;
}

std::vector<std::string> notes_on(const FabricConstants& c) {
  std::vector<std::string> notes;
  const auto missing = [&](bool there, const char* what) {
    if (!there) notes.push_back(std::string(what) + " was not measured; the default is used");
  };
  missing(c.density.has_value(), "density");
  missing(c.stretch.has_value(), "stretch");
  missing(c.shear.has_value(), "shear");
  missing(c.bending.has_value(), "bending");
  return notes;
}

double bending_length(double rigidity, double density) {
  require_not_negative("rigidity in N*m", rigidity);
  require_positive("density in kg/m2", density);
  return elementary::cbrt(rigidity / (density * kGravity));
}

double rigidity_of_length(double bending_length, double density) {
  require_positive("bending length in m", bending_length);
  require_positive("density in kg/m2", density);
  return density * kGravity * bending_length * bending_length * bending_length;
}

// At 41.5°, w L³/B = 8.004, so c = L/2 with an error of 2 in ten thousand.
FabricConstants constants_of(const CantileverTest& test) {
  require_positive("overhang along warp in m", test.overhang_warp);
  require_positive("overhang along weft in m", test.overhang_weft);
  FabricConstants c;
  c.density = test.density;
  c.bending = WarpWeft{rigidity_of_length(0.5 * test.overhang_warp, test.density),
                       rigidity_of_length(0.5 * test.overhang_weft, test.density)};
  return c;
}

namespace {

double fast_stretch(double e20, double e100) {
  constexpr double loads = 100.0 - 20.0;  // gf/cm
  return loads * kNewtonPerMetreOfGfPerCm / (0.01 * (e100 - e20));
}

void require_ascending(const char* yarn, double e5, double e20, double e100) {
  if (!(e5 >= 0.0 && e20 >= e5 && e100 > e20))
    throw std::invalid_argument(std::string("the extensions E5, E20, E100 along ") + yarn +
                                " must not decrease with the load, but are " + std::to_string(e5) +
                                ", " + std::to_string(e20) + ", " + std::to_string(e100) + " %");
}

}  // namespace

FabricConstants constants_of(const FastSheet& sheet) {
  constexpr double gram = 1e-3, millimetre = 1e-3;
  constexpr double shear_of_eb5 = 123.0;  // N/m times %
  require_positive("W in g/m2", sheet.weight);
  require_positive("EB5 in %", sheet.eb5);
  require_ascending("warp", sheet.e5.warp, sheet.e20.warp, sheet.e100.warp);
  require_ascending("weft", sheet.e5.weft, sheet.e20.weft, sheet.e100.weft);
  FabricConstants c;
  c.density = gram * sheet.weight;
  c.bending = WarpWeft{rigidity_of_length(millimetre * sheet.c_warp, *c.density),
                       rigidity_of_length(millimetre * sheet.c_weft, *c.density)};
  c.stretch = WarpWeft{fast_stretch(sheet.e20.warp, sheet.e100.warp),
                       fast_stretch(sheet.e20.weft, sheet.e100.weft)};
  c.shear = shear_of_eb5 / sheet.eb5;
  return c;
}

double longest_bending_length(double drape_coefficient) {
  constexpr double least = 1e-3, most = 1.0;  // m
  require(drape_coefficient > 0.0 && drape_coefficient < 100.0, "drape coefficient in %",
          drape_coefficient, "between 0 and 100");
  double low = least, high = most;
  constexpr int halvings = 60;
  for (int i = 0; i < halvings; ++i) {
    const double middle = std::sqrt(low * high);
    (strip_drape_coefficient(middle) < drape_coefficient ? low : high) = middle;
  }
  return low;
}

double linearity(const TensionCurve& curve) {
  if (curve.strain.size() != curve.force.size() || curve.strain.size() < 2)
    throw std::invalid_argument("a tension curve needs as many forces as strains, at least 2");
  double work = 0.0;
  for (std::size_t i = 1; i < curve.strain.size(); ++i) {
    if (!(curve.strain[i] > curve.strain[i - 1]) || !(curve.force[i] >= curve.force[i - 1]))
      throw std::invalid_argument("the tension curve decreases at its point " + std::to_string(i) +
                                  ", strain " + std::to_string(curve.strain[i]) +
                                  "; it must rise from each point to the next");
    work += 0.5 * (curve.force[i] + curve.force[i - 1]) * (curve.strain[i] - curve.strain[i - 1]);
  }
  if (curve.strain.front() != 0.0 || curve.force.front() != 0.0)
    throw std::invalid_argument("the tension curve must begin at strain 0 and force 0");
  require_positive("force at the end of the tension curve", curve.force.back());
  return work / (0.5 * curve.force.back() * curve.strain.back());
}

void set_tension(const TensionCurve& curve, Material& material) {
  const double lt = linearity(curve), secant = curve.force.back() / curve.strain.back();
  material.stretch_law = "hooke";
  material.stretch_weft.reset();  // the single measured curve applies to both directions
  material.stretch_stiffness = secant;
  if (!(lt > 0.5 && lt <= 1.0)) return;
  material.stretch_law = "kawabata";
  material.kawabata_lt = lt;
  material.kawabata_strain = curve.strain.back();
  material.stretch_stiffness = (2.0 * lt - 1.0) * secant;
}

}  // namespace selvedge
