// SPDX-License-Identifier: MIT
#include <selvedge/run/check_result.h>

#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <cctype>
#include <exception>
#include <filesystem>
#include <mutex>
#include <stdexcept>

namespace selvedge {
namespace {

/// A mesh and its file; no file and no triangles if there is no mesh.
struct NamedMesh {
  std::string file;
  TriangleMesh mesh;
};

struct State {
  NamedMesh mesh, body;
};

/// A state of the mesh with the body at its time.
struct StateView {
  const NamedMesh &mesh, &body;
};

StateView view(const State& state) { return {state.mesh, state.body}; }

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

// Messages of the judge name "mesh", "body" and "rest mesh"; the user needs the files.
[[noreturn]] void throw_with_files(const std::invalid_argument& error, const StateView& state,
                                   const std::string& rest) {
  std::string files = state.mesh.file;
  if (!state.body.file.empty()) files += " against " + state.body.file;
  if (!rest.empty()) files += " with rest mesh " + rest;
  throw std::invalid_argument(files + ": " + error.what());
}

Verdict judge_state(const StateView& state, const NamedMesh& rest) {
  try {
    return judge(state.mesh.mesh, state.body.mesh, rest.mesh);
  } catch (const std::invalid_argument& error) {
    throw_with_files(error, state, rest.file);
  }
}

void check_same_triangles(const NamedMesh& a, const NamedMesh& b) {
  if (a.mesh.vertices.size() != b.mesh.vertices.size() || a.mesh.triangles != b.mesh.triangles)
    throw std::invalid_argument(
        fmt::format("{}: its triangles are not those of {}, so there is no path between them; give "
                    "two states of one surface",
                    b.file, a.file));
}

PathVerdict judge_between(const StateView& from, const StateView& to) {
  check_same_triangles(from.mesh, to.mesh);
  check_same_triangles(from.body, to.body);
  try {
    return judge_path(from.mesh.mesh, to.mesh.mesh.vertices, from.body.mesh, to.body.mesh.vertices);
  } catch (const std::invalid_argument& error) {
    throw_with_files(error, from, "");
  }
}

/// Whether `after` is `before` with more vertices and triangles, and none moved: a refined mesh
/// takes over. The new vertices of a piece come after its old ones, so before those of the pieces
/// and bodies that follow it.
bool is_refined(const NamedMesh& before, const NamedMesh& after) {
  const std::vector<Vec3>& x = before.mesh.vertices;
  if (after.mesh.vertices.size() <= x.size() ||
      after.mesh.triangles.size() <= before.mesh.triangles.size())
    return false;
  std::size_t found = 0;
  for (const Vec3& y : after.mesh.vertices)
    if (found < x.size() && y == x[found]) ++found;
  return found == x.size();
}

/// The vertex of `after` that each vertex of `before` becomes, if `after` is `before` with merged
/// vertices; else empty. Vertices of no triangle become 0.
std::vector<std::int32_t> merged_vertices(const TriangleMesh& before, const TriangleMesh& after) {
  if (after.vertices.size() >= before.vertices.size() ||
      after.triangles.size() != before.triangles.size())
    return {};
  std::vector<std::int32_t> becomes(before.vertices.size(), -1);
  for (std::size_t t = 0; t < before.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      std::int32_t& v = becomes[before.triangles[t][k]];
      if (v >= 0 && v != after.triangles[t][k]) return {};
      v = after.triangles[t][k];
    }
  std::replace(becomes.begin(), becomes.end(), -1, 0);
  return becomes;
}

/// The path on which vertices come together and become one.
PathVerdict judge_merge(const StateView& from, const StateView& to,
                        std::span<const std::int32_t> becomes) {
  check_same_triangles(from.body, to.body);
  std::vector<Vec3> end;
  for (const std::int32_t v : becomes) end.push_back(to.mesh.mesh.vertices[v]);
  try {
    return judge_path(from.mesh.mesh, end, from.body.mesh, to.body.mesh.vertices, becomes);
  } catch (const std::invalid_argument& error) {
    throw_with_files(error, from, "");
  }
}

/// Intersections of the triangles that have no vertex flagged as tangled by the run.
std::size_t unflagged_intersections(const StateView& state) {
  std::vector<NamedValues> values;
  NamedMesh rest{state.mesh.file, read_ply(state.mesh.file, values)};
  for (const NamedValues& flags : values) {
    if (flags.name != "flag") continue;
    const auto tangled = [&](std::int32_t v) {
      constexpr double kByte = 256.0;  // a file of another program may hold any number
      const double flag = flags.values[v];
      return flag >= 0.0 && flag < kByte && (static_cast<int>(flag) & kFlagTangled) != 0;
    };
    std::erase_if(rest.mesh.triangles,
                  [&](const Triangle& t) { return std::any_of(t.begin(), t.end(), tangled); });
  }
  const Verdict verdict = judge_state({rest, state.body}, NamedMesh{});
  return verdict.self_intersections + verdict.body_intersections;
}

/// Reads the states of a list one after another.
class ListReader {
 public:
  explicit ListReader(const MeshList& list) : list_(list) {}

  State state(std::size_t i) {
    const std::string body = list_.against.empty()      ? ""
                             : list_.against.size() > 1 ? list_.against.at(i)
                                                        : list_.against.front();
    if (body != body_.file) body_ = read(body);
    return {read(list_.meshes[i]), body_};
  }

  /// The end of the path from a single mesh, if the list has one.
  std::optional<State> next(const State& state) const {
    if (list_.next.empty()) return std::nullopt;
    return State{read(list_.next),
                 list_.against_next.empty() ? state.body : read(list_.against_next)};
  }

 private:
  const MeshList& list_;
  NamedMesh body_;  // the body read last: most lists have one for all
};

void take_worse(const Verdict& v, Verdict& worst) {
  worst.vertices = std::max(worst.vertices, v.vertices);
  worst.triangles = std::max(worst.triangles, v.triangles);
  worst.self_intersections = std::max(worst.self_intersections, v.self_intersections);
  worst.body_intersections = std::max(worst.body_intersections, v.body_intersections);
  worst.self_touches = std::max(worst.self_touches, v.self_touches);
  worst.body_touches = std::max(worst.body_touches, v.body_touches);
  worst.inside_vertices = std::max(worst.inside_vertices, v.inside_vertices);
  worst.max_penetration_m = std::max(worst.max_penetration_m, v.max_penetration_m);
  worst.max_stretch = std::max(worst.max_stretch, v.max_stretch);
  worst.max_compression = std::max(worst.max_compression, v.max_compression);
}

ResultCheck summary_of(const std::string& folder, const std::vector<CheckFinding>& findings) {
  ResultCheck sum;
  sum.worst.file = folder;
  sum.states = findings.size();
  for (const CheckFinding& finding : findings) {
    take_worse(finding.state, sum.worst.state);
    sum.worst.unflagged = std::max(sum.worst.unflagged, finding.unflagged);
    if (finding.is_faulty()) sum.last_faulty = finding.file;
    if (finding.is_faulty() && sum.first_faulty.empty()) sum.first_faulty = finding.file;
    sum.refinements += finding.refined ? 1 : 0;
    sum.joins += finding.joined ? 1 : 0;
    sum.merges += finding.merged ? 1 : 0;
    if (!finding.path) continue;
    if (!sum.worst.path) sum.worst.path.emplace();
    ++sum.paths;
    sum.worst.path->pairs += finding.path->pairs;
    sum.worst.path->self_collisions += finding.path->self_collisions;
    sum.worst.path->body_collisions += finding.path->body_collisions;
  }
  return sum;
}

/// Checks the states of a result in parallel. Each is read where it is checked, so a long run needs
/// the memory of two states per thread.
class FolderCheck {
 public:
  FolderCheck(const std::string& folder, const std::string& rest,
              const std::function<void(int, int)>& progress)
      : files_(result_states(folder)), rest_(read(rest)), progress_(progress) {
    const auto& states = files_.states;
    if (states.front().bodies == states.back().bodies)
      resting_body_ = read(states.front().bodies.string());
  }

  bool every_step() const { return files_.every_step; }

  std::vector<CheckFinding> findings() {
    const std::size_t n = files_.states.size();
    std::vector<CheckFinding> findings(n);
    // If several states cannot be checked, the message names the first one, for any order of the
    // threads.
    std::vector<std::exception_ptr> errors(n);
    parallel_for(n, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        try {
          findings[i] = finding(i);
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

 private:
  CheckFinding finding(std::size_t i) const {
    const State state = read_state(i);
    const StateView from = at_rest(state);
    CheckFinding finding{.file = from.mesh.file, .state = judge_state(from, rest_), .path = {}};
    if (finding.state.self_intersections + finding.state.body_intersections > 0)
      finding.unflagged = unflagged_intersections(from);
    if (!files_.every_step || i + 1 == files_.states.size()) return finding;
    const State next = read_state(i + 1);
    const std::vector<std::int32_t> becomes = merged_vertices(from.mesh.mesh, next.mesh.mesh);
    finding.refined = is_refined(from.mesh, next.mesh);
    finding.joined = is_refined(next.mesh, from.mesh);
    finding.merged = !becomes.empty();
    if (finding.merged)
      finding.path = judge_merge(from, at_rest(next), becomes);
    else if (!finding.refined && !finding.joined)
      finding.path = judge_between(from, at_rest(next));
    return finding;
  }

  /// A body that rests is read once, for all.
  State read_state(std::size_t i) const {
    const ResultState& files = files_.states[i];
    return {read(files.cloth.string()), resting_body_ ? NamedMesh{} : read(files.bodies.string())};
  }

  StateView at_rest(const State& state) const {
    return {state.mesh, resting_body_ ? *resting_body_ : state.body};
  }

  void count_one() {
    const std::lock_guard<std::mutex> lock(counting_);
    ++checked_;
    if (progress_) progress_(checked_, static_cast<int>(files_.states.size()));
  }

  const ResultStates files_;
  const NamedMesh rest_;
  const std::function<void(int, int)>& progress_;
  std::optional<NamedMesh> resting_body_;
  std::mutex counting_;
  int checked_ = 0;
};

}  // namespace

bool CheckFinding::is_faulty() const {
  const bool collides = path && path->self_collisions + path->body_collisions > 0;
  return state.self_intersections + state.body_intersections + state.inside_vertices > 0 ||
         collides;
}

void check_meshes(const MeshList& list, const std::function<void(const CheckFinding&)>& report) {
  ListReader reader(list);
  const NamedMesh rest = read(list.rest);
  if (list.meshes.empty()) return;
  State state = reader.state(0);
  for (std::size_t i = 0; i < list.meshes.size(); ++i) {
    std::optional<State> following;
    if (i + 1 < list.meshes.size()) following = reader.state(i + 1);
    CheckFinding finding{
        .file = state.mesh.file, .state = judge_state(view(state), rest), .path = {}};
    const std::optional<State> end = list.paths ? following : reader.next(state);
    if (end) finding.path = judge_between(view(state), view(*end));
    report(finding);
    if (following) state = std::move(*following);
  }
}

ResultCheck check_result(const std::string& folder, const std::string& rest,
                         const std::function<void(int done, int of)>& progress) {
  FolderCheck check(folder, rest, progress);
  ResultCheck sum = summary_of(folder, check.findings());
  sum.every_step = check.every_step();
  return sum;
}

}  // namespace selvedge
