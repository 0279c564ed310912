// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/pictures/internal/measure_pictures.h>
#include <selvedge/run/measure_result.h>
#include <selvedge/scene/methods.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct MeasureOptions {
  std::string result, out;
  double support = 0.0;
  std::vector<double> centre;
  bool json = false, pictures = true;
};

MeasureConfig config_of(const MeasureOptions& o) {
  MeasureConfig config{.support_radius = {}, .support_centre = {}};
  if (o.support > 0.0) config.support_radius = o.support;
  if (!o.centre.empty()) config.support_centre = Eigen::Vector2d(o.centre[0], o.centre[1]);
  return config;
}

fs::path output_folder(const MeasureOptions& o) {
  const fs::path out = o.out.empty() ? fs::path(o.result) / "measures" : fs::path(o.out);
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw std::invalid_argument(out.string() + ": cannot be made: " + error.message());
  return out;
}

void print_drape(const DrapeMeasures& d) {
  print_escaped(
      "  drape coefficient    {:.2f} %   (shadow {:.2f} cm2, specimen {:.2f} cm2, support "
      "{:.2f} cm2)\n",
      d.drape_coefficient, 1e4 * d.shadow, 1e4 * d.specimen, 1e4 * d.support);
  print_escaped("  folds                {} (strongest order of the rim, {:.2f} mm), {} maxima\n",
                d.rim.folds, 1e3 * d.rim.amplitude[d.rim.folds], d.rim.maxima);
}

void print_report(const ResultMeasures& m, const fs::path& out) {
  print_escaped("{}, frame {}; tables and pictures in {}\n", m.scene, m.frame, out.string());
  print_escaped("  strain of triangles  {:.3f} to {:.3f} %, rms {:.3f} %\n", 100.0 * m.sheet.min,
                100.0 * m.sheet.max, 100.0 * m.sheet.rms);
  print_escaped("  strain of springs    {:.3f} to {:.3f} %, rms {:.3f} %\n", 100.0 * m.springs.min,
                100.0 * m.springs.max, 100.0 * m.springs.rms);
  for (const auto& [part, joules] : m.joule)
    print_escaped("  energy, {:<17} {:.6g} J\n", part, joules);
  if (m.drape)
    print_drape(*m.drape);
  else
    print_escaped("  no drape coefficient: {}\n",
                  m.support ? "the rim does not go around the support"
                            : "no upright cylinder in the scene; give --support");
}

void run_command(const MeasureOptions& o) {
  const ResultMeasures measures = measure_result(o.result, config_of(o), methods_of_this_build());
  const fs::path out = output_folder(o);
  write_measure_tables(measures, out);
  if (o.pictures) draw_measures(measures, o.result, out);
  const std::string text = measures_text(measures);
  AtomicFile file(out / "measures.json");
  file.write(text);
  file.commit();
  if (o.json)
    print_escaped("{}", text);
  else
    print_report(measures, out);
}

void add_measure_options(const Command& command) {
  const auto o = std::make_shared<MeasureOptions>();
  command.option("RESULT", o->result, "Result folder of a run").required();
  command
      .option("--support", o->support,
              "Radius of the support, m (default: that of the scene's first upright "
              "cylinder)")
      .positive();
  command.option("--centre", o->centre, "Centre of the support, x and y, m").words(2);
  command.option("--out", o->out, "Folder for tables and pictures (default: RESULT/measures)");
  command.flag("--json", o->json, "Print measures.json");
  command.action([o, command] {
    o->pictures = command.pictures();
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand measure_command() {
  return {.name = "measure",
          .purpose =
              "Measure drape coefficient, folds, strains and energies of a result; write tables "
              "and pictures",
          .add_options = add_measure_options};
}
