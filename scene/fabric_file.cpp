// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/fabric.h>
#include <selvedge/scene/detail/fabric_texts.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

namespace selvedge {
namespace {

using Json = nlohmann::json;
/// Factors to SI by unit.
using Units = std::map<std::string, double>;

constexpr double per_degree = 180.0 / std::numbers::pi;
constexpr double ounce_per_square_yard = 0.028349523125 / (0.9144 * 0.9144);

const Units densities = {{"kg/m2", 1.0},
                         {"g/m2", 1e-3},
                         {"mg/cm2", kKgPerM2OfMgPerCm2},
                         {"oz/yd2", ounce_per_square_yard}};
const Units lengths = {{"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}};
const Units forces_per_width = {
    {"N/m", 1.0}, {"N/cm", 100.0}, {"gf/cm", kNewtonPerMetreOfGfPerCm}, {"g/s2", 1e-3}};
const Units shears = {{"N/m", 1.0},
                      {"g/s2", 1e-3},
                      {"gf/(cm*deg)", kNewtonPerMetreOfGfPerCm* per_degree},
                      {"N/(m*deg)", per_degree}};
const Units rigidities = {
    {"N*m", 1.0}, {"uN*m", 1e-6}, {"gf*cm2/cm", kNewtonMetreOfGfCm2PerCm}, {"g*mm2/s2", 1e-9}};
const Units moments_per_width = {{"N", 1.0}, {"gf*cm/cm", kNewtonOfGfCmPerCm}};
const Units percents = {{"%", 1.0}, {"1", 100.0}};
const Units ratios = {{"1", 1.0}, {"%", 0.01}};

[[noreturn]] void refuse(const std::string& place, const std::string& fault) {
  throw std::invalid_argument(place + ": " + fault);
}

double factor_of(const Json& j, const char* key, const Units& units, const std::string& place) {
  std::vector<std::string> known;
  for (const auto& [unit, factor] : units) known.push_back(unit);
  const std::string list = fmt::format("{}", fmt::join(known, ", "));
  if (!j.contains(key) || !j[key].is_string())
    refuse(place, fmt::format("has no \"{}\"; give one of {}", key, list));
  const auto unit = j[key].get<std::string>();
  const auto found = units.find(unit);
  if (found == units.end())
    refuse(place, fmt::format("\"{}\" is not a unit of this quantity; give one of {}", unit, list));
  return found->second;
}

double number_in(const Json& j, const std::string& key, const std::string& place) {
  if (!j.contains(key) || !j[key].is_number())
    refuse(place, fmt::format("has no number \"{}\"", key));
  const auto value = j[key].get<double>();
  if (!(value >= 0.0) || !std::isfinite(value))
    refuse(place, fmt::format("\"{}\" must not be negative, but is {:g}", key, value));
  return value;
}

void refuse_unknown(const Json& j, const std::set<std::string>& known, const std::string& place) {
  for (const auto& [key, value] : j.items())
    if (!known.contains(key))
      refuse(place, fmt::format("the key \"{}\" is not known; nearest is \"{}\"", key,
                                nearest_word(key, {known.begin(), known.end()})));
}

/// One fabric of a file.
class FabricReader {
 public:
  FabricReader(const Json& j, std::string place) : j_(j), place_(std::move(place)) {}

  Fabric read(Fabric fabric) {
    if (!j_.is_object()) refuse(place_, "is not a JSON object");
    fabric.kind = text("kind", "constants");
    fabric.description = text("description", "");
    fabric.source = text("source", fabric.source);
    if (fabric.source.empty())
      refuse(place_, "has no \"source\"; name the publication or laboratory");
    try {
      convert(fabric);
    } catch (const std::invalid_argument& error) {
      const std::string what = error.what();
      if (what.starts_with(place_)) throw;
      refuse(place_, what);
    }
    return fabric;
  }

 private:
  using Known = std::set<std::string>;

  void allow(const Known& keys) const {
    Known all = keys;
    all.insert({"kind", "description", "source", "drape_coefficient", "friction"});
    refuse_unknown(j_, all, place_);
  }

  void convert(Fabric& fabric) {
    if (fabric.kind == "constants") return read_constants(fabric);
    if (fabric.kind == "kes") return read_kes(fabric);
    if (fabric.kind == "fast") return read_fast(fabric);
    if (fabric.kind == "cantilever") return read_cantilever(fabric);
    if (fabric.kind == "drape") return read_drape(fabric);
    refuse(place_, fmt::format("there is no kind \"{}\"; give constants, kes, fast, cantilever or "
                               "drape",
                               fabric.kind));
  }

  std::string text(const char* key, const std::string& otherwise) const {
    if (!j_.contains(key)) return otherwise;
    if (!j_[key].is_string()) refuse(place_, fmt::format("\"{}\" must be a text", key));
    return j_[key].get<std::string>();
  }

  std::string at(const std::string& key) const { return place_ + "." + key; }

  const Json& object(const std::string& key) const {
    if (!j_.contains(key)) refuse(place_, fmt::format("has no \"{}\"", key));
    if (!j_[key].is_object())
      refuse(at(key), "must be an object with \"value\" (or \"warp\", \"weft\") and \"unit\"");
    return j_[key];
  }

  double value(const std::string& key, const Units& units) const {
    const Json& j = object(key);
    refuse_unknown(j, {"value", "unit"}, at(key));
    return factor_of(j, "unit", units, at(key)) * number_in(j, "value", at(key));
  }

  std::optional<double> maybe(const std::string& key, const Units& units) const {
    if (!j_.contains(key)) return std::nullopt;
    return value(key, units);
  }

  /// A single value counts for both yarns.
  WarpWeft pair(const std::string& key, const Units& units) const {
    const Json& j = object(key);
    if (j.contains("value")) {
      const double both = value(key, units);
      return {both, both};
    }
    refuse_unknown(j, {"warp", "weft", "unit"}, at(key));
    const double factor = factor_of(j, "unit", units, at(key));
    return {factor * number_in(j, "warp", at(key)), factor * number_in(j, "weft", at(key))};
  }

  std::optional<WarpWeft> maybe_pair(const std::string& key, const Units& units) const {
    if (!j_.contains(key)) return std::nullopt;
    return pair(key, units);
  }

  /// A constant of the whole cloth, the mean of the readings for warp and weft. Shear stress is
  /// symmetric, so a sheet has one in-plane shear modulus C33 and one shear loop; warp and weft are
  /// two readings of them, and the energy ½ G φ² is linear in G. HB is one constant, too.
  std::optional<double> maybe_mean(const std::string& key, const Units& units) const {
    const auto both = maybe_pair(key, units);
    if (!both) return std::nullopt;
    return both->mean();
  }

  void finish(Fabric& fabric, FabricConstants constants) const {
    constants.drape_coefficient = maybe("drape_coefficient", percents);
    constants.friction = maybe("friction", ratios);
    fabric.constants = constants;
    fabric.material = material_of(constants);
    fabric.notes = notes_on(constants);
  }

  void read_constants(Fabric& fabric) const {
    allow({"density", "thickness", "stretch", "shear", "bending", "shear_hysteresis",
           "bending_hysteresis", "tension_curve"});
    FabricConstants c;
    c.density = maybe("density", densities);
    c.thickness = maybe("thickness", lengths);
    c.stretch = maybe_pair("stretch", forces_per_width);
    c.shear = maybe_mean("shear", shears);
    c.bending = maybe_pair("bending", rigidities);
    c.shear_hysteresis = maybe_mean("shear_hysteresis", forces_per_width);
    c.bending_hysteresis = maybe_mean("bending_hysteresis", moments_per_width);
    finish(fabric, c);
    if (j_.contains("tension_curve")) read_curve(fabric);
  }

  void read_curve(Fabric& fabric) const {
    const std::string place = at("tension_curve");
    const Json& j = object("tension_curve");
    refuse_unknown(j, {"strain", "strain_unit", "force", "force_unit"}, place);
    TensionCurve curve;
    curve.strain = list(j, "strain", factor_of(j, "strain_unit", ratios, place), place);
    curve.force = list(j, "force", factor_of(j, "force_unit", forces_per_width, place), place);
    try {
      set_tension(curve, fabric.material);
    } catch (const std::invalid_argument& error) {
      refuse(place, error.what());
    }
    std::erase_if(fabric.notes, [](const std::string& n) { return n.starts_with("stretch was"); });
  }

  static std::vector<double> list(const Json& j, const char* key, double factor,
                                  const std::string& place) {
    if (!j.contains(key) || !j[key].is_array())
      refuse(place, fmt::format("has no list \"{}\"", key));
    std::vector<double> values;
    for (const Json& element : j[key]) {
      if (!element.is_number())
        refuse(place, fmt::format("\"{}\" has an element that is not a number", key));
      values.push_back(factor * element.get<double>());
    }
    return values;
  }

  void read_kes(Fabric& fabric) const {
    allow({"W", "LT", "WT", "RT", "EMT", "G", "2HG", "2HG5", "B", "2HB", "T"});
    KesSheet sheet;
    sheet.weight = value("W", densities) / kKgPerM2OfMgPerCm2;
    const WarpWeft extension = pair("EMT", percents);
    sheet.emt = extension.mean();
    sheet.lt = kes_linearity(sheet.emt);
    if (const auto rt = maybe_pair("RT", percents)) {
      for (const double reading : {rt->warp, rt->weft})
        if (!(reading > 0.0 && reading <= 100.0))
          refuse(at("RT"), fmt::format("must be above 0 and at most 100 %, not {:g}", reading));
      sheet.rt = rt->mean();
    }
    sheet.shear = pair("G", shears).mean() / shears.at("gf/(cm*deg)");
    sheet.shear_hysteresis =
        maybe_mean("2HG", forces_per_width).value_or(0.0) / kNewtonPerMetreOfGfPerCm;
    sheet.bending = pair("B", rigidities).mean() / kNewtonMetreOfGfCm2PerCm;
    sheet.bending_hysteresis =
        maybe_mean("2HB", moments_per_width).value_or(0.0) / kNewtonOfGfCmPerCm;
    const Material m = material_of(sheet);
    FabricConstants c;
    c.density = m.density;
    c.thickness = maybe("T", lengths);
    // One curve; its slope at rest follows from the extension of each yarn.
    c.stretch = WarpWeft{m.stretch_stiffness * sheet.emt / extension.warp,
                         m.stretch_stiffness * sheet.emt / extension.weft};
    c.shear = m.shear_stiffness;
    c.bending = pair("B", rigidities);
    c.shear_hysteresis = 2.0 * m.shear_friction;
    c.bending_hysteresis = 2.0 * m.bending_friction;
    finish(fabric, c);
    const double friction = fabric.material.friction;
    const Material yarns = fabric.material;
    fabric.material = m;
    fabric.material.friction = friction;
    fabric.material.stretch_stiffness = yarns.stretch_stiffness;
    fabric.material.stretch_weft = yarns.stretch_weft;
    fabric.material.bending_stiffness = yarns.bending_stiffness;
    fabric.material.bending_weft = yarns.bending_weft;
  }

  /// LT, or what follows from WT (gf·cm/cm²): WT = LT · 500 gf/cm · EMT/2.
  double kes_linearity(double emt) const {
    const Units works = {{"gf*cm/cm2", 1.0}, {"N/m", 1.0 / kNewtonPerMetreOfGfPerCm}};
    const double triangle = 0.5 * kKesEndOfTension * 0.01 * emt;
    const auto lt = maybe_mean("LT", {{"1", 1.0}});
    const auto wt = maybe_mean("WT", works);
    if (!lt && !wt) refuse(place_, "has neither \"LT\" nor \"WT\"; give the tension test");
    if (!lt) return *wt / triangle;
    constexpr double agreement = 0.1;
    if (wt && std::abs(*wt / triangle - *lt) > agreement * *lt)
      refuse(place_, fmt::format("WT and EMT give LT = {:.3f}, but LT is {:.3f}; check their units",
                                 *wt / triangle, *lt));
    return *lt;
  }

  void read_fast(Fabric& fabric) const {
    allow({"W", "C", "E5", "E20", "E100", "EB5", "T2"});
    FastSheet sheet;
    sheet.weight = value("W", densities) / densities.at("g/m2");
    const WarpWeft c = pair("C", lengths);
    sheet.c_warp = c.warp / lengths.at("mm");
    sheet.c_weft = c.weft / lengths.at("mm");
    sheet.e5 = pair("E5", percents);
    sheet.e20 = pair("E20", percents);
    sheet.e100 = pair("E100", percents);
    sheet.eb5 = value("EB5", percents);
    finish(fabric, constants_of(sheet));
  }

  void read_cantilever(Fabric& fabric) const {
    allow({"density", "overhang"});
    const WarpWeft overhang = pair("overhang", lengths);
    finish(fabric,
           constants_of(CantileverTest{overhang.warp, overhang.weft, value("density", densities)}));
  }

  void read_drape(Fabric& fabric) const {
    allow({"density"});
    const double percent = value("drape_coefficient", percents);
    FabricConstants c;
    c.density = value("density", densities);
    const double rigidity = rigidity_of_length(longest_bending_length(percent), *c.density);
    c.bending = WarpWeft{rigidity, rigidity};
    finish(fabric, c);
    fabric.notes.push_back(
        "bending is the largest value that the drape coefficient allows (strips without shear); "
        "`selvedge identify` fits it");
  }

  const Json& j_;
  std::string place_;
};

std::vector<Fabric> fabrics_of(const Json& root, const std::string& file, const std::string& set) {
  if (!root.is_object()) refuse(file, "is not a JSON object");
  std::vector<Fabric> fabrics;
  if (!root.contains("fabrics")) {
    fabrics.push_back(FabricReader(root, file).read({set, "", "", "", {}, {}, {}}));
    return fabrics;
  }
  refuse_unknown(root, {"source", "description", "fabrics"}, file);
  const std::string source = root.value("source", "");
  for (const auto& [name, j] : root["fabrics"].items())
    fabrics.push_back(
        FabricReader(j, file + ", " + name).read({set + "/" + name, "", source, "", {}, {}, {}}));
  if (fabrics.empty()) refuse(file, "has no fabric");
  return fabrics;
}

}  // namespace

std::vector<Fabric> read_fabrics(const std::filesystem::path& file) {
  const std::string name = file.string();
  return fabrics_of(detail::parse_json_file(file).root, name, file.stem().string());
}

Fabric parse_fabric(const std::string& json, const std::string& place) {
  return FabricReader(Json::parse(json), place).read({place, "", "", "", {}, {}, {}});
}

std::vector<Fabric> measured_fabrics() {
  std::vector<Fabric> all;
  for (const auto& [set, text] : detail::fabric_texts())
    for (Fabric& fabric : fabrics_of(Json::parse(text), set, set)) all.push_back(std::move(fabric));
  return all;
}

Fabric find_fabric(const std::string& name, const std::filesystem::path& folder) {
  std::vector<std::string> known;
  for (Fabric& fabric : measured_fabrics()) {
    if (fabric.name == name) return std::move(fabric);
    known.push_back(fabric.name);
  }
  const auto hash = name.rfind('#');
  const std::string wanted = hash == std::string::npos ? "" : name.substr(hash + 1);
  const auto file = (folder / name.substr(0, hash)).lexically_normal();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw std::invalid_argument(
        fmt::format("there is no fabric \"{}\" and no file {}; nearest is \"{}\"", name,
                    file.string(), nearest_word(name, known)));
  std::vector<Fabric> fabrics = read_fabrics(file);
  if (wanted.empty() && fabrics.size() == 1) return std::move(fabrics.front());
  for (Fabric& fabric : fabrics)
    if (!wanted.empty() && fabric.name.ends_with("/" + wanted)) return std::move(fabric);
  throw std::invalid_argument(fmt::format(
      "{} holds {} fabrics; name one as FILE#NAME, such as {}#{}", file.string(), fabrics.size(),
      name.substr(0, hash), fabrics.front().name.substr(file.stem().string().size() + 1)));
}

std::string material_json(const Material& m) {
  const char* const stretch[] = {"hooke",    "tension_only",        "biphasic",
                                 "kawabata", "st_venant_kirchhoff", "corotated"};
  const char* const shear[] = {"springs", "twisting"};
  const char* const bending[] = {"hinge",    "bridson",        "buckling",
                                 "twisting", "shape_operator", "beam"};
  Json json{{"density", m.density},
            {"stretch_stiffness", m.stretch_stiffness},
            {"shear_stiffness", m.shear_stiffness},
            {"bending_stiffness", m.bending_stiffness},
            {"spring_damping", m.spring_damping},
            {"bending_damping", m.bending_damping},
            {"strain_limit", m.strain_limit},
            {"friction", m.friction},
            {"stretch_law", stretch[static_cast<int>(m.stretch_law)]},
            {"shear_law", shear[static_cast<int>(m.shear_law)]},
            {"bending_law", bending[static_cast<int>(m.bending_law)]},
            {"biphasic_strain", m.biphasic_strain},
            {"biphasic_growth", m.biphasic_growth},
            {"kawabata_lt", m.kawabata_lt},
            {"kawabata_strain", m.kawabata_strain},
            {"kawabata_rt", m.kawabata_rt},
            {"shear_friction", m.shear_friction},
            {"bending_friction", m.bending_friction}};
  if (m.stretch_weft) json["stretch_weft"] = *m.stretch_weft;
  if (m.bending_weft) json["bending_weft"] = *m.bending_weft;
  if (m.poisson) json["poisson"] = *m.poisson;
  return json.dump(2);
}

}  // namespace selvedge
