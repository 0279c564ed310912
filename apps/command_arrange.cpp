// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/person_body.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/garment/internal/pattern_files.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;

struct ArrangeOptions {
  std::string pattern, body, out, table, measures, pieces, up;
  std::optional<double> unit;
};

UpAxis pattern_up(const ArrangeOptions& o) {
  return o.up == "x" ? UpAxis::x : o.up == "z" ? UpAxis::z : UpAxis::y;
}

BodyMesh read_body(const ArrangeOptions& o, const std::string& file) {
  LoadConfig config;
  config.unit = o.unit;
  if (!o.up.empty() || !states_axes(file)) config.up = pattern_up(o);
  return read_person(file, config);
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Lines of the form `PANEL = PLACE`.
std::map<std::string, std::string> read_table(const std::string& file) {
  std::map<std::string, std::string> table;
  std::istringstream lines(read_whole_file(file, {.what = "table of panels"}));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    const std::size_t middle = line.find('=');
    if (middle == std::string::npos)
      throw std::invalid_argument(fmt::format(
          "{}: line {}: is not of the form PANEL = PLACE, such as: piece 3 = sleeve.left", file,
          number));
    table[trimmed(line.substr(0, middle))] = trimmed(line.substr(middle + 1));
  }
  return table;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path());
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

/// Millimetres and degrees, under the names of FreeSewing.
int write_measures(const ArrangeOptions& o) {
  if (!o.body.empty() || !o.table.empty() || !o.out.empty())
    throw std::invalid_argument("with --measures, give only BODY");
  const BodyMesh body = read_body(o, o.pattern);
  const BodyLandmarks marks = find_landmarks(body.mesh);
  nlohmann::ordered_json j;
  for (const BodyMeasure& m : body_measures(body.mesh, marks))
    j[m.name] =
        std::round(m.value * (m.is_angle ? 180.0 / std::numbers::pi : 1000.0) * 10.0) / 10.0;
  write_text(o.measures, j.dump(1) + "\n");
  print_escaped("{}", landmark_table(marks));
  print_escaped("{}: {}\n", o.measures, counted(j.size(), "measure"));
  return 0;
}

int run_arrange(const ArrangeOptions& o) {
  if (!o.measures.empty()) return write_measures(o);
  if (o.body.empty()) throw std::invalid_argument("arrange needs PATTERN and BODY");
  ArrangeConfig config;
  if (!o.table.empty()) config.table = read_table(o.table);
  std::vector<std::string> notes;
  const SewingPattern pattern = open_pattern(o.pattern, config, notes);
  const BodyMesh body = read_body(o, o.body);
  const BodyLandmarks marks = find_landmarks(body.mesh);
  const Arrangement arrangement = arrange(pattern, body.mesh, marks, config);
  std::filesystem::path out = o.out;
  if (out.empty()) out = std::filesystem::path("out") / std::filesystem::path(o.pattern).stem();
  out.replace_extension(".json");
  const SewingPattern placed = turned_back(arrangement.pattern, pattern_up(o));
  check_sewing_pattern(placed);
  if (!o.pieces.empty()) write_text(o.pieces, dxf_pattern_text(placed));
  write_text(out, sewing_pattern_text(placed));
  std::filesystem::path drawing = out;
  drawing.replace_extension(".svg");
  write_text(drawing, arrangement_svg(arrangement, body.mesh, marks));
  print_escaped("{}", landmark_table(marks));
  for (const std::string& note : notes) print_escaped("file         {}\n", note);
  print_escaped("{}", arrangement_table(arrangement));
  print_escaped("{}: {}; front and side in {}\n", out.string(),
                counted(placed.panels.size(), "panel"), drawing.string());
  return 0;
}

void add_arrange_options(const Command& command) {
  const auto options = std::make_shared<ArrangeOptions>();
  command
      .option("pattern", options->pattern,
              "Sewing pattern (JSON of GarmentCode, DXF or SVG); with --measures, the body instead")
      .required();
  command.option("body", options->body, "Mesh of the body");
  command.option("--out", options->out,
                 "The pattern with places (default: out/NAME.json); a drawing stands beside it, as "
                 ".svg");
  command.option("--table", options->table,
                 "Places of panels, one in each line: PANEL = front, back, sleeve.left, ...");
  command.option("--dxf", options->pieces,
                 "Also write the panels as pieces in DXF (AAMA/ASTM), with their seams as notes");
  command.option("--measures", options->measures,
                 "Only write the measures of BODY, under the names of FreeSewing (JSON)");
  command
      .option("--up", options->up,
              "Axis of body and pattern that points up (default: y, or what the body's file "
              "states)")
      .one_of({"x", "y", "z"});
  command
      .option("--unit", options->unit,
              "Metres per unit of the body's file (default: what it states, else 1)")
      .positive();
  command.footer("Then: selvedge dress out/NAME.json BODY. `dress --arrange` does both.");
  command.action([options] { return run_arrange(*options); });
}

}  // namespace

selvedge::ProgramCommand arrange_command() {
  return {.name = "arrange",
          .purpose = "Place the panels of a sewing pattern around a body",
          .add_options = add_arrange_options};
}
