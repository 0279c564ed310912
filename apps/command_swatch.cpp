// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/lab/fabric_drape.h>
#include <selvedge/scene/fabric_file.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct SwatchOptions {
  SwatchTrial trial;
  std::vector<int> weave = {1, 1, 1};
  std::vector<double> tex = {20.0, 20.0};
  bool knit = false, json = false;
  std::vector<double> sett{};  ///< 1/m, of warp and weft, or wales and courses; empty: the usual
};

constexpr std::array kTests{
    std::pair{"warp", SwatchPull::warp}, std::pair{"weft", SwatchPull::weft},
    std::pair{"bias", SwatchPull::bias}, std::pair{"shear", SwatchPull::shear}};

using SwatchCurves = std::array<std::vector<SwatchPoint>, kTests.size()>;

SwatchTrial trial_of(const SwatchOptions& o) {
  SwatchTrial trial = o.trial;
  WeaveConfig& w = trial.weave;
  w.over = o.weave[0];
  w.under = o.weave[1];
  w.step = o.weave[2];
  w.weft = w.warp;
  w.warp.tex = o.tex[0];
  w.weft.tex = o.tex[1];
  if (!o.sett.empty()) trial.ends = o.sett[0], trial.picks = o.sett[1];
  return trial;
}

bool is_plain(const SwatchTrial& t) { return t.weave.over == 1 && t.weave.under == 1; }

Json to_json(const SwatchTrial& t, const SwatchCurves& curves) {
  Json json{{"crimp", {t.crimp().warp, t.crimp().weft}}};
  if (is_plain(t)) json["closed_form_modulus"] = {t.plain_modulus().warp, t.plain_modulus().weft};
  json["closed_form_shear"] = t.shear_modulus();
  for (std::size_t k = 0; k < kTests.size(); ++k) {
    Json& test = json["tests"][kTests[k].first] = {{"initial_modulus", initial_modulus(curves[k])}};
    for (const SwatchPoint& p : curves[k]) {
      test["strain"].push_back(p.strain);
      test["force"].push_back(p.force);
      test["contraction"].push_back(p.contraction);
    }
  }
  json["material"] = Json::parse(material_json(material_of(t, curves[0], curves[1], curves[3])));
  return json;
}

void print_report(const SwatchTrial& t, const SwatchCurves& curves) {
  const WeaveConfig& w = t.weave;
  const WarpWeft crimp = t.crimp(), bending = t.bending();
  print_escaped("weave {}/{} step {}: yarns of {:.3f} and {:.3f} mm, crimp {:.1f} and {:.1f} %\n",
                w.over, w.under, w.step, 1e3 * w.warp.diameter(), 1e3 * w.weft.diameter(),
                100.0 * crimp.warp, 100.0 * crimp.weft);
  print_escaped("  density            {:.4g} kg/m2\n", t.density());
  print_escaped("  bending_stiffness  {:.4g} N*m along warp, {:.4g} N*m along weft\n", bending.warp,
                bending.weft);
  print_escaped("  initial modulus, N/m, by the test and in closed form:\n");
  for (std::size_t k = 0; k < kTests.size(); ++k) {
    std::string closed;
    if (kTests[k].second == SwatchPull::shear) closed = fmt::format("{:.4g}", t.shear_modulus());
    if (k < 2 && is_plain(t))
      closed = fmt::format("{:.4g}", k == 0 ? t.plain_modulus().warp : t.plain_modulus().weft);
    print_escaped("    {:<6}{:>10.4g}  {}\n", kTests[k].first, initial_modulus(curves[k]), closed);
  }
  print_escaped("  strain (rad), force (N/m) of");
  for (const auto& [name, pull] : kTests) print_escaped(" {},", name);
  print_escaped("\n");
  for (std::size_t i = 0; i < curves[0].size(); ++i) {
    for (const auto& curve : curves)
      print_escaped("{:>10.4f}{:>10.4g}", curve[i].strain, curve[i].force);
    print_escaped("\n");
  }
}

KnitTrial knit_of(const SwatchOptions& o) {
  KnitTrial knit;
  knit.knit.yarn = trial_of(o).weave.warp;
  knit.knit.links = o.trial.weave.links;
  if (!o.sett.empty()) knit.wales = o.sett[0], knit.courses = o.sett[1];
  knit.loops = o.trial.crossings;
  knit.strain = o.trial.strain;
  knit.points = o.trial.points;
  return knit;
}

void run_knit(const SwatchOptions& o) {
  const KnitTrial knit = knit_of(o);
  const KnitTest course = pull_knit(knit, KnitPull::course), wale = pull_knit(knit, KnitPull::wale);
  if (o.json) {
    Json json{{"loop_length", knit.loop().length()},
              {"tightness", knit.tightness()},
              {"density", knit.density()}};
    for (const auto& [name, test] : {std::pair{"course", &course}, std::pair{"wale", &wale}})
      for (const SwatchPoint& p : test->curve) {
        json["tests"][name]["strain"].push_back(p.strain);
        json["tests"][name]["force"].push_back(p.force);
        json["tests"][name]["contraction"].push_back(p.contraction);
      }
    print_document(json);
    return;
  }
  print_escaped("plain knit: yarn of {:.3f} mm, loops of {:.3f} mm, tightness {:.1f}\n",
                1e3 * knit.knit.yarn.diameter(), 1e3 * knit.loop().length(), knit.tightness());
  print_escaped("  density            {:.4g} kg/m2\n", knit.density());
  print_escaped("  strain, force (N/m) and contraction along courses, along wales\n");
  for (std::size_t i = 0; i < course.curve.size(); ++i)
    print_escaped("{:>10.4f}{:>10.4g}{:>10.4f}{:>10.4g}{:>10.4f}\n", course.curve[i].strain,
                  course.curve[i].force, course.curve[i].contraction, wale.curve[i].force,
                  wale.curve[i].contraction);
  print_escaped("  strain of the yarn at the end: {:.2g} and {:.2g}\n", course.yarn_strain,
                wale.yarn_strain);
}

void run_command(const SwatchOptions& o) {
  if (o.knit) return run_knit(o);
  const SwatchTrial trial = trial_of(o);
  SwatchCurves curves;
  for (std::size_t k = 0; k < kTests.size(); ++k) curves[k] = pull_swatch(trial, kTests[k].second);
  if (o.json)
    print_document(to_json(trial, curves));
  else
    print_report(trial, curves);
}

void add_swatch_options(const Command& command) {
  const auto o = std::make_shared<SwatchOptions>();
  SwatchTrial& t = o->trial;
  command.flag("--knit", o->knit, "Test a plain knit of the first yarn instead of a weave");
  command
      .option("--weave", o->weave,
              "A warp yarn floats over so many weft yarns, then under so many, shifted by so many "
              "from yarn to yarn: plain 1 1 1, twill 2 1 1, satin 4 1 2")
      .words(3);
  command.option("--tex", o->tex, "Linear density of warp and weft yarns, g/km").words(2);
  command
      .option("--sett", o->sett,
              "Warp and weft yarns per metre; of a knit, wales and courses per metre")
      .positive()
      .words(2);
  command.option("--modulus", t.weave.warp.modulus, "Young's modulus of the yarns, Pa").positive();
  command.option("--links", t.weave.links, "Links of a yarn between two crossings, an even number")
      .range(2, 100);
  command.option("--crossings", t.crossings, "Yarns along each side of the swatch").range(8, 200);
  command.option("--strain", t.strain, "Strain, and angle of shear in rad, at the end")
      .range(1e-6, 0.5);
  command.option("--points", t.points, "Steps of strain").range(2, 1000);
  command.flag("--json", o->json, "Print JSON, with the material of a scene");
  command.action([o] {
    run_command(*o);
    return 0;
  });
}

}  // namespace

selvedge::ProgramCommand swatch_command() {
  return {.name = "swatch",
          .purpose = "Compute the constants of a weave or a plain knit from its yarns",
          .add_options = add_swatch_options};
}
