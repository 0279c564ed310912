// SPDX-License-Identifier: MIT
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/tests/grips.h>

#include <selvedge/bodies/driven_body.h>
#include <selvedge/scene/build.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

namespace selvedge {
namespace {

using std::numbers::pi;

// Numbers that are the same with every standard library.
class GripDraw {
 public:
  explicit GripDraw(unsigned seed) : generator_(seed) {}
  double operator()(double low, double high, const char* name) {
    const double value = low + static_cast<double>(generator_()) / 4294967296.0 * (high - low);
    char part[64];
    std::snprintf(part, sizeof part, "%s%s %.4g", text_.empty() ? "" : ", ", name, value);
    text_ += part;
    return value;
  }
  const std::string& text() const { return text_; }

 private:
  std::mt19937 generator_;
  std::string text_;
};

/// The jaws: boxes of one size on both sides of the plane y = 0, turned about x by `tilt`.
struct Jaws {
  Vec3 size = Vec3::Zero(), centre = Vec3::Zero();  // m
  double tilt = 0.0;                                // rad
  double open = 0.0, left = 0.0, right = 0.0;       // m, rooms on each side: open, closed
  double shear = 0.0;                               // m, of the first jaw along z, after closing
  double taller = 0.0;                              // m, by how much the second is taller
};

Mat3 turn(const Jaws& jaws) {
  return Eigen::AngleAxisd(jaws.tilt, Vec3::UnitX()).toRotationMatrix();
}

/// Centre of a jaw with this room on its side, +1 or -1.
Vec3 jaw_centre(const Jaws& jaws, int side, double room) {
  return jaws.centre + turn(jaws) * Vec3(0.0, side * (room + 0.5 * jaws.size.y()), 0.0);
}

std::vector<Keyframe> jaw_motion(const GripScene& grip, const Jaws& jaws, int side) {
  const Vec3 axis = turn(jaws) * Vec3::UnitY() * side, down = turn(jaws) * Vec3(0, 0, -jaws.shear);
  const double in = jaws.open - (side > 0 ? jaws.left : jaws.right);
  const Vec3 shut = -in * axis, shorn = side > 0 ? Vec3(shut + down) : shut;
  std::vector<Keyframe> keys{{.time = 0.0}, {.time = grip.closed, .translation = shut}};
  if (grip.kind == GripKind::held) return keys;
  keys.push_back({.time = grip.released + 0.05, .translation = shut});
  keys.push_back({.time = grip.parts, .translation = shorn});
  keys.push_back({.time = grip.parts + grip.closed, .translation = shorn + in * axis});
  return keys;
}

void add_jaws(GripScene& grip, const Jaws& jaws, std::array<double, 2> friction) {
  for (const int side : {1, -1}) {
    BodySpec body;
    body.name = side > 0 ? "left" : "right";
    const Vec3 more(0.0, 0.0, side > 0 ? 0.0 : jaws.taller);
    body.shape = BodyShape{Box{jaws.size + more}, 8};
    body.placement.translation = jaw_centre(jaws, side, jaws.open);
    body.placement.rotation = Eigen::AngleAxisd(jaws.tilt, Vec3::UnitX());
    body.motion = jaw_motion(grip, jaws, side);
    body.friction = friction[side > 0 ? 0 : 1];
    grip.jaws.push_back(body);
  }
}

/// Both jaws as one body: its mesh is that of the two.
BodySpec joined(const std::vector<BodySpec>& jaws) {
  TriangleMesh mesh;
  for (const BodySpec& body : jaws) {
    const TriangleMesh part = tessellate(std::get<BodyShape>(body.shape).shape, 8);
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (const Vec3& p : part.vertices)
      mesh.vertices.push_back(body.placement.rotation * p + body.placement.translation);
    for (const Triangle& t : part.triangles)
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  BodySpec both;
  both.name = "jaws";
  both.friction = jaws.front().friction;
  BodyFile file;
  file.mesh = mesh;
  both.shape = file;
  return both;
}

void add_sheet(Scene& scene, double width, double height, double cell) {
  ClothSpec spec;
  spec.name = "cloth";
  ClothGrid grid;
  grid.grid = {width, height, std::max(2, static_cast<int>(std::lround(width / cell))),
               static_cast<int>(std::lround(height / cell))};
  spec.shape = grid;
  spec.placement.rotation = Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX());
  Material material;
  material.density = 0.2;
  material.stretch_stiffness = 3000.0;
  material.bending_stiffness = 1e-5;
  scene.materials["default"] = material;
  scene.cloths.push_back(spec);
}

std::vector<std::int32_t> row(const Scene& scene, bool top) {
  const GridConfig& g = std::get<ClothGrid>(scene.cloths[0].shape).grid;
  std::vector<std::int32_t> all;
  for (std::int32_t i = 0; i <= g.cells_x; ++i)
    all.push_back(i + (top ? g.cells_y * (g.cells_x + 1) : 0));
  return all;
}

/// Positions of a jaw, relative to the start, at a time.
Vec3 jaw_shift(const BodySpec& jaw, double time) { return pose_at(jaw.motion, time).translation; }

/// Vertices of the body that has both jaws.
std::vector<Vec3> joined_at(const GripScene& grip, std::span<const Vec3> start, double time) {
  std::vector<Vec3> x(start.begin(), start.end());
  const std::size_t half = x.size() / 2;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += jaw_shift(grip.jaws[i < half ? 0 : 1], time);
  return x;
}

/// Where the jaws have taken a vertex since `from`.
Vec3 led(const GripScene& grip, double from, double to) {
  const auto shift = [&](int jaw) {
    return Vec3(jaw_shift(grip.jaws[jaw], to) - jaw_shift(grip.jaws[jaw], from));
  };
  return grip.leads < 0 ? Vec3(0.5 * (shift(0) + shift(1))) : shift(grip.leads);
}

double jaw_speed(const GripScene& grip, double from, double to) {
  double most = 0.0;
  for (const BodySpec& jaw : grip.jaws)
    most = std::max(most, (jaw_shift(jaw, to) - jaw_shift(jaw, from)).norm() / (to - from));
  return most;
}

/// What is noted from step to step.
class GripNotes {
 public:
  GripNotes(const GripScene& grip, GripOutcome& outcome) : grip_(grip), outcome_(outcome) {}

  void note(const Simulation& simulation, const SimulationState& before) {
    const SimulationState& state = simulation.state();
    if (grip_.kind == GripKind::held)
      for (const Vec3& p : state.x) outcome_.bent = std::max(outcome_.bent, std::abs(p.y()));
    else
      note_held(state);
    for (const Pinch& pinch : before.pinches)
      if (!holds(state, pinch.vertex)) note_freed(state, before, pinch.vertex);
  }

 private:
  static bool holds(const SimulationState& state, std::int32_t vertex) {
    return std::any_of(state.pinches.begin(), state.pinches.end(),
                       [&](const Pinch& p) { return p.vertex == vertex; });
  }
  void note_held(const SimulationState& state) {
    if (state.time < grip_.released) return;
    if (since_ < 0.0) {
      since_ = state.time;
      held_ = state;
      outcome_.pinched = static_cast<int>(state.pinches.size());
    }
    if (state.time < grip_.parts) {
      for (const Pinch& p : held_.pinches)
        outcome_.slipped = std::max(
            outcome_.slipped,
            (state.x[p.vertex] - held_.x[p.vertex] - led(grip_, since_, state.time)).norm());
    }
  }
  // With the velocity of the step before, which the jaws gave it.
  void note_freed(const SimulationState& state, const SimulationState& before, std::int32_t v) {
    const double h = state.time - before.time;
    const double jaws = std::max(jaw_speed(grip_, before.time, state.time),
                                 jaw_speed(grip_, before.time - h, before.time));
    const double speed = before.v[v].norm();
    if (speed > 0.0) outcome_.freed = std::max(outcome_.freed, speed / jaws);
  }

  const GripScene& grip_;
  GripOutcome& outcome_;
  double since_ = -1.0;
  SimulationState held_;
};

}  // namespace

const char* grip_name(GripKind kind) {
  constexpr const char* names[] = {"held", "closed", "towel", "shears"};
  return names[static_cast<int>(kind)];
}

GripScene make_grip(GripKind kind, bool one_body, unsigned seed) {
  GripDraw draw(seed);
  GripScene grip;
  grip.kind = kind;
  grip.one_body = one_body && kind != GripKind::shears;
  Scene& scene = grip.scene;
  scene.name = "grip";
  const bool held = kind == GripKind::held;
  const double gap = scene.contact.rest_gap = draw(0.0015, 0.0025, "rest gap");
  const double cell = draw(0.004, 0.006, "cell");
  const double width =
      kind == GripKind::towel ? draw(0.08, 0.12, "width") : draw(0.03, 0.05, "width");
  const double height = draw(0.08, 0.12, "height");
  add_sheet(scene, width, height, cell);
  Jaws jaws;
  const double tall = draw(0.012, 0.03, "tall");
  jaws.size = Vec3(width * draw(0.6, 1.5, "jaw width"), 0.02, tall);
  const double top = 0.5 * height;
  jaws.centre.z() = held ? top - tall * draw(-0.1, 0.45, "below the top")
                         : top - draw(0.01, 0.03, "below the top") - 0.5 * tall;
  jaws.open = 3.0 * gap;
  const double room = held ? gap * draw(0.1, 1.0, "room") : -gap * draw(0.0, 0.4, "overlap");
  const double share = draw(0.35, 0.65, "share");
  jaws.left = share * room;
  jaws.right = room - jaws.left;
  const double steepest = held ? 0.2 * room / tall : 0.1;
  jaws.tilt = steepest * draw(-1.0, 1.0, "tilt");
  if (kind == GripKind::shears) {
    jaws.shear = draw(-0.2, 0.2, "shear") * tall;
    jaws.taller = tall;
  }
  const double mu = draw(0.1, 0.8, "friction");
  const double other = kind == GripKind::shears ? 0.5 * mu : mu;
  grip.leads = kind == GripKind::shears ? 0 : -1;
  grip.closed = draw(0.2, 0.5, "closed at");
  grip.released = grip.closed + 0.1;
  grip.parts = grip.released + 0.4;
  grip.end = held ? grip.closed + 0.3 : grip.parts + grip.closed + 0.3;
  add_jaws(grip, jaws, {mu, other});
  if (grip.one_body)
    scene.bodies = {joined(grip.jaws)};
  else
    scene.bodies = grip.jaws;
  HandleSpec handle;
  handle.name = "top";
  handle.geometry = "cloth";
  handle.vertices = row(scene, true);
  if (!held) handle.release = grip.released;
  scene.handles.push_back(handle);
  WeightSpec weight;
  weight.name = "load";
  weight.geometry = "cloth";
  weight.vertices = row(scene, false);
  weight.mass = draw(0.0, 0.02, "load") / static_cast<double>(weight.vertices.size());
  scene.weights.push_back(weight);
  if (!held) scene.contact.carry_tangled = true;
  scene.time.frames = static_cast<int>(std::ceil(grip.end * scene.time.fps));
  grip.text = draw.text();
  return grip;
}

GripOutcome grip(const GripScene& grip) {
  GripOutcome outcome;
  BuiltScene built = build_scene(grip.scene);
  DrivenBody* driven = grip.one_body ? &drive_body(built, 0) : nullptr;
  Simulation simulation(grip.scene, std::move(built));
  const std::vector<Vec3> start = simulation.body_positions();
  GripNotes notes(grip, outcome);
  double told = 0.0;
  try {
    while (!simulation.reached(grip.scene.time.frames)) {
      if (const double next = simulation.nominal_end(); driven != nullptr && next > told) {
        simulation.move_body(*driven, joined_at(grip, start, next));
        told = next;
      }
      const SimulationState before = simulation.state();
      simulation.step_towards(grip.scene.time.frames);
      notes.note(simulation, before);
    }
    simulation.verify_frame();
  } catch (const SimulationFailed& failure) {
    outcome.stopped = failure.what();
  }
  outcome.result = simulation.result();
  outcome.stretch = outcome.result.max_stretch;
  double highest = -1.0;
  for (const Vec3& p : simulation.state().x) highest = std::max(highest, p.z());
  const auto& jaw = grip.jaws.front();
  outcome.fallen = jaw.placement.translation.z() - highest;
  return outcome;
}

std::string grip_fault(const GripScene& grip, const GripOutcome& o) {
  constexpr double most_stretch = 0.005, most_slip = 1e-9;
  if (!o.stopped.empty()) return o.stopped;
  if (grip.kind == GripKind::held) {
    if (!o.result.clean) return "not clean";
    if (o.stretch >= most_stretch) return "stretched";
    return o.bent > grip.scene.contact.rest_gap ? "bent" : "";
  }
  if (!o.result.clean_elsewhere) return "crossings elsewhere";
  if (o.pinched == 0) {
    const auto inside = o.result.counters.find("max_held_inside_bodies");
    if (inside == o.result.counters.end() || inside->second == 0.0) return "not pinched";
    return "not pinched, a jaw runs over " + std::to_string(static_cast<int>(inside->second)) +
           " held vertices";
  }
  if (o.slipped > most_slip) return "let go";
  if (o.freed > 1.0 + 1e-9) return "thrown";
  if (o.result.tangle.pairs > 0 || o.result.tangle.until_s < 0.0) return "still tangled";
  return o.fallen > 0.1 ? "" : "not free";
}

}  // namespace selvedge
