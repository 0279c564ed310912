// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/method_choice.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/apps/detail/record_queries.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/detectors/compare_detectors.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/detector_pictures.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <selvedge/scene/methods.h>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;

struct DetectOptions {
  std::string a0, a1, b0, b1, pictures;
  std::vector<std::string> broad_phase{"all"}, narrow_phase{"ccd_exact"};
  NarrowPhaseConfig config;
  double thickness = 0.0;
  int repeats = 5;
  bool json = false;
  QueryRecorderConfig record;
};

// -- surfaces -------------------------------------------------------------------------------------

/// One surface at two times.
struct MovingSurface {
  std::string file;
  TriangleMesh at_t0, at_t1;
  std::vector<Edge> edges;

  SurfaceView view(double thickness, std::uint64_t id) const {
    const bool at_rest = at_t0.vertices == at_t1.vertices;
    return {at_t0.vertices, at_t1.vertices, edges, at_t0.triangles, thickness, at_rest ? id : 0};
  }
};

void check_same_surface(const std::string& f0, const TriangleMesh& m0, const std::string& f1,
                        const TriangleMesh& m1) {
  constexpr const char* remedy = "give two states of one surface";
  if (m0.vertices.size() != m1.vertices.size())
    throw std::invalid_argument(fmt::format("{}: has {} vertices, and {} has {}; {}", f1,
                                            m1.vertices.size(), f0, m0.vertices.size(), remedy));
  const auto [in_0, in_1] = std::mismatch(m0.triangles.begin(), m0.triangles.end(),
                                          m1.triangles.begin(), m1.triangles.end());
  if (in_0 != m0.triangles.end() || in_1 != m1.triangles.end())
    throw std::invalid_argument(fmt::format("{}: its triangle {} is not that of {}; {}", f1,
                                            in_0 - m0.triangles.begin(), f0, remedy));
}

MovingSurface read_surface(const std::string& f0, const std::string& f1) {
  MovingSurface s{f0, read_mesh(f0), {}, {}};
  s.at_t1 = f1.empty() || f1 == f0 ? s.at_t0 : read_mesh(f1);
  check_same_surface(f0, s.at_t0, f1, s.at_t1);
  s.edges = unique_edges(s.at_t0.triangles);
  return s;
}

// -- results --------------------------------------------------------------------------------------

struct SkippedDetector {
  std::string name, why;
};

struct DetectorResults {
  ReferencePairs reference;
  std::vector<std::pair<std::string, DetectorScore>> detectors;
  std::vector<std::pair<std::string, ContactScore>> contacts;
  std::vector<SkippedDetector> skipped;

  bool failed() const {
    return std::any_of(detectors.begin(), detectors.end(),
                       [](const auto& d) { return !d.second.failure.empty(); });
  }
};

/// A refusal of a method is an error only if the user named it; with "all" it is a note.
template <class Work>
bool serves(const std::string& name, const MethodChoice& choice,
            std::vector<SkippedDetector>& skipped, const Work& work) {
  try {
    work();
    return true;
  } catch (const std::invalid_argument& error) {
    const std::string why = without_name(name, error.what());
    if (!choice.all) throw std::invalid_argument(name + ": " + why);
    skipped.push_back({name, why});
  } catch (const BudgetExceeded& error) {
    skipped.push_back({name, error.what()});
  }
  return false;
}

/// With more tests brute force takes longer than all the others together.
constexpr double kMostTests = 2e9;

void require_service(const BroadPhase& detector, const DetectionCase& c,
                     const MethodChoice& choice) {
  std::string why = why_not(detector.traits(), c);
  if (why.empty() && choice.all && detector.traits().all_pairs && brute_force_tests(c) > kMostTests)
    why = fmt::format("would make {:.0e} box tests; name it to wait for it", brute_force_tests(c));
  if (!why.empty()) throw std::invalid_argument(why);
}

void compare_detectors(const DetectionCase& c, const MethodChoice& choice,
                       const BroadPhaseRegistry& registry, int repeats, DetectorResults& results) {
  std::vector<std::pair<std::string, DetectorTrial>> trials;
  for (const std::string& name : choice.names)
    serves(name, choice, results.skipped, [&] {
      require_service(*registry.at(name)(), c, choice);
      trials.emplace_back(name, DetectorTrial(registry.at(name), c, results.reference));
    });
  // Interleaved, so that a disturbance of the machine meets all of them.
  for (int r = 0; r < repeats; ++r)
    std::erase_if(trials, [&](auto& trial) {
      if (trial.second.slow()) return false;
      return !serves(trial.first, choice, results.skipped, [&] { trial.second.measure(); });
    });
  for (const auto& [name, trial] : trials) results.detectors.emplace_back(name, trial.score());
}

void compare_narrow_phases(const DetectionCase& c, const MethodChoice& choice,
                           const NarrowPhaseRegistry& registry, const DetectOptions& o,
                           DetectorResults& results) {
  for (const std::string& name : choice.names)
    serves(name, choice, results.skipped, [&] {
      const auto method =
          registry.at(name)(narrow_options(registry.at(name).options(), o.config, choice.all));
      results.contacts.emplace_back(name, score_contacts(*method, c, results.reference, o.repeats));
    });
}

Json to_json(const std::optional<ParticleScore>& s) {
  if (!s) return nullptr;
  return {{"reach_m", s->reach},
          {"touching", s->touching},
          {"missed", s->missed},
          {"false_alarms", s->false_alarms},
          {"max_depth_error_m", s->max_depth_error},
          {"mean_depth_error_m", s->mean_depth_error},
          {"max_normal_error_deg", s->max_normal_error}};
}

Json to_json(const std::string& name, const DetectorScore& s) {
  return {{"broad_phase", name},
          {"threads", thread_count()},
          {"build_ms", s.build_ms},
          {"refit_ms", s.refit_ms},
          {"query_ms", s.query_ms},
          {"wall_ms", s.wall_ms},
          {"point_triangle", s.point_triangle},
          {"triangle_point", s.triangle_point},
          {"edge_edge", s.edge_edge},
          {"missed", s.missed},
          {"recall", s.recall},
          {"boxes_missed", s.boxes_missed},
          {"beyond_boxes", s.beyond_boxes},
          {"peak_bytes", s.peak_bytes},
          {"particles", to_json(s.particles)},
          {"failure", s.failure}};
}

Json to_json(const std::string& name, const ContactScore& s) {
  return {{"narrow_phase", name},
          {"contacts", s.contacts},
          {"first_toi", s.first_toi ? Json(*s.first_toi) : Json(nullptr)},
          {"ms", s.ms},
          {"missed", s.missed},
          {"false_alarms", s.false_alarms}};
}

void print_json(const DetectorResults& r) {
  Json detectors = Json::array(), contacts = Json::array(), skipped = Json::array();
  for (const auto& [name, score] : r.detectors) detectors.push_back(to_json(name, score));
  for (const auto& [name, score] : r.contacts) contacts.push_back(to_json(name, score));
  for (const SkippedDetector& s : r.skipped) skipped.push_back({{"name", s.name}, {"why", s.why}});
  const CandidatePairs& boxes = r.reference.boxes;
  const Json reference = {
      {"boxes_from", r.reference.boxes_from},
      {"point_triangle", boxes.point_triangle.size() + boxes.triangle_point.size()},
      {"triangle_point", boxes.triangle_point.size()},
      {"edge_edge", boxes.edge_edge.size()},
      {"colliding", r.reference.colliding.size()}};
  print_document(Json{{"results", detectors},
                      {"contacts", contacts},
                      {"reference", reference},
                      {"skipped", skipped}});
}

void print_detectors(const DetectorResults& r) {
  constexpr double megabyte = 1e6;
  print_escaped("{:<24}{:>11}{:>11}{:>11}{:>13}{:>13}{:>9}{:>9}{:>10}\n", "", "build ms",
                "refit ms", "query ms", "point-tri", "edge-edge", "missed", "recall", "peak MB");
  for (const auto& [name, s] : r.detectors)
    print_escaped("{:<24}{:>11.3f}{:>11.3f}{:>11.3f}{:>13}{:>13}{:>9}{:>9.4f}{:>10.1f}\n", name,
                  s.build_ms, s.refit_ms, s.query_ms, s.point_triangle, s.edge_edge, s.missed,
                  s.recall, static_cast<double>(s.peak_bytes) / megabyte);
  for (const auto& [name, s] : r.detectors)
    if (const auto& p = s.particles)
      print_escaped(
          "{}: {} particles end inside or nearer than {:.3g} m; {} missed, {} false;\n"
          "  distance off by {:.2e} m at most, {:.2e} m in the mean; normal by {:.1f} degrees at "
          "most\n",
          name, p->touching, p->reach, p->missed, p->false_alarms, p->max_depth_error,
          p->mean_depth_error, p->max_normal_error);
  for (const auto& [name, s] : r.detectors)
    if (!s.failure.empty()) print_escaped("FAILURE: {} {}\n", name, s.failure);
}

void print_table(const DetectionCase& c, const DetectorResults& r) {
  print_escaped("{} and {} triangles{}, {} threads\n", c.a.triangles.size(), c.b.triangles.size(),
                c.self ? " of one surface against itself" : "", thread_count());
  const CandidatePairs& boxes = r.reference.boxes;
  print_escaped(
      "overlapping boxes: {} point-triangle, {} edge-edge (by {}); {} of these pairs collide\n\n",
      boxes.point_triangle.size() + boxes.triangle_point.size(), boxes.edge_edge.size(),
      r.reference.boxes_from, r.reference.colliding.size());
  print_detectors(r);
  print_escaped("\n{:<24}{:>11}{:>9}{:>9}{:>24}{:>11}\n", "", "contacts", "missed", "false",
                "first time", "ms");
  for (const auto& [name, s] : r.contacts)
    print_escaped("{:<24}{:>11}{:>9}{:>9}{:>24}{:>11.3f}\n", name, s.contacts, s.missed,
                  s.false_alarms, s.first_toi ? fmt::format("{:.17g}", *s.first_toi) : "-", s.ms);
}

void draw_pictures(const DetectionCase& c, const std::string& folder) {
  for (const auto& [surface, name] : {std::pair(&c.a, "a"), std::pair(&c.b, "b")}) {
    if (c.self && surface == &c.b) break;
    const std::string missing = write_detector_pictures(*surface, folder, name);
    if (!missing.empty()) print_escaped(stderr, "note: pictures of {}: {}\n", name, missing);
  }
}

int run_command(const DetectOptions& o) {
  if (o.b0.empty() && !o.b1.empty()) throw std::invalid_argument("detect: --b1 needs --b0");
  Methods methods = methods_of_this_build();
  const MethodChoice broad = choose_methods(o.broad_phase, methods.broad_phases, "--broad-phase");
  const MethodChoice narrow =
      choose_methods(o.narrow_phase, methods.narrow_phases, "--narrow-phase");
  const MovingSurface a = read_surface(o.a0, o.a1);
  const MovingSurface b = o.b0.empty() ? MovingSurface{} : read_surface(o.b0, o.b1);
  DetectionCase c{a.view(o.thickness, 1), {}, o.b0.empty()};
  c.b = c.self ? c.a : b.view(o.thickness, 2);
  RecordedRun recording(o.record);
  DetectorResults results;
  results.reference = reference_pairs(c);
  if (QueryRecorder* recorder = recording.recorder())
    recorder->add(c.a, c.b, results.reference.boxes);
  recording.write();
  compare_detectors(c, broad, methods.broad_phases, o.repeats, results);
  compare_narrow_phases(c, narrow, methods.narrow_phases, o, results);
  if (!o.pictures.empty()) draw_pictures(c, o.pictures);
  for (const SkippedDetector& s : results.skipped)
    print_escaped(stderr, "note: {} left out: {}\n", s.name, s.why);
  if (o.json)
    print_json(results);
  else
    print_table(c, results);
  return results.failed() ? 1 : 0;
}

void add_meshes(const Command& command, DetectOptions& o) {
  command.option("--a0", o.a0, "The first surface at the start of the step: OBJ, PLY or OFF")
      .required();
  command.option("--a1", o.a1, "The same surface at the end").required();
  command.option("--b0", o.b0,
                 "The second surface at the start; without it, the first surface against "
                 "itself");
  command.option("--b1", o.b1, "The second surface at the end; without it, it is at rest");
}

void add_detect_options(const Command& command) {
  const auto o = std::make_shared<DetectOptions>();
  add_meshes(command, *o);
  command
      .option("--broad-phase", o->broad_phase,
              "Names, separated by commas, or all that support the case (the default)")
      .comma_separated()
      .one_word();
  command
      .option("--narrow-phase", o->narrow_phase,
              "Names, separated by commas, or all (default: ccd_exact)")
      .comma_separated()
      .one_word();
  command
      .option("--thickness", o->thickness,
              "Metres by which each surface's boxes are inflated on each side (default 0)")
      .non_negative();
  command.option("--repeats", o->repeats, "Repeats of each measurement (default 5)").range(1, 1000);
  command.option("--pictures", o->pictures,
                 "Folder for pictures of the data of detectors for each surface: depth, "
                 "normal and index maps of image space, boxes of each level of a tree");
  add_record_options(command, o->record);
  command.flag("--json", o->json, "Print JSON");
  command.footer(
      "Times are medians of interleaved repeats. build and query: the first call of a new\n"
      "detector; refit: the update of its structures in a second call, for the reversed\n"
      "step, which has the same boxes. point-tri counts both directions. missed: colliding\n"
      "pairs (by ccd_exact) that are not among the candidates; recall: the share that is.\n"
      "A detector that answers particles is also compared with exact distances at the end\n"
      "of the step; --thickness sets the distance at which they touch.\n"
      "peak: largest memory above that before the first call, candidates included. Contacts\n"
      "are searched among the overlapping boxes; --record writes these pairs as queries.\n"
      "Exit code: 0 done, 1 a detector broke its guarantee (FAILURE), 2 bad input.");
  command.action([o] { return run_command(*o); });
}

}  // namespace

selvedge::ProgramCommand detect_command() {
  return {.name = "detect",
          .purpose = "Compare detectors on one step of two meshes, or of one mesh against itself",
          .add_options = add_detect_options};
}
