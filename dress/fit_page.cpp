// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/dress/detail/fit_page.h>
#include <selvedge/dress/detail/page_style.h>

#include <array>

namespace selvedge::detail {
namespace {

/// How cloth lies around a part of the body.
struct Grade {
  const char* name;
  double least;        // ease over the girth of the body
  const char* swatch;  // sRGB, of the page
  Vec3 colour;         // linear RGB
};
const std::array<Grade, 4>& grades() {
  static const std::array<Grade, 4> list = {{{"loose", 0.15, "#4f86c6", {0.078, 0.238, 0.565}},
                                             {"easy", 0.02, "#3f9b62", {0.050, 0.328, 0.122}},
                                             {"close", -0.02, "#d9a520", {0.694, 0.376, 0.014}},
                                             {"tight", -1.0, "#c8433a", {0.578, 0.056, 0.042}}}};
  return list;
}
const Grade& open_grade() {
  static const Grade grade = {"open", 0.0, "#8a76a8", {0.254, 0.181, 0.392}};
  return grade;
}
const Vec3 kElsewhere(0.60, 0.58, 0.54);  // linear RGB

const Grade& grade_of(const FitZone& zone) {
  if (!zone.is_closed) return open_grade();
  for (const Grade& grade : grades())
    if (zone.ease() >= grade.least * zone.body) return grade;
  return grades().back();
}

std::string row(const FitZone& zone) {
  if (zone.cloth == 0.0)
    return fmt::format("<tr><th>{}</th><td>{:.1f}</td><td colspan=\"7\">no cloth</td></tr>\n",
                       zone.name, 100.0 * zone.body);
  const Grade& grade = grade_of(zone);
  const std::string ease = zone.is_closed ? fmt::format("{:+.1f} ({:+.0f} %)", 100.0 * zone.ease(),
                                                        100.0 * zone.ease() / zone.body)
                                          : "-";
  return fmt::format(
      "<tr><th>{}</th><td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td><td>{}</td><td><span "
      "class=\"swatch\" style=\"background:{}\"></span>{}</td><td>{:.1f}, {:.1f}</td><td>{:.0f}, "
      "{:.0f}</td></tr>\n",
      zone.name, 100.0 * zone.body, 100.0 * zone.cloth, 100.0 * zone.worn, ease, grade.swatch,
      grade.name, 100.0 * zone.strain, 100.0 * zone.strain_max, zone.pressure, zone.pressure_max);
}

std::string pictures(const std::string& name) {
  std::string text;
  for (const char* side : {"front", "back", "left", "right"})
    text += fmt::format(
        "<figure><img src=\"pictures/fit_{0}.png\" alt=\"{1}, {0}\"><figcaption>{0}</figcaption>"
        "</figure>\n",
        side, name);
  return text;
}

constexpr const char* kPage = R"(<!doctype html>
<!-- SPDX-License-Identifier: MIT -->
<html lang="en">
<head>
%STYLE%<title>%NAME%: fit</title>
<style>
.views { display: grid; grid-template-columns: repeat(auto-fit, minmax(14rem, 1fr)); gap: .6rem; }
figure { margin: 0; }
figure img { width: 100%; height: auto; border-radius: .3rem; }
figcaption, .soft { color: var(--soft); font-size: .9rem; }
.table { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { padding: .25rem .8rem .25rem 0; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th:first-child { text-align: left; }
td:nth-child(6) { text-align: left; }
.swatch { display: inline-block; width: .8rem; height: .8rem; margin-right: .4rem; border-radius: .15rem; }
</style>
</head>
<body>
<h1>%NAME%</h1>
<p>%VERDICT%</p>
<div class="views">
%VIEWS%</div>
<div class="table"><table>
<tr><th>zone</th><th>body, cm</th><th>garment, cm</th><th>as worn, cm</th><th>ease, cm</th><th></th><th>strain, mean and largest, %</th><th>pressure, mean and largest, Pa</th></tr>
%ROWS%</table></div>
<p class="soft">Body and as worn: a taut tape. Garment: its length around in the flat pattern. Ease: garment less body. Loose: ease of
at least 15 % of the body; easy: 2 %; close: -2 %; tight: less; open: no ring. Strain and pressure: within 3 cm of the tape.
Left and right are the wearer's.</p>
</body>
</html>
)";

}  // namespace

std::vector<Vec3> fit_colours(const DressResult& r) {
  std::vector<Vec3> colours(r.garment.triangles.size(), kElsewhere);
  for (const FitZone& zone : r.fit)
    for (const std::int32_t i : zone.triangles)
      colours[static_cast<std::size_t>(i)] = grade_of(zone).colour;
  return colours;
}

std::string fit_page(const std::string& pattern_name, const DressResult& r) {
  const std::string name = html_escaped(pattern_name), verdict = html_escaped(r.verdict());
  std::string rows;
  for (const FitZone& zone : r.fit) rows += row(zone);
  if (rows.empty()) rows = "<tr><th>The zones of the body were not found.</th></tr>\n";
  const std::string views = pictures(name);
  const PagePart parts[] = {{"%STYLE%", kPageStyle},
                            {"%NAME%", name},
                            {"%VERDICT%", verdict},
                            {"%VIEWS%", views},
                            {"%ROWS%", rows}};
  return filled_page(kPage, parts);
}

}  // namespace selvedge::detail
