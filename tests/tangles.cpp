// SPDX-License-Identifier: MIT
#include "tangles.h"

#include <selvedge/judge/judge.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation_state.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace selvedge {
namespace {

using std::numbers::pi;

// Numbers that are the same with every standard library.
class Draw {
 public:
  explicit Draw(unsigned seed) : generator_(seed) {}
  double operator()(double low, double high, const char* name) {
    const double share = static_cast<double>(generator_()) / 4294967296.0;
    const double value = low + share * (high - low);
    char part[64];
    std::snprintf(part, sizeof part, "%s%s %.3f", text_.empty() ? "" : ", ", name, value);
    text_ += part;
    return value;
  }
  const std::string& text() const { return text_; }

 private:
  std::mt19937 generator_;
  std::string text_;
};

Scene scene_of(const char* name) {
  Scene scene;
  scene.name = name;
  scene.materials["default"] = Material{};
  scene.contact.untangle_start = true;
  return scene;
}

void add_cloth(Scene& scene, double size_x, double size_y, double cell) {
  ClothSpec spec;
  spec.name = "cloth" + std::to_string(scene.cloths.size());
  ClothGrid grid;
  grid.grid = {size_x, size_y, static_cast<std::int32_t>(std::lround(size_x / cell)),
               static_cast<std::int32_t>(std::lround(size_y / cell))};
  spec.shape = grid;
  scene.cloths.push_back(spec);
}

template <class Map>
void bend(BuiltScene& built, std::size_t piece, Map map) {
  for (std::int32_t i = built.piece_begin[piece]; i < built.piece_begin[piece + 1]; ++i)
    built.cloth.surface.vertices[i] = map(built.cloth.surface.vertices[i]);
}

// A sheet whose bump pokes through the sheet above.
TangledScene bump(Draw& draw) {
  TangledScene t{scene_of("bump"), {}, {}};
  const double cell = draw(0.02, 0.03, "cell"), gap = draw(0.004, 0.02, "gap");
  const double depth = draw(0.005, 0.06, "depth"), width = draw(0.05, 0.09, "width");
  const double x = draw(-0.08, 0.08, "x"), y = draw(-0.08, 0.08, "y");
  add_cloth(t.scene, 0.4, 0.4, cell);
  add_cloth(t.scene, draw(0.3, 0.5, "size"), 0.4, draw(0.02, 0.03, "cell"));
  t.built = build_scene(t.scene);
  bend(t.built, 0, [&](const Vec3& p) {
    const double r2 = std::pow(p.x() - x, 2) + std::pow(p.y() - y, 2);
    return Vec3(p.x(), p.y(), (gap + depth) * std::exp(-r2 / (2.0 * width * width)));
  });
  bend(t.built, 1, [&](const Vec3& p) { return Vec3(p + Vec3(0.003, 0.004, gap)); });
  return t;
}

// Two flat sheets that cross at an angle.
TangledScene layers(Draw& draw) {
  TangledScene t{scene_of("layers"), {}, {}};
  add_cloth(t.scene, 0.4, 0.4, draw(0.02, 0.03, "cell"));
  add_cloth(t.scene, draw(0.2, 0.5, "size"), draw(0.2, 0.5, "size"), draw(0.02, 0.03, "cell"));
  const double angle = draw(5.0, 85.0, "angle") * pi / 180.0;
  const double turn = draw(0.0, 90.0, "turn") * pi / 180.0;
  const Vec3 shift(draw(-0.15, 0.15, "x"), draw(-0.15, 0.15, "y"), draw(-0.03, 0.03, "z"));
  const Mat3 rotation =
      (Eigen::AngleAxisd(turn, Vec3::UnitZ()) * Eigen::AngleAxisd(angle, Vec3::UnitX()))
          .toRotationMatrix();
  t.built = build_scene(t.scene);
  bend(t.built, 1, [&](const Vec3& p) { return Vec3(rotation * p + shift); });
  return t;
}

// A sleeve around an arm that it has partly sunk into.
TangledScene sleeve(Draw& draw) {
  TangledScene t{scene_of("sleeve"), {}, {}};
  const double arm = draw(0.04, 0.07, "arm"), radius = arm + draw(0.005, 0.03, "ease");
  const double length = draw(0.15, 0.35, "length"), cell = draw(0.015, 0.025, "cell");
  const double depth = draw(0.003, 0.05, "depth"), tilt = draw(-0.2, 0.2, "tilt");
  const double open = draw(0.02, 0.06, "seam"), round = 2.0 * pi * radius - open;
  add_cloth(t.scene, round, length, cell);
  BodySpec body;
  body.name = "arm";
  body.shape = BodyShape{Capsule{arm, 0.5}, 24};
  body.placement.rotation = Eigen::AngleAxisd(0.5 * pi, Vec3::UnitX());
  t.scene.bodies.push_back(body);
  const double sink = radius - arm + depth, along = draw(0.0, 6.28, "towards");
  t.built = build_scene(t.scene);
  bend(t.built, 0, [&](const Vec3& p) {
    const double a = p.x() / radius;
    const Vec3 q(radius * std::sin(a) + sink * std::sin(along), p.y(),
                 radius * std::cos(a) - sink * std::cos(along));
    return Vec3(Eigen::AngleAxisd(tilt, Vec3::UnitX()) * q);
  });
  return t;
}

// A sheet whose corner is rolled over and comes out through the sheet.
TangledScene corner(Draw& draw) {
  TangledScene t{scene_of("corner"), {}, {}};
  add_cloth(t.scene, 0.4, 0.4, draw(0.018, 0.028, "cell"));
  const double radius = draw(0.01, 0.02, "radius"),
               angle = draw(210.0, 265.0, "angle") * pi / 180.0;
  // Long enough for the tip to come down to the sheet again, and through it.
  const double to_sheet = radius * (angle - (1.0 - std::cos(angle)) / std::sin(angle));
  const double fold = to_sheet + draw(0.01, 0.06, "depth");
  const double way = draw(20.0, 70.0, "direction") * pi / 180.0;
  const Vec3 out(std::cos(way), std::sin(way), 0.0), across(-out.y(), out.x(), 0.0);
  t.built = build_scene(t.scene);
  const double rim = out.dot(Vec3(0.2, 0.2, 0.0)) - fold;  // where the sheet leaves its plane
  bend(t.built, 0, [&](const Vec3& p) {
    const double s = out.dot(p) - rim;
    if (s <= 0.0) return p;
    const double a = std::min(s / radius, angle), rest = s - a * radius;
    const double forth = rim + radius * std::sin(a) + rest * std::cos(a);
    return Vec3(forth * out + across.dot(p) * across +
                (radius * (1.0 - std::cos(a)) + rest * std::sin(a)) * Vec3::UnitZ());
  });
  return t;
}

TriangleMesh part_of(std::span<const Vec3> x, std::span<const Triangle> triangles,
                     std::span<const char> left_out) {
  TriangleMesh mesh{{x.begin(), x.end()}, {}};
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (left_out.empty() || !left_out[i]) mesh.triangles.push_back(triangles[i]);
  return mesh;
}

struct Snapshot {
  std::vector<Vec3> cloth, body;
};

// Crossings and collisions among the triangles that are not left out.
std::size_t faults(const Simulation& s, const Snapshot& from, const Snapshot& to,
                   std::span<const char> left_out) {
  const std::size_t m = s.cloth_triangles().size();
  const auto cloth_out = left_out.empty() ? left_out : left_out.first(m);
  const auto body_out = left_out.empty() ? left_out : left_out.subspan(m);
  const TriangleMesh cloth = part_of(from.cloth, s.cloth_triangles(), cloth_out);
  const TriangleMesh body = part_of(from.body, s.body_triangles(), body_out);
  const Verdict verdict = judge({to.cloth, cloth.triangles}, {to.body, body.triangles}, {});
  const PathVerdict path = judge_path(cloth, to.cloth, body, to.body);
  return verdict.self_intersections + verdict.body_intersections + path.self_collisions +
         path.body_collisions;
}

// A pair is in no tangle if it is left when either side of all tangles is taken away.
std::size_t faults_elsewhere(const Simulation& s, const Snapshot& from, const Snapshot& to,
                             const std::vector<Tangle>& tangles) {
  std::size_t worst = 0;
  for (int side = 0; side < 2; ++side) {
    std::vector<char> out(s.cloth_triangles().size() + s.body_triangles().size(), 0);
    for (const Tangle& tangle : tangles)
      for (const std::int32_t t : tangle.side[side]) out[t] = 1;
    worst = std::max(worst, faults(s, from, to, out));
  }
  return worst;
}

bool is_part_of(const std::vector<Tangle>& small, const std::vector<Tangle>& large) {
  if (small.size() > large.size()) return false;
  for (std::size_t k = 0; k < small.size(); ++k)
    for (int side = 0; side < 2; ++side) {
      const auto &a = small[k].side[side], &b = large[k].side[side];
      if (!std::includes(b.begin(), b.end(), a.begin(), a.end())) return false;
    }
  return true;
}

bool is_over(const std::vector<Tangle>& tangles) {
  return std::all_of(tangles.begin(), tangles.end(), [](const auto& t) { return t.is_over(); });
}

void note_speeds(const Snapshot& from, const Snapshot& to, double h, TangleOutcome& outcome) {
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < from.cloth.size(); ++i) mean += to.cloth[i] - from.cloth[i];
  mean /= static_cast<double>(from.cloth.size());
  for (std::size_t i = 0; i < from.cloth.size(); ++i) {
    const Vec3 u = to.cloth[i] - from.cloth[i];
    outcome.max_speed = std::max(outcome.max_speed, u.norm() / h);
    outcome.max_apart = std::max(outcome.max_apart, (u - mean).norm() / h);
  }
}

void step(Simulation& simulation, TangleOutcome& outcome, bool with_judge) {
  const Snapshot from{simulation.state().x, simulation.body_positions()};
  const std::vector<Tangle> tangles = simulation.state().tangles.list;
  const double t0 = simulation.state().time;
  simulation.step_towards(std::numeric_limits<std::int32_t>::max());
  const Snapshot to{simulation.state().x, simulation.body_positions()};
  note_speeds(from, to, simulation.state().time - t0, outcome);
  outcome.only_shrinks =
      outcome.only_shrinks && is_part_of(simulation.state().tangles.list, tangles);
  if (!is_over(tangles)) ++outcome.steps;
  if (!with_judge) return;
  if (is_over(tangles))
    outcome.after += faults(simulation, from, to, {});
  else
    outcome.elsewhere += faults_elsewhere(simulation, from, to, tangles);
}

}  // namespace

const char* tangle_name(TangleKind kind) {
  constexpr const char* names[] = {"bump", "layers", "sleeve", "corner"};
  return names[static_cast<int>(kind)];
}

TangledScene make_tangle(TangleKind kind, unsigned seed) {
  Draw draw(seed);
  TangledScene (*make[])(Draw&) = {bump, layers, sleeve, corner};
  TangledScene tangled = make[static_cast<int>(kind)](draw);
  tangled.text = draw.text();
  return tangled;
}

TangleOutcome untangle(TangledScene tangled, int frames, int frames_after, bool with_judge) {
  TangleOutcome outcome;
  Simulation simulation(tangled.scene, std::move(tangled.built));
  const double end = frames / tangled.scene.time.fps, after = frames_after / tangled.scene.time.fps;
  try {
    double over_since = is_over(simulation.state().tangles.list) ? 0.0 : end;
    while (simulation.state().time < std::min(end, over_since + after)) {
      step(simulation, outcome, with_judge);
      if (over_since == end && is_over(simulation.state().tangles.list))
        over_since = simulation.state().time;
    }
  } catch (const SimulationFailed& failure) {
    outcome.stopped = failure.what();
  }
  outcome.result = simulation.result();
  outcome.start_pairs = outcome.result.tangle.start_pairs;
  outcome.pairs = outcome.result.tangle.pairs;
  outcome.until_s = outcome.result.tangle.until_s;
  outcome.hash = outcome.result.state_hash;
  return outcome;
}

}  // namespace selvedge
