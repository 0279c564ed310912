// SPDX-License-Identifier: MIT
//
// Scenes from text, and simulations in memory.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/bindings/c/driven_simulation.h>
#include <selvedge/scene/internal/scene_text.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <map>

struct selvedge_scene {
  std::shared_ptr<const selvedge::Scene> scene;
};

struct selvedge_simulation {
  selvedge::bindings::DrivenSimulation simulation;
  std::vector<std::size_t> body_begin;  // of the present mesh of the bodies, which never changes
};

struct selvedge_state {
  selvedge::bindings::SavedState saved;
};

namespace selvedge::c {
namespace {

/// Calls use(simulation) while no other thread may.
template <class Use>
int with(selvedge_simulation* given, const Use& use) noexcept {
  return call([&] {
    bindings::DrivenSimulation& simulation = needed(given, "simulation").simulation;
    const OneThread mine(simulation.busy(), "simulation");
    use(simulation);
  });
}

/// Answers a query about a simulation, or `none` for NULL.
template <class Value, class Query>
Value ask(const selvedge_simulation* given, Value none, const Query& query) {
  return given == nullptr ? none : query(given->simulation.now());
}

const int32_t* triangles_of(std::span<const Triangle> triangles, std::size_t* count) {
  if (count != nullptr) *count = triangles.size();
  return reinterpret_cast<const int32_t*>(triangles.data());
}

/// The numbers of a result by their names in result.json.
std::map<std::string, double> figures_of(const RunResult& result) {
  std::map<std::string, double> figures = result.counters;
  Fields<RunResult>::visit([&](const char* name, auto member, const FieldRule&) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(result.*member)>>)
      figures[name] = static_cast<double>(result.*member);
  });
  return figures;
}

double figure_of(const Simulation& simulation, const char* name) {
  const RunResult result = simulation.result();
  std::map<std::string, double> figures = figures_of(result);
  figures["unchecked"] = result.unchecked.empty() ? 0.0 : 1.0;
  for (const auto& [energy, joule] : simulation.energies()) figures["energy." + energy] = joule;
  return figure_named(name, figures);
}

}  // namespace
}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_scene_create(const char* json, const char* file, selvedge_scene** out) {
  return c::call([&] {
    c::needed(json, "json");
    c::needed(out, "out");
    Scene scene = read_scene_text(json, file == nullptr ? "scene.json" : file);
    *out = new selvedge_scene{std::make_shared<const Scene>(std::move(scene))};
  });
}
void selvedge_scene_free(selvedge_scene* scene) { delete scene; }
const char* selvedge_scene_json(const selvedge_scene* scene) {
  return scene == nullptr ? nullptr : scene->scene->json.c_str();
}
int selvedge_scene_frames(const selvedge_scene* scene) {
  return scene == nullptr ? 0 : scene->scene->time.frames;
}
double selvedge_scene_fps(const selvedge_scene* scene) {
  return scene == nullptr ? 0.0 : scene->scene->time.fps;
}

int selvedge_simulation_create(const selvedge_scene* scene, const size_t* driven,
                               size_t driven_count, selvedge_simulation** out) {
  return c::call([&] {
    c::needed(scene, "scene");
    c::needed(out, "out");
    const std::span<const std::size_t> numbers =
        c::rows<std::size_t>(driven, driven_count, "driven");
    std::unique_ptr<selvedge_simulation> made(
        new selvedge_simulation{{scene->scene, std::make_shared<const Methods>(), numbers}, {}});
    made->body_begin = made->simulation.body_begin();
    *out = made.release();
  });
}
void selvedge_simulation_free(selvedge_simulation* simulation) { delete simulation; }

int selvedge_simulation_step(selvedge_simulation* simulation) {
  return c::with(simulation, [](bindings::DrivenSimulation& s) { s.now().step(); });
}
int selvedge_simulation_advance(selvedge_simulation* simulation, int frame) {
  return c::with(simulation,
                 [&](bindings::DrivenSimulation& s) { s.now().advance_to_frame(frame); });
}

double selvedge_simulation_time(const selvedge_simulation* simulation) {
  return c::ask(simulation, 0.0, [](const Simulation& s) { return s.time(); });
}
int64_t selvedge_simulation_steps(const selvedge_simulation* simulation) {
  return c::ask(simulation, int64_t{0},
                [](const Simulation& s) -> int64_t { return s.state().step; });
}
size_t selvedge_simulation_vertices(const selvedge_simulation* simulation) {
  return c::ask(simulation, size_t{0}, [](const Simulation& s) { return s.positions().size(); });
}
const double* selvedge_simulation_positions(const selvedge_simulation* simulation) {
  return c::ask(simulation, static_cast<const double*>(nullptr),
                [](const Simulation& s) { return s.positions().data()->data(); });
}
const double* selvedge_simulation_velocities(const selvedge_simulation* simulation) {
  return c::ask(simulation, static_cast<const double*>(nullptr),
                [](const Simulation& s) { return s.velocities().data()->data(); });
}
const int32_t* selvedge_simulation_triangles(const selvedge_simulation* simulation, size_t* count) {
  return c::ask(simulation, c::triangles_of({}, count),
                [&](const Simulation& s) { return c::triangles_of(s.cloth_triangles(), count); });
}
size_t selvedge_simulation_bodies(const selvedge_simulation* simulation) {
  return simulation == nullptr ? 0 : simulation->body_begin.size() - 1;
}
size_t selvedge_simulation_body_begin(const selvedge_simulation* simulation, size_t i) {
  if (simulation == nullptr) return 0;
  return simulation->body_begin[std::min(i, simulation->body_begin.size() - 1)];
}
const double* selvedge_simulation_body_positions(const selvedge_simulation* simulation) {
  return c::ask(simulation, static_cast<const double*>(nullptr), [](const Simulation& s) {
    return s.body_positions().empty() ? nullptr : s.body_positions().front().data();
  });
}
const int32_t* selvedge_simulation_body_triangles(const selvedge_simulation* simulation,
                                                  size_t* count) {
  return c::ask(simulation, c::triangles_of({}, count),
                [&](const Simulation& s) { return c::triangles_of(s.body_triangles(), count); });
}

int selvedge_simulation_set_forces(selvedge_simulation* simulation, const double* forces) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    const std::size_t n = forces == nullptr ? 0 : s.now().positions().size();
    s.now().set_forces(c::rows<Vec3>(forces, n, "forces"));
  });
}
int selvedge_simulation_hold(selvedge_simulation* simulation, const int32_t* vertices, size_t n,
                             const double* x) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    s.now().hold(c::rows<std::int32_t>(vertices, n, "vertices"), c::rows<Vec3>(x, n, "x"));
  });
}
int selvedge_simulation_release(selvedge_simulation* simulation, const int32_t* vertices,
                                size_t n) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    if (vertices == nullptr)
      s.now().release_all();
    else
      s.now().release({vertices, n});
  });
}
int selvedge_simulation_move_body(selvedge_simulation* simulation, size_t body, const double* x,
                                  size_t n) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    s.move_body(body, c::rows<Vec3>(x, n, "x"));
  });
}

int selvedge_simulation_contacts(selvedge_simulation* simulation, selvedge_contacts** out) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    c::needed(out, "out");
    c::Contacts lists;
    for (const StepContact& contact : s.now().contacts()) {
      lists.kinds.push_back(static_cast<std::uint8_t>(contact.point.kind));
      lists.corners.push_back(contact.point.vertex);
      lists.shares.push_back(contact.point.weight);
      lists.normals.push_back(contact.point.normal);
      lists.gaps.push_back(contact.gap);
      lists.rest_gaps.push_back(contact.point.rest_gap);
      lists.impulses.push_back(contact.impulse);
    }
    *out = c::Contacts::release(std::move(lists));
  });
}
int selvedge_simulation_figure(selvedge_simulation* simulation, const char* name, double* out) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    c::needed(out, "out") = c::figure_of(s.now(), name);
  });
}
int selvedge_simulation_hash(selvedge_simulation* simulation, char out[17]) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    c::needed(out, "out");
    const std::string hash = state_hash(s.now().state());
    std::copy_n(hash.c_str(), hash.size() + 1, out);
  });
}

int selvedge_simulation_save(selvedge_simulation* simulation, selvedge_state** out) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    selvedge_state*& made = c::needed(out, "out");
    made = new selvedge_state{s.save()};
  });
}
int selvedge_simulation_restore(selvedge_simulation* simulation, const selvedge_state* state) {
  return c::with(simulation, [&](bindings::DrivenSimulation& s) {
    s.restore(c::needed(state, "state").saved);
  });
}
void selvedge_state_free(selvedge_state* state) { delete state; }
