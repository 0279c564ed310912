// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/cloth/fabric.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/scene/detail/fabric_texts.h>
#include <selvedge/scene/detail/field_json.h>
#include <selvedge/scene/detail/scene_json.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>

namespace selvedge {
namespace {

using Json = nlohmann::json;
/// Factors to SI by unit.
using Units = std::map<std::string, double>;

constexpr double per_degree = 180.0 / std::numbers::pi;
constexpr double ounce_per_square_yard = 0.028349523125 / (0.9144 * 0.9144);

/// Everyday names of which no set has a measurement.
const std::set<std::string> kUnmeasured = {"silk", "felt", "leather"};

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
const Units angles = {{"rad", 1.0}, {"deg", 1.0 / per_degree}};
const Units curvatures = {{"1/m", 1.0}, {"1/cm", 100.0}, {"1/mm", 1000.0}};
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

std::string text_in(const Json& j, const char* key, const std::string& otherwise,
                    const std::string& place) {
  if (!j.contains(key)) return otherwise;
  if (!j[key].is_string()) refuse(place, fmt::format("\"{}\" must be a text in quotes", key));
  return j[key].get<std::string>();
}

void refuse_unknown(const Json& j, const std::set<std::string>& known, const std::string& place) {
  for (const auto& [key, value] : j.items())
    if (!known.contains(key))
      refuse(place, fmt::format("the key \"{}\" is not known; nearest is \"{}\"", key,
                                nearest_word(key, {known.begin(), known.end()})));
}

std::string text_of(const std::filesystem::path& file, const std::string& place) {
  try {
    return read_whole_file(file, {.what = "table of two columns"});
  } catch (const std::invalid_argument& fault) {
    refuse(place, fault.what());
  }
}

/// The two columns of a CSV file. Lines that do not begin with a number are its head and remarks.
std::array<std::vector<double>, 2> read_columns(const std::filesystem::path& file,
                                                const std::string& place) {
  std::istringstream in(text_of(file, place));
  std::array<std::vector<double>, 2> columns;
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line.find_first_of("+-.0123456789", begin) != begin) continue;
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    std::istringstream numbers(line);
    double x = 0.0, y = 0.0;
    std::string more;
    if (!(numbers >> x >> y) || numbers >> more)
      refuse(place, fmt::format("{}, line {}: must have two numbers", file.string(), number));
    columns[0].push_back(x);
    columns[1].push_back(y);
  }
  return columns;
}

/// One fabric of a file.
class FabricReader {
 public:
  FabricReader(const Json& j, std::string place, std::filesystem::path folder)
      : j_(j), place_(std::move(place)), folder_(std::move(folder)) {}

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
    if (fabric.kind == "constants") return read_constants(fabric), read_measured(fabric);
    if (fabric.kind == "kes") return read_kes(fabric), read_measured(fabric);
    if (fabric.kind == "fast") return read_fast(fabric);
    if (fabric.kind == "cantilever") return read_cantilever(fabric);
    if (fabric.kind == "drape") return read_drape(fabric);
    refuse(place_, fmt::format("there is no kind \"{}\"; give constants, kes, fast, cantilever or "
                               "drape",
                               fabric.kind));
  }

  std::string text(const char* key, const std::string& otherwise) const {
    return text_in(j_, key, otherwise, place_);
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
           "bending_hysteresis", "tension_curve", "measured_tension", "measured_shear",
           "measured_bending", "bias_tension"});
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

  /// The names and units of a test's two readings.
  struct Test {
    const char* x;
    const Units& x_units;
    const char* y;
    const Units& y_units;
  };

  /// The points of a test, in the sheet or in a CSV file beside it.
  TensionCurve points(const Json& j, const Test& test, const std::string& place,
                      std::initializer_list<const char*> more = {}) const {
    const std::string x_unit = std::string(test.x) + "_unit",
                      y_unit = std::string(test.y) + "_unit";
    std::set<std::string> known{test.x, test.y, x_unit, y_unit, "file"};
    known.insert(more.begin(), more.end());
    if (!j.is_object())
      refuse(place, fmt::format("must be an object with \"{}\", \"{}\" and their "
                                "units, or with a \"file\"",
                                test.x, test.y));
    refuse_unknown(j, known, place);
    const double x_factor = factor_of(j, x_unit.c_str(), test.x_units, place);
    const double y_factor = factor_of(j, y_unit.c_str(), test.y_units, place);
    if (!j.contains("file"))
      return {list(j, test.x, x_factor, place), list(j, test.y, y_factor, place)};
    if (j.contains(test.x) || j.contains(test.y) || !j["file"].is_string())
      refuse(place, "needs the points or the name of a \"file\", not both");
    auto [x, y] = read_columns(folder_ / j["file"].get<std::string>(), place);
    for (double& value : x) value *= x_factor;
    for (double& value : y) value *= y_factor;
    return {std::move(x), std::move(y)};
  }

  MonotoneCurve curve(const Json& j, const Test& test, const std::string& place,
                      std::initializer_list<const char*> more = {}) const {
    const TensionCurve read = points(j, test, place, more);
    try {
      return {read.strain, read.force};
    } catch (const std::invalid_argument& error) {
      refuse(place, error.what());
    }
  }

  /// Calls visit(j, place, along weft) for the curve of both yarns, or for that of each.
  void for_each_yarn(const char* key, const auto& visit) const {
    if (!j_.contains(key)) return;
    const Json& j = j_[key];
    if (!j.is_object() || !j.contains("warp")) return visit(j, at(key), false);
    refuse_unknown(j, {"warp", "weft"}, at(key));
    if (!j.contains("weft")) refuse(at(key), "has \"warp\", but no \"weft\"");
    visit(j["warp"], at(key) + ".warp", false);
    visit(j["weft"], at(key) + ".weft", true);
  }

  /// Curves of the tests themselves, in place of their figures.
  void read_measured(Fabric& fabric) const {
    const Test tension{"strain", ratios, "force", forces_per_width};
    const Test shear{"angle", angles, "force", forces_per_width};
    const Test bending{"curvature", curvatures, "moment", moments_per_width};
    Material& m = fabric.material;
    std::vector<double> returned;
    for_each_yarn("measured_tension", [&](const Json& j, const std::string& place, bool weft) {
      MonotoneCurve& pull = weft ? m.tension_weft : m.tension_curve;
      pull = curve(j, tension, place, {"return"});
      if (!j.contains("return")) return;
      Json release = j["return"];
      if (!release.is_object()) refuse(place + ".return", "must be an object {...}");
      for (const char* unit : {"strain_unit", "force_unit"})
        if (!release.contains(unit)) release[unit] = j[unit];
      returned.push_back(resilience(pull, points(release, tension, place + ".return")));
    });
    if (!returned.empty())
      m.kawabata_rt = std::accumulate(returned.begin(), returned.end(), 0.0) /
                      static_cast<double>(returned.size());
    for_each_yarn("measured_bending", [&](const Json& j, const std::string& place, bool weft) {
      (weft ? m.bending_curve_weft : m.bending_curve) = curve(j, bending, place);
    });
    if (j_.contains("measured_shear"))
      m.shear_curve = curve(j_["measured_shear"], shear, at("measured_shear"));
    set_curves(m);
    if (j_.contains("bias_tension")) {
      if (!m.shear_curve.empty() || j_.contains("shear"))
        refuse(at("bias_tension"), "gives the shear, which another key gives as well; keep one");
      m.shear_curve = shear_of_bias(points(j_["bias_tension"], tension, at("bias_tension")),
                                    {m.stretch_stiffness, stretch_along_weft(m)});
      set_curves(m);
    }
    forget_note(fabric, "stretch was", !m.tension_curve.empty());
    forget_note(fabric, "shear was", !m.shear_curve.empty());
    forget_note(fabric, "bending was", !m.bending_curve.empty());
  }

  static void forget_note(Fabric& fabric, const char* beginning, bool known) {
    if (known)
      std::erase_if(fabric.notes, [&](const std::string& n) { return n.starts_with(beginning); });
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
    allow({"W", "LT", "WT", "RT", "EMT", "G", "2HG", "2HG5", "B", "2HB", "T", "measured_tension",
           "measured_shear", "measured_bending", "bias_tension"});
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
  std::filesystem::path folder_;
};

std::vector<Fabric> fabrics_of(const Json& root, const std::string& file, const std::string& set,
                               const std::filesystem::path& folder) {
  if (!root.is_object()) refuse(file, "is not a JSON object");
  std::vector<Fabric> fabrics;
  if (!root.contains("fabrics")) {
    fabrics.push_back(FabricReader(root, file, folder).read({set, "", "", "", {}, {}, {}}));
    return fabrics;
  }
  refuse_unknown(root, {"source", "description", "fabrics"}, file);
  const std::string source = text_in(root, "source", "", file);
  if (!root["fabrics"].is_object())
    refuse(file + ", fabrics", "must be an object {...} with a fabric for each name");
  for (const auto& [name, j] : root["fabrics"].items())
    fabrics.push_back(FabricReader(j, file + ", " + name, folder)
                          .read({set + "/" + name, "", source, "", {}, {}, {}}));
  if (fabrics.empty()) refuse(file, "has no fabric");
  return fabrics;
}

}  // namespace

std::vector<Fabric> read_fabrics(const std::filesystem::path& file) {
  const std::string name = file.string();
  return fabrics_of(detail::parse_json_file(file, "fabric file").root, name, file.stem().string(),
                    file.parent_path());
}

Fabric parse_fabric(const std::string& json, const std::string& place,
                    const std::filesystem::path& folder) {
  Json parsed;
  try {
    parsed = Json::parse(json);
  } catch (const Json::exception& error) {
    refuse(place, "is not JSON: " + json_message(error.what()));
  }
  return FabricReader(parsed, place, folder).read({place, "", "", "", {}, {}, {}});
}

std::vector<Fabric> measured_fabrics() {
  std::vector<Fabric> all;
  for (const auto& [set, text] : detail::fabric_texts())
    for (Fabric& fabric : fabrics_of(Json::parse(text), set, set, {}))
      all.push_back(std::move(fabric));
  return all;
}

std::map<std::string, std::string> everyday_fabrics() {
  return {{"cotton shirting", "matsudaira_2015/cotton_broad"},
          {"denim", "wang_2011/11oz-black-denim"},
          {"jersey", "wang_2011/gray-interlock"}};
}

Fabric find_fabric(const std::string& name, const std::filesystem::path& folder) {
  std::vector<std::string> known;
  const std::map<std::string, std::string> everyday = everyday_fabrics();
  const auto stands_for = everyday.find(name);
  const std::string& measured = stands_for == everyday.end() ? name : stands_for->second;
  for (Fabric& fabric : measured_fabrics()) {
    if (fabric.name == measured) return std::move(fabric);
    known.push_back(fabric.name);
  }
  for (const auto& [word, fabric] : everyday) known.push_back(word);
  const auto hash = name.rfind('#');
  const std::string wanted = hash == std::string::npos ? "" : name.substr(hash + 1);
  const auto file = (folder / name.substr(0, hash)).lexically_normal();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error) && kUnmeasured.contains(name))
    throw std::invalid_argument(fmt::format(
        "there is no published measurement of {} here; measure yours and write a fabric "
        "file (docs/fabrics.md)",
        name));
  if (!std::filesystem::is_regular_file(file, error))
    throw std::invalid_argument(
        fmt::format("there is no fabric \"{}\" and no file {}; nearest is \"{}\"", name,
                    file.string(), nearest_word(name, known)));
  std::vector<Fabric> fabrics = read_fabrics(file);
  if (wanted.empty() && fabrics.size() == 1) return std::move(fabrics.front());
  for (Fabric& fabric : fabrics)
    if (!wanted.empty() && fabric.name.ends_with("/" + wanted)) return std::move(fabric);
  throw std::invalid_argument(
      fmt::format("{} holds {}; name one as FILE#NAME, such as {}#{}", file.string(),
                  counted(fabrics.size(), "fabric"), name.substr(0, hash),
                  fabrics.front().name.substr(file.stem().string().size() + 1)));
}

std::string material_json(const Material& m) { return detail::json_of(m).dump(2); }

}  // namespace selvedge
