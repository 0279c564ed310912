// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric.h>

#include <cmath>
#include <numbers>

namespace selvedge {
namespace {

void validate_sheet(const KesSheet& s) {
  const auto positive = [](const char* name, double value) {
    require(std::isfinite(value) && value > 0.0, name, value, "positive and finite");
  };
  const auto number = [](const char* name, double value) {
    require(std::isfinite(value) && value >= 0.0, name, value, "at least 0 and finite");
  };
  positive("W in mg/cm2", s.weight);
  positive("EMT in %", s.emt);
  require(s.lt > 0.5 && s.lt <= 1.0, "LT", s.lt, "above 0.5 and at most 1");
  require(s.rt > 0.0 && s.rt <= 100.0, "RT in %", s.rt, "above 0 and at most 100");
  number("G in gf/(cm deg)", s.shear);
  number("2HG in gf/cm", s.shear_hysteresis);
  number("B in gf cm2/cm", s.bending);
  number("2HB in gf cm/cm", s.bending_hysteresis);
}

}  // namespace

Material material_of(const KesSheet& sheet) {
  validate_sheet(sheet);
  Material m;
  m.density = sheet.weight * kKgPerM2OfMgPerCm2;
  m.stretch_law = "kawabata";
  m.kawabata_lt = sheet.lt;
  m.kawabata_strain = 0.01 * sheet.emt;
  m.kawabata_rt = 0.01 * sheet.rt;
  // Slope at rest of the cubic with this LT that ends at (EMT, 500 gf/cm).
  m.stretch_stiffness =
      kKesEndOfTension * kNewtonPerMetreOfGfPerCm * (2.0 * sheet.lt - 1.0) / m.kawabata_strain;
  m.shear_law = "twisting";
  m.shear_stiffness =
      sheet.shear * kNewtonPerMetreOfGfPerCm * 180.0 / std::numbers::pi;  // per degree
  m.shear_friction = 0.5 * sheet.shear_hysteresis * kNewtonPerMetreOfGfPerCm;
  m.bending_stiffness = sheet.bending * kNewtonMetreOfGfCm2PerCm;
  m.bending_friction = 0.5 * sheet.bending_hysteresis * kNewtonOfGfCmPerCm;
  return m;
}

}  // namespace selvedge
