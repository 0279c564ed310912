// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/run/check_result.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct CheckOptions {
  MeshList list;
  bool json = false;
};

bool is_folder(const std::string& file) {
  std::error_code ignored;  // an unreadable path fails with a message when it is read
  return std::filesystem::is_directory(file, ignored);
}

void check_options(const MeshList& o) {
  for (const std::string& mesh : o.meshes)
    if (is_folder(mesh) &&
        (o.meshes.size() > 1 || o.paths || !o.against.empty() || !o.next.empty()))
      throw std::invalid_argument(
          mesh +
          ": is a folder; a result folder is checked alone, without --against, --next and "
          "--path, because it contains its bodies and its paths");
  if (o.against.size() > 1 && o.against.size() != o.meshes.size())
    throw std::invalid_argument(
        fmt::format("check: --against names {} bodies for {} meshes; give one body for all or one "
                    "for each, after the meshes",
                    o.against.size(), o.meshes.size()));
  if (!o.next.empty() && (o.meshes.size() > 1 || o.paths))
    throw std::invalid_argument(
        "check: --next goes with a single MESH; use --path for the paths between several");
  if (!o.against_next.empty() && (o.next.empty() || o.against.empty()))
    throw std::invalid_argument("check: --against-next needs --next and --against");
  if (o.paths && o.meshes.size() < 2)
    throw std::invalid_argument("check: --path needs at least two MESH files, in order of time");
}

Json to_json(const CheckFinding& finding) {
  const Verdict& v = finding.state;
  Json json = {{"vertices", v.vertices},
               {"triangles", v.triangles},
               {"self_intersections", v.self_intersections},
               {"body_intersections", v.body_intersections},
               {"self_touches", v.self_touches},
               {"body_touches", v.body_touches},
               {"inside_vertices", v.inside_vertices},
               {"max_penetration_m", v.max_penetration_m},
               {"max_stretch", v.max_stretch},
               {"max_compression", v.max_compression}};
  if (finding.path) {
    json["path_pairs"] = finding.path->pairs;
    json["path_self_collisions"] = finding.path->self_collisions;
    json["path_body_collisions"] = finding.path->body_collisions;
  }
  return json;
}

void print_json(const std::vector<CheckFinding>& findings) {
  if (findings.size() == 1) {
    fmt::print("{}\n", to_json(findings.front()).dump(2));
    return;
  }
  Json results = Json::array();
  for (const CheckFinding& finding : findings) {
    Json result = {{"file", finding.file}};
    result.update(to_json(finding));
    results.push_back(std::move(result));
  }
  // A file name need not be UTF-8.
  fmt::print("{}\n", Json{{"results", std::move(results)}}.dump(2, ' ', false,
                                                                Json::error_handler_t::replace));
}

std::string pair_list(const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  std::string text;
  for (const auto& [a, b] : pairs) text += fmt::format("{}{}-{}", text.empty() ? "" : ", ", a, b);
  return text.empty() ? text : fmt::format("   (triangles {})", text);
}

std::string inside_note(const Verdict& v) {
  if (v.closed_parts == 0) return "   (the body is not closed: it has no inside)";
  return v.open_parts > 0 ? fmt::format("   ({} open parts of the body left out)", v.open_parts)
                          : "";
}

void print_report(const CheckFinding& finding, const MeshList& o) {
  const Verdict& v = finding.state;
  fmt::print("{}: {}, {}\n", printable(finding.file), counted(v.vertices, "vertex", "vertices"),
             counted(v.triangles, "triangle"));
  fmt::print("  self-intersections    {}{}\n", v.self_intersections, pair_list(v.first_self));
  if (v.self_touches > 0)
    fmt::print("  touches itself        {}{}\n", v.self_touches, pair_list(v.first_self_touches));
  if (!o.against.empty()) {
    fmt::print("  body intersections    {}{}\n", v.body_intersections, pair_list(v.first_body));
    if (v.body_touches > 0)
      fmt::print("  touches the body      {}{}\n", v.body_touches, pair_list(v.first_body_touches));
    fmt::print("  vertices inside       {}{}\n", v.inside_vertices, inside_note(v));
    fmt::print("  largest penetration   {:.6g} m\n", v.max_penetration_m);
  }
  if (!o.rest.empty())
    fmt::print("  largest stretch       {:.3f} %\n  largest compression   {:.3f} %\n",
               100.0 * v.max_stretch, 100.0 * v.max_compression);
  if (finding.path)
    fmt::print("  path to the next      {} self-collisions, {} body collisions, {} pairs decided\n",
               finding.path->self_collisions, finding.path->body_collisions, finding.path->pairs);
}

void print_line(const CheckFinding& finding, const MeshList& o) {
  const Verdict& v = finding.state;
  std::string line = fmt::format("{}: {} self", printable(finding.file), v.self_intersections);
  if (!o.against.empty())
    line += fmt::format(", {} body, {} inside, {:.6g} m deep", v.body_intersections,
                        v.inside_vertices, v.max_penetration_m);
  if (v.self_touches + v.body_touches > 0)
    line += fmt::format(", {} touch", counted(v.self_touches + v.body_touches, "pair"));
  if (!o.rest.empty())
    line += fmt::format(", stretch {:.3f} %, compression {:.3f} %", 100.0 * v.max_stretch,
                        100.0 * v.max_compression);
  if (finding.path)
    line += fmt::format(", path {} self, {} body", finding.path->self_collisions,
                        finding.path->body_collisions);
  fmt::print("{}\n", line);
  std::fflush(stdout);  // a long list is read while it grows
}

/// Returns whether something is wrong.
bool check_list(const CheckOptions& o) {
  std::vector<CheckFinding> findings;
  bool faulty = false;
  check_meshes(o.list, [&](const CheckFinding& finding) {
    faulty = faulty || finding.is_faulty();
    if (o.json)
      findings.push_back(finding);
    else if (o.list.meshes.size() == 1)
      print_report(finding, o.list);
    else
      print_line(finding, o.list);
  });
  if (o.json) print_json(findings);
  return faulty;
}

void print_json(const ResultCheck& sum) {
  Json json = to_json(sum.worst);
  json["states"] = sum.states;
  json["paths"] = sum.paths;
  json["refinements"] = sum.refinements;
  json["joins"] = sum.joins;
  json["merges"] = sum.merges;
  json["first_wrong"] = sum.first_faulty;
  json["last_wrong"] = sum.last_faulty;
  json["unflagged_intersections"] = sum.worst.unflagged;
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_report(const ResultCheck& sum, bool strains) {
  const Verdict& v = sum.worst.state;
  fmt::print(
      "{}: {}\n", printable(sum.worst.file),
      sum.every_step
          ? fmt::format("{} and {} from each to the next", counted(sum.states, "accepted state"),
                        counted(sum.paths, "path"))
          : fmt::format("{}; `run --every-step` writes every state", counted(sum.states, "frame")));
  fmt::print("  worst self-intersections    {}\n", v.self_intersections);
  fmt::print("  worst body intersections    {}\n", v.body_intersections);
  if (v.self_touches + v.body_touches > 0)
    fmt::print("  most touches                {} with itself, {} with the bodies\n", v.self_touches,
               v.body_touches);
  fmt::print("  most vertices inside        {}\n", v.inside_vertices);
  fmt::print("  largest penetration         {:.6g} m\n", v.max_penetration_m);
  if (strains)
    fmt::print("  largest stretch             {:.3f} %\n  largest compression         {:.3f} %\n",
               100.0 * v.max_stretch, 100.0 * v.max_compression);
  if (sum.worst.path)
    fmt::print("  collisions on paths         {} self, {} body, {} pairs decided\n",
               sum.worst.path->self_collisions, sum.worst.path->body_collisions,
               sum.worst.path->pairs);
  if (sum.refinements > 0) fmt::print("  refined meshes took over    {} times\n", sum.refinements);
  if (sum.joins > 0) fmt::print("  joined meshes took over     {} times\n", sum.joins);
  if (sum.merges > 0) fmt::print("  vertices became one on       {} of the paths\n", sum.merges);
  if (sum.first_faulty.empty()) return;
  fmt::print("  first at fault              {}\n", sum.first_faulty);
  fmt::print("  last at fault               {}\n", sum.last_faulty);
  fmt::print("  without a flagged vertex    {} intersections at most\n", sum.worst.unflagged);
}

/// Returns whether something is wrong.
bool check_folder(const CheckOptions& o) {
  const Stopwatch watch;
  std::optional<ProgressBar> bar;
  const ResultCheck sum = check_result(o.list.meshes.front(), o.list.rest, [&](int done, int of) {
    if (!bar) bar.emplace("state", of);
    bar->show(done, watch.seconds());
  });
  bar.reset();
  if (o.json)
    print_json(sum);
  else
    print_report(sum, !o.list.rest.empty());
  return !sum.first_faulty.empty();
}

void add_check_options(const Command& command) {
  auto o = std::make_shared<CheckOptions>();
  command
      .option("MESH", o->list.meshes,
              "OBJ, PLY or OFF files (several: one line each), or the result folder of "
              "a run: every state and path of steps/, or every frame if there is no "
              "steps/")
      .required();
  command.option("--against", o->list.against, "The body, or one body for each MESH");
  command.option("--rest", o->list.rest,
                 "Rest shape: a mesh with the same triangles, from which strain is "
                 "measured");
  command.option("--next", o->list.next, "Also check the straight path from MESH to this mesh");
  command.option("--against-next", o->list.against_next, "The body at the end of the path");
  command.flag("--path", o->list.paths, "Also check the straight path from each MESH to the next");
  command.flag("--json", o->json, "Print JSON");
  command.footer(
      "Exit code: 0 nothing found, or triangles that only touch; 1 an intersection, a vertex "
      "inside the body or a collision; 2 bad input.");
  command.action([o] {
    check_options(o->list);
    const bool faulty = is_folder(o->list.meshes.front()) ? check_folder(*o) : check_list(*o);
    return faulty ? 1 : 0;
  });
}

}  // namespace

selvedge::ProgramCommand check_command() {
  return {.name = "check",
          .purpose =
              "Check meshes of any program exactly: intersections, penetration, strain, collisions "
              "on paths",
          .add_options = add_check_options};
}
