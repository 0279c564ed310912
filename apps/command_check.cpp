// SPDX-License-Identifier: MIT
#include "command_check.h"

#include <fmt/format.h>
#include <selvedge/apps/detail/counted.h>
#include <selvedge/apps/detail/progress_bar.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/resources.h>
#include <selvedge/judge/judge.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct CheckOptions {
  std::vector<std::string> meshes, against;
  std::string rest, next, against_next;
  bool path = false, json = false;
  int threads = 0;
};

/// A mesh and where it came from; no file and no triangles where an option was not given.
struct NamedMesh {
  std::string file;
  TriangleMesh mesh;
};

/// The verdict on one mesh: on its state and, if requested, on the path to the next one.
struct Finding {
  std::string file;
  Verdict state;
  std::optional<PathVerdict> path;
  /// Intersections that the run did not report: of triangles without a vertex flagged as tangled.
  std::size_t unflagged = 0;
  bool taken_over = false;  ///< by a refined mesh, in the next state

  bool wrong() const {
    const bool collides = path && path->self_collisions + path->body_collisions > 0;
    return state.self_intersections + state.body_intersections + state.inside_vertices > 0 ||
           collides;
  }
};

bool has_own_reader(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".obj" || extension == ".ply" || extension == ".off";
}

// Our own readers keep every number of the file; other formats, mostly of bodies, go through the
// general loader.
NamedMesh read(const std::string& file) {
  if (file.empty()) return {};
  return {file, has_own_reader(file) ? read_mesh(file) : load_mesh(file)};
}

bool is_folder(const std::string& file) {
  std::error_code ignored;  // an unreadable path fails with a message when it is read
  return std::filesystem::is_directory(file, ignored);
}

void check_options(const CheckOptions& o) {
  for (const std::string& mesh : o.meshes)
    if (is_folder(mesh) && (o.meshes.size() > 1 || o.path || !o.against.empty() || !o.next.empty()))
      throw std::invalid_argument(
          mesh +
          ": is a folder; a result folder is checked alone, without --against, --next and "
          "--path, because it contains its bodies and its paths");
  if (o.against.size() > 1 && o.against.size() != o.meshes.size())
    throw std::invalid_argument(
        fmt::format("check: --against names {} bodies for {} meshes; give one body for all or one "
                    "for each, after the meshes",
                    o.against.size(), o.meshes.size()));
  if (!o.next.empty() && (o.meshes.size() > 1 || o.path))
    throw std::invalid_argument(
        "check: --next goes with a single MESH; use --path for the paths between several");
  if (!o.against_next.empty() && (o.next.empty() || o.against.empty()))
    throw std::invalid_argument("check: --against-next needs --next and --against");
  if (o.path && o.meshes.size() < 2)
    throw std::invalid_argument("check: --path needs at least two MESH files, in order of time");
}

// Messages of the judge name "mesh", "body" and "rest mesh"; the user needs the files.
[[noreturn]] void throw_with_files(const std::invalid_argument& error, const NamedMesh& mesh,
                                   const NamedMesh& body, const std::string& rest) {
  std::string files = mesh.file;
  if (!body.file.empty()) files += " against " + body.file;
  if (!rest.empty()) files += " with rest mesh " + rest;
  throw std::invalid_argument(files + ": " + error.what());
}

Verdict judge_state(const NamedMesh& mesh, const NamedMesh& body, const NamedMesh& rest) {
  try {
    return judge(mesh.mesh, body.mesh, rest.mesh);
  } catch (const std::invalid_argument& error) {
    throw_with_files(error, mesh, body, rest.file);
  }
}

void check_same_triangles(const NamedMesh& a, const NamedMesh& b) {
  if (a.mesh.vertices.size() != b.mesh.vertices.size() || a.mesh.triangles != b.mesh.triangles)
    throw std::invalid_argument(
        fmt::format("{}: its triangles are not those of {}, so there is no path between them; give "
                    "two states of one surface",
                    b.file, a.file));
}

/// Whether a state is the one before it with more vertices in its surface and none moved: a
/// refined mesh takes over. There is no path between them.
bool takes_over(const NamedMesh& before, const NamedMesh& after) {
  const std::vector<Vec3>&x = before.mesh.vertices, &y = after.mesh.vertices;
  return y.size() > x.size() && std::equal(x.begin(), x.end(), y.begin());
}

/// A state of the mesh and where the body is then.
struct StateView {
  const NamedMesh &mesh, &body;
};

PathVerdict judge_between(const StateView& from, const StateView& to) {
  check_same_triangles(from.mesh, to.mesh);
  check_same_triangles(from.body, to.body);
  try {
    return judge_path(from.mesh.mesh, to.mesh.mesh.vertices, from.body.mesh, to.body.mesh.vertices);
  } catch (const std::invalid_argument& error) {
    throw_with_files(error, from.mesh, from.body, "");
  }
}

Json to_json(const Finding& finding) {
  const Verdict& v = finding.state;
  Json json = {{"vertices", v.vertices},
               {"triangles", v.triangles},
               {"self_intersections", v.self_intersections},
               {"body_intersections", v.body_intersections},
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

void print_json(const std::vector<Finding>& findings) {
  if (findings.size() == 1) {
    fmt::print("{}\n", to_json(findings.front()).dump(2));
    return;
  }
  Json results = Json::array();
  for (const Finding& finding : findings) {
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

void print_report(const Finding& finding, const CheckOptions& o) {
  const Verdict& v = finding.state;
  fmt::print("{}: {} vertices, {} triangles\n", finding.file, v.vertices, v.triangles);
  fmt::print("  self-intersections    {}{}\n", v.self_intersections, pair_list(v.first_self));
  if (!o.against.empty()) {
    fmt::print("  body intersections    {}{}\n", v.body_intersections, pair_list(v.first_body));
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

void print_line(const Finding& finding, const CheckOptions& o) {
  const Verdict& v = finding.state;
  std::string line = fmt::format("{}: {} self", finding.file, v.self_intersections);
  if (!o.against.empty())
    line += fmt::format(", {} body, {} inside, {:.6g} m deep", v.body_intersections,
                        v.inside_vertices, v.max_penetration_m);
  if (!o.rest.empty())
    line += fmt::format(", stretch {:.3f} %, compression {:.3f} %", 100.0 * v.max_stretch,
                        100.0 * v.max_compression);
  if (finding.path)
    line += fmt::format(", path {} self, {} body", finding.path->self_collisions,
                        finding.path->body_collisions);
  fmt::print("{}\n", line);
  std::fflush(stdout);  // a long list is read while it grows
}

struct State {
  NamedMesh mesh, body;

  operator StateView() const { return {mesh, body}; }
};

/// Reads the states one after another, so that a long list needs the memory of two.
class Check {
 public:
  explicit Check(const CheckOptions& options) : o_(options), rest_(read(options.rest)) {}

  /// Returns whether something is wrong.
  bool run() {
    State state = read_state(0);
    for (std::size_t i = 0; i < o_.meshes.size(); ++i) {
      std::optional<State> next;
      if (i + 1 < o_.meshes.size()) next = read_state(i + 1);
      judge_one(state, o_.path ? next : next_option(state));
      if (next) state = std::move(*next);
    }
    if (o_.json) print_json(findings_);
    return std::any_of(findings_.begin(), findings_.end(),
                       [](const Finding& finding) { return finding.wrong(); });
  }

 private:
  State read_state(std::size_t i) {
    const std::string body = o_.against.empty()      ? ""
                             : o_.against.size() > 1 ? o_.against[i]
                                                     : o_.against.front();
    if (body != body_.file) body_ = read(body);
    return {read(o_.meshes[i]), body_};
  }

  std::optional<State> next_option(const State& state) {
    if (o_.next.empty()) return std::nullopt;
    return State{read(o_.next), o_.against_next.empty() ? state.body : read(o_.against_next)};
  }

  void judge_one(const State& state, const std::optional<State>& next) {
    Finding finding{state.mesh.file, judge_state(state.mesh, state.body, rest_), std::nullopt};
    if (next) finding.path = judge_between(state, *next);
    if (!o_.json && o_.meshes.size() == 1) print_report(finding, o_);
    if (!o_.json && o_.meshes.size() > 1) print_line(finding, o_);
    findings_.push_back(std::move(finding));
  }

  const CheckOptions& o_;
  NamedMesh rest_, body_;  // the body read last: most lists have one for all
  std::vector<Finding> findings_;
};

/// The worst of each number over all states of a result, and the sum of all that collides between
/// them.
struct ResultFinding {
  Finding worst;
  std::size_t states = 0, paths = 0, taken_over = 0;
  std::string first_wrong;  ///< file of the first state at fault or with a path at fault, or ""
  std::string last_wrong;   ///< of the last one
};

void take_worse(const Verdict& v, Verdict& worst) {
  worst.vertices = std::max(worst.vertices, v.vertices);
  worst.triangles = std::max(worst.triangles, v.triangles);
  worst.self_intersections = std::max(worst.self_intersections, v.self_intersections);
  worst.body_intersections = std::max(worst.body_intersections, v.body_intersections);
  worst.inside_vertices = std::max(worst.inside_vertices, v.inside_vertices);
  worst.max_penetration_m = std::max(worst.max_penetration_m, v.max_penetration_m);
  worst.max_stretch = std::max(worst.max_stretch, v.max_stretch);
  worst.max_compression = std::max(worst.max_compression, v.max_compression);
}

ResultFinding summary_of(const std::string& folder, const std::vector<Finding>& findings) {
  ResultFinding sum{{folder, {}, std::nullopt, 0, false}, findings.size(), 0, 0, "", ""};
  for (const Finding& finding : findings) {
    take_worse(finding.state, sum.worst.state);
    sum.worst.unflagged = std::max(sum.worst.unflagged, finding.unflagged);
    if (finding.wrong()) sum.last_wrong = finding.file;
    if (finding.wrong() && sum.first_wrong.empty()) sum.first_wrong = finding.file;
    sum.taken_over += finding.taken_over ? 1 : 0;
    if (!finding.path) continue;
    if (!sum.worst.path) sum.worst.path.emplace();
    ++sum.paths;
    sum.worst.path->pairs += finding.path->pairs;
    sum.worst.path->self_collisions += finding.path->self_collisions;
    sum.worst.path->body_collisions += finding.path->body_collisions;
  }
  return sum;
}

void print_json(const ResultFinding& sum) {
  Json json = to_json(sum.worst);
  json["states"] = sum.states;
  json["paths"] = sum.paths;
  json["refinements"] = sum.taken_over;
  json["first_wrong"] = sum.first_wrong;
  json["last_wrong"] = sum.last_wrong;
  json["unflagged_intersections"] = sum.worst.unflagged;
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_report(const ResultFinding& sum, const CheckOptions& o, bool every_step) {
  const Verdict& v = sum.worst.state;
  fmt::print(
      "{}: {}\n", sum.worst.file,
      every_step
          ? fmt::format("{} and {} from each to the next", counted(sum.states, "accepted state"),
                        counted(sum.paths, "path"))
          : fmt::format("{}; `run --every-step` writes every state", counted(sum.states, "frame")));
  fmt::print("  worst self-intersections    {}\n", v.self_intersections);
  fmt::print("  worst body intersections    {}\n", v.body_intersections);
  fmt::print("  most vertices inside        {}\n", v.inside_vertices);
  fmt::print("  largest penetration         {:.6g} m\n", v.max_penetration_m);
  if (!o.rest.empty())
    fmt::print("  largest stretch             {:.3f} %\n  largest compression         {:.3f} %\n",
               100.0 * v.max_stretch, 100.0 * v.max_compression);
  if (sum.worst.path)
    fmt::print("  collisions on paths         {} self, {} body, {} pairs decided\n",
               sum.worst.path->self_collisions, sum.worst.path->body_collisions,
               sum.worst.path->pairs);
  if (sum.taken_over > 0) fmt::print("  refined meshes took over    {} times\n", sum.taken_over);
  if (sum.first_wrong.empty()) return;
  fmt::print("  first at fault              {}\n", sum.first_wrong);
  fmt::print("  last at fault               {}\n", sum.last_wrong);
  fmt::print("  without a flagged vertex    {} intersections at most\n", sum.worst.unflagged);
}

/// Checks the states of a result in parallel. Each is read where it is checked, so that a long
/// run needs the memory of two states a thread.
class ResultCheck {
 public:
  explicit ResultCheck(const CheckOptions& options)
      : o_(options),
        files_(result_states(options.meshes.front())),
        rest_(read(options.rest)),
        bar_("state", static_cast<int>(files_.states.size())) {
    const auto& states = files_.states;
    if (states.front().bodies == states.back().bodies)
      resting_body_ = read(states.front().bodies.string());
  }

  /// Returns whether something is wrong.
  bool run() {
    const std::vector<Finding> findings = judge_all();
    bar_.clear();
    const ResultFinding sum = summary_of(o_.meshes.front(), findings);
    if (o_.json)
      print_json(sum);
    else
      print_report(sum, o_, files_.every_step);
    return !sum.first_wrong.empty();
  }

 private:
  std::vector<Finding> judge_all() {
    const std::size_t n = files_.states.size();
    std::vector<Finding> findings(n);
    // If several states cannot be checked, the message names the first one, for any order of the
    // threads.
    std::vector<std::exception_ptr> errors(n);
    parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        try {
          findings[i] = judge_one(i);
        } catch (const std::exception&) {
          errors[i] = std::current_exception();
        }
        count_one();
      }
    });
    for (const std::exception_ptr& error : errors)
      if (error) std::rethrow_exception(error);
    return findings;
  }

  Finding judge_one(std::size_t i) const {
    const State state = read_state(i);
    const StateView from = view(state);
    Finding finding{from.mesh.file, judge_state(from.mesh, from.body, rest_), std::nullopt};
    const std::size_t found = finding.state.self_intersections + finding.state.body_intersections;
    if (found > 0) finding.unflagged = unflagged(from);
    if (!files_.every_step || i + 1 == files_.states.size()) return finding;
    const State next = read_state(i + 1);
    if (takes_over(from.mesh, view(next).mesh))
      finding.taken_over = true;
    else
      finding.path = judge_between(from, view(next));
    return finding;
  }

  /// Intersections of the triangles that have no vertex flagged as tangled by the run.
  std::size_t unflagged(const StateView& state) const {
    std::vector<NamedValues> values;
    NamedMesh rest{state.mesh.file, read_ply(state.mesh.file, values)};
    for (const NamedValues& flags : values) {
      if (flags.name != "flag") continue;
      const auto tangled = [&](std::int32_t v) {
        return (static_cast<int>(flags.values[v]) & kFlagTangled) != 0;
      };
      std::erase_if(rest.mesh.triangles,
                    [&](const Triangle& t) { return std::any_of(t.begin(), t.end(), tangled); });
    }
    const Verdict verdict = judge_state(rest, state.body, NamedMesh{});
    return verdict.self_intersections + verdict.body_intersections;
  }

  /// A body that rests is read once, for all.
  State read_state(std::size_t i) const {
    const ResultState& files = files_.states[i];
    return {read(files.cloth.string()), resting_body_ ? NamedMesh{} : read(files.bodies.string())};
  }

  StateView view(const State& state) const {
    return {state.mesh, resting_body_ ? *resting_body_ : state.body};
  }

  void count_one() {
    const std::lock_guard<std::mutex> lock(counting_);
    bar_.show(++judged_, watch_.seconds());
  }

  const CheckOptions& o_;
  const ResultStates files_;
  const NamedMesh rest_;
  std::optional<NamedMesh> resting_body_;
  const Stopwatch watch_;
  std::mutex counting_;
  int judged_ = 0;
  ProgressBar bar_;
};

}  // namespace

void add_command_check(const Command& app) {
  auto o = std::make_shared<CheckOptions>();
  const Command command =
      app.subcommand("check",
                     "Check meshes of any program exactly: intersections, penetration, "
                     "strain, collisions on paths");
  command
      .option("MESH", o->meshes,
              "OBJ, PLY or OFF files (several: one line each), or the result folder of "
              "a run: every state and path of steps/, or every frame if there is no "
              "steps/")
      .required();
  command.option("--against", o->against, "The body, or one body for each MESH");
  command.option("--rest", o->rest,
                 "Rest shape: a mesh with the same triangles, from which strain is "
                 "measured");
  command.option("--next", o->next, "Also check the straight path from MESH to this mesh");
  command.option("--against-next", o->against_next, "The body at the end of the path");
  command.flag("--path", o->path, "Also check the straight path from each MESH to the next");
  command.flag("--json", o->json, "Print JSON");
  command
      .option("--threads", o->threads,
              "Threads for a result folder; 0: all (the answer is the same)")
      .range(0, 1024);
  command.footer(
      "Exit code: 0 nothing found; 1 an intersection, a vertex inside the body "
      "or a collision; 2 bad input.");
  command.action([o] {
    check_options(*o);
    const ThreadLimit limit(o->threads);
    const bool wrong = is_folder(o->meshes.front()) ? ResultCheck(*o).run() : Check(*o).run();
    return wrong ? 1 : 0;
  });
}
