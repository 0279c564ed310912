// SPDX-License-Identifier: MIT
// Savings of the minimal enclosure. The bodies are a leg and a mannequin of 26,000 faces each, and
// the cloth is one of
//   sleeve  around one leg, close enough to touch it in folds
//   skirt   around both legs (or the leg), touching at the waist only
//   beside  a curtain at a distance of half a body's height
//   far     the same curtain at a distance of ten metres
// The table shows for each number of loops how tight the enclosure is, how many queries it answers
// at once, box tests with and without it, and times relative to the tree and the grid. `inside` is
// the share of the vertices that lie in the enclosure, which a test against the columns and cones
// alone, as the paper has it, would report; `met` is the share that some pair of boxes contains.
// --brute adds the test of every triangle, which the paper compares with. Body and cloth move in
// every call; `static` is the time of a call with a static body. Times are the minimum of
// interleaved repeats.
#include <fmt/format.h>
#include <selvedge/apps/command_line.h>
#include <selvedge/broadphase/internal/minimal_enclosure.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>
#include <selvedge/data/makers/mannequin.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string>

#include "bench.h"

namespace selvedge {
namespace enclosure_bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kThickness = 0.001;       // m
constexpr double kStepLength = 0.002;      // m a step, of the cloth
constexpr double kBodyStepLength = 0.001;  // m a step

struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::uint64_t static_id = 0;

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, kThickness, static_id}; }
  void advance(const Vec3& by) {
    x_t0 = x_t1;
    for (Vec3& x : x_t1) x += by;
  }
};

/// rows x columns vertices, in rings.
Surface rings(int rows, int columns, const std::function<Vec3(double, double)>& place) {
  Surface s;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j)
      s.x_t0.push_back(place(i / (rows - 1.0), 2.0 * kPi * j / columns));
  for (int i = 0; i + 1 < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const int a = i * columns + j, b = i * columns + (j + 1) % columns;
      s.triangles.push_back({a, b, b + columns});
      s.triangles.push_back({a, b + columns, a + columns});
    }
  s.edges = unique_edges(s.triangles);
  s.x_t1 = s.x_t0;
  return s;
}

double leg_radius(double z) { return 0.04 + 0.06 * z + 0.01 * std::sin(9.0 * z); }
/// Centre of a leg at the height z.
double leg_middle(double z) { return 0.05 * std::sin(2.0 * z); }

Surface leg() {
  return rings(144, 91, [](double u, double angle) {
    const double z = 0.9 * u, r = leg_radius(z) * (1.0 + 0.1 * std::cos(2.0 * angle));
    return Vec3(leg_middle(z) + r * std::cos(angle), r * std::sin(angle), z);
  });
}

Surface figure(int faces) {
  const TriangleMesh mesh = make_mannequin({.faces = faces});
  Surface s{mesh.vertices, mesh.vertices, unique_edges(mesh.triangles), mesh.triangles};
  return s;
}

/// A cloth ring of about n x n vertices with folds; its radius changes from r0 to r1.
Surface cloth_ring(int n, const Vec3& base, double height, double r0, double r1) {
  return rings(n, n, [&](double u, double angle) {
    const double r = (r0 + (r1 - r0) * u) * (1.0 + 0.04 * std::sin(11.0 * angle + 20.0 * u));
    return Vec3(base + Vec3(r * std::cos(angle), r * std::sin(angle), height * u));
  });
}

struct BodyScene {
  std::string name;
  Surface cloth, body;
};

std::vector<BodyScene> scenes(int n, int faces) {
  const Surface a_leg = leg(), body = figure(faces);
  std::vector<BodyScene> all;
  all.push_back({"leg sleeve", cloth_ring(n, {0.04, 0, 0.2}, 0.4, 0.065, 0.085), a_leg});
  all.push_back({"leg skirt", cloth_ring(n, {0.04, 0, 0.2}, 0.65, 0.3, 0.1), a_leg});
  all.push_back({"leg beside", cloth_ring(n, {0.5, 0, 0}, 0.9, 0.2, 0.2), a_leg});
  all.push_back({"leg far", cloth_ring(n, {10, 0, 0}, 0.9, 0.2, 0.2), a_leg});
  all.push_back({"figure skirt", cloth_ring(n, {0, 0, 0.3}, 0.7, 0.35, 0.17), body});
  all.push_back({"figure beside", cloth_ring(n, {0.9, 0, 0}, 0.9, 0.2, 0.2), body});
  all.push_back({"figure far", cloth_ring(n, {10, 0, 0}, 0.9, 0.2, 0.2), body});
  return all;
}

double ms_of(BroadPhase& detector, const BodyScene& scene, CandidatePairs& out) {
  const auto begin = std::chrono::steady_clock::now();
  detector.find_pairs(scene.cloth.view(), scene.body.view(), out);
  return 1e3 * seconds_since(begin);
}

/// One detector for moving bodies and another one for a static body.
struct Contender {
  std::string name;
  std::unique_ptr<BroadPhase> moving, still;
  const MinimalEnclosure* enclosure = nullptr;  ///< `moving`, if it is a minimal enclosure
  double cold = 0.0, warm = std::numeric_limits<double>::infinity(), kept = warm;
  BroadPhaseCost cost{};
};

std::vector<Contender> contenders(bool brute) {
  std::vector<Contender> all;
  const BroadPhaseRegistry registry = broad_phases();
  std::vector<std::string> others{"bvh_aabb", "uniform_grid"};
  if (brute) others.emplace_back("brute_force");
  for (const std::string& name : others)
    all.push_back({name, registry.at(name)(), registry.at(name)()});
  for (const int loops : {1, 4, 8, 16, 32, 64}) {
    auto moving = make_minimal_enclosure({.loops = loops});
    const MinimalEnclosure* enclosure = moving.get();
    all.push_back({fmt::format("loops {}", loops), std::move(moving),
                   make_minimal_enclosure({.loops = loops}), enclosure});
  }
  return all;
}

/// Share of the vertices of the cloth that are in a pair with a triangle, in percent.
double share_met(const BodyScene& scene, const CandidatePairs& pairs) {
  std::set<std::int32_t> met;
  for (const PointTrianglePair& pair : pairs.point_triangle) met.insert(pair.point);
  return 100.0 * static_cast<double>(met.size()) / static_cast<double>(scene.cloth.x_t0.size());
}

/// Share of the vertices of the cloth that start or end the step in the enclosure, in percent.
double share_inside(const BodyScene& scene, const Enclosure& enclosure) {
  std::size_t inside = 0;
  for (std::size_t i = 0; i < scene.cloth.x_t0.size(); ++i)
    inside +=
        enclosure.contains(scene.cloth.x_t0[i]) || enclosure.contains(scene.cloth.x_t1[i]) ? 1 : 0;
  return 100.0 * static_cast<double>(inside) / static_cast<double>(scene.cloth.x_t0.size());
}

void print(const BodyScene& scene, const Contender& c, std::size_t pairs, double met) {
  fmt::print("{:14} {:12} {:8} {:8.2f} {:8.2f} {:8.2f}", scene.name, c.name, pairs, c.cold, c.warm,
             c.kept);
  if (c.enclosure) {
    const MinimalEnclosureCounts n = c.enclosure->last_counts();
    const Enclosure made = c.enclosure->last_enclosure();
    const auto asked = static_cast<double>(n.asked);
    const double without =
        static_cast<double>(scene.cloth.x_t0.size() * scene.body.triangles.size() +
                            scene.cloth.triangles.size() * scene.body.x_t0.size() +
                            scene.cloth.edges.size() * scene.body.edges.size()) /
        asked;
    fmt::print(" {:5} {:7.4f} {:7.2f} {:6.2f} {:7.2f} {:6.2f} {:8.2f} {:9.0f}", n.primitives,
               made.volume(), share_inside(scene, made), met,
               100.0 * static_cast<double>(n.dropped) / asked,
               static_cast<double>(n.enclosure_tests) / asked,
               static_cast<double>(n.box_tests) / asked, without);
  }
  fmt::print("\n");
}

void measure(BodyScene scene, int repeats, bool brute) {
  std::vector<Contender> all = contenders(brute);
  CandidatePairs out;
  std::size_t pairs = 0;
  double met = 0.0;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const double sign = repeat % 2 == 0 ? 1.0 : -1.0;
    scene.cloth.advance(sign * Vec3(0, 0, -kStepLength));
    scene.body.advance(sign * Vec3(kBodyStepLength, 0, 0));
    for (Contender& c : all) {
      const double ms = ms_of(*c.moving, scene, out);
      if (repeat == 0) c.cold = ms;
      if (repeat > 0) c.warm = std::min(c.warm, ms);
      if (repeat == 0) pairs = out.size();
      if (&c == &all.front()) met = share_met(scene, out);  // of the last call with moving bodies
    }
  }
  const BodyScene moved = scene;
  scene.body.x_t1 = scene.body.x_t0;
  scene.body.static_id = 1;
  for (int repeat = 0; repeat < repeats; ++repeat)
    for (Contender& c : all) {
      const double ms = ms_of(*c.still, scene, out);
      if (repeat > 0) c.kept = std::min(c.kept, ms);
    }
  for (const Contender& c : all) print(moved, c, pairs, met);
}

}  // namespace
}  // namespace enclosure_bench

int bench_enclosure(int argc, char** argv) {
  using namespace enclosure_bench;
  CommandLine app("Minimal enclosure: tests saved and times");
  int cells = 120, faces = 26000, repeats = 7, threads = 1;
  std::string only;
  bool brute = false;
  app.option("--cells", cells, "vertices of the cloth along a side").range(8, 2000);
  app.option("--repeats", repeats, "calls of each detector").range(2, 1000);
  app.option("--threads", threads, "threads; 0: all");
  app.option("--faces", faces, "faces of the mannequin").range(5000, 30000);
  app.option("--scene", only, "measure this one only, as \"leg sleeve\"");
  app.flag("--brute", brute, "also the test of every primitive against every other");
  if (const auto code = app.parse(argc, argv)) return *code;
  const ThreadLimit limit(threads);
  fmt::print(
      "ms: cold first call, warm all moved, static body at rest; vol m3; dropped %; "
      "inside, met: vertices in the enclosure, in a pair, %; prim, box: tests per vertex, edge or "
      "face\n");
  fmt::print(
      "{:14} {:12} {:>8} {:>8} {:>8} {:>8} {:>5} {:>7} {:>7} {:>6} {:>7} {:>6} {:>8} {:>9}\n",
      "scene", "detector", "pairs", "cold", "warm", "static", "prims", "vol", "inside", "met",
      "dropped", "prim", "box", "without");
  for (BodyScene& scene : scenes(cells, faces))
    if (only.empty() || scene.name == only) measure(std::move(scene), repeats, brute);
  return 0;
}

}  // namespace selvedge
