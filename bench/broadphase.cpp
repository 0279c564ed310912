// SPDX-License-Identifier: MIT
// Seconds of the broad phases by part, on two scenes of any size:
//   drape N    an N x N cloth of 1 m wrapped on a body of 26,680 faces, moved by a step of 1/60 s
//   crumple N  an N x N sheet of 1 m folded into a small box, against itself
// `cold` is the first call of a new detector (topology, build, query), `build` and `query` the
// parts of a later call that makes the tree anew, `refit` that of a call that keeps it after every
// vertex has moved, and `warm` all of that call. Medians of interleaved repeats.
#include <fmt/format.h>
#include <selvedge/apps/methods.h>
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/parallel.h>
#include <selvedge/core/triangle_mesh.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

using namespace selvedge;

namespace {

constexpr double kStep = 1.0 / 60.0;  // s
constexpr double kThickness = 0.001;  // m
constexpr double kBodyRadius = 0.3;   // m
constexpr int kBodySides = 116;       // 2·116·115 = 26,680 faces

struct Surface {
  std::vector<Vec3> x_t0, x_t1;
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::uint64_t static_id = 0;

  SurfaceView view() const { return {x_t0, x_t1, edges, triangles, kThickness, static_id}; }
};

Surface sheet(int n) {
  Surface s;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) s.x_t0.push_back({i / (n - 1.0) - 0.5, j / (n - 1.0) - 0.5, 0.0});
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      s.triangles.push_back({a, b, d});
      s.triangles.push_back({a, d, c});
    }
  s.edges = unique_edges(s.triangles);
  s.x_t1 = s.x_t0;
  return s;
}

/// A bumpy ball in polar coordinates.
Vec3 on_body(double polar, double azimuth, double above) {
  const double r =
      kBodyRadius * (1.0 + 0.06 * std::sin(3.0 * azimuth) * std::pow(std::sin(polar), 3.0)) + above;
  return r * Vec3(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth),
                  std::cos(polar));
}

Surface body() {
  Surface s;
  const int n = kBodySides;
  s.x_t0.push_back(on_body(0.0, 0.0, 0.0));
  for (int ring = 1; ring < n; ++ring)
    for (int i = 0; i < n; ++i)
      s.x_t0.push_back(on_body(std::numbers::pi * ring / n, 2.0 * std::numbers::pi * i / n, 0.0));
  s.x_t0.push_back(on_body(std::numbers::pi, 0.0, 0.0));
  const auto at = [n](int ring, int i) { return 1 + (ring - 1) * n + i % n; };
  const int south = static_cast<int>(s.x_t0.size()) - 1;
  for (int i = 0; i < n; ++i) {
    s.triangles.push_back({0, at(1, i), at(1, i + 1)});
    s.triangles.push_back({at(n - 1, i), south, at(n - 1, i + 1)});
    for (int ring = 1; ring + 1 < n; ++ring) {
      s.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring + 1, i + 1)});
      s.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring, i + 1)});
    }
  }
  s.edges = unique_edges(s.triangles);
  s.x_t1 = s.x_t0;
  s.static_id = 1;
  return s;
}

/// End positions: a smooth flow and a little noise, the same speeds on every mesh.
void move(Surface& s, double speed, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) {
    const Vec3& x = s.x_t0[i];
    const Vec3 flow(std::sin(9.0 * x.y() + seed), std::sin(7.0 * x.z()), std::cos(8.0 * x.x()));
    s.x_t1[i] = x + kStep * speed * (flow + Vec3(noise(random), noise(random), noise(random)));
  }
}

struct Scene {
  std::string name;
  Surface cloth, body;
  bool self = false;
};

Scene drape(int n) {
  Scene scene{fmt::format("drape {}", n), sheet(n), body()};
  for (Vec3& x : scene.cloth.x_t0) {
    const double wrinkle = 0.002 * std::sin(60.0 * x.x()) * std::sin(50.0 * x.y());
    x = on_body(std::hypot(x.x(), x.y()) / kBodyRadius, std::atan2(x.y(), x.x()), 0.004 + wrinkle);
  }
  return scene;
}

Scene crumple(int n) {
  Scene scene{fmt::format("crumple {}", n), sheet(n), {}, true};
  constexpr double box = 0.27;  // m
  const auto fold = [](double u) { return std::abs(std::remainder(u, 2.0 * box)); };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(0.0, 1.0);
  for (Vec3& x : scene.cloth.x_t0) {
    const double u = x.x() + 0.31 * x.y(), v = x.y() - 0.27 * x.x();
    x = {fold(u + 0.02 * std::sin(17.0 * v)), fold(v + 0.02 * std::sin(13.0 * u)),
         0.04 * std::sin(11.0 * u + 7.0 * v) + 0.01 * std::sin(31.0 * v) + 0.001 * noise(random)};
  }
  return scene;
}

/// Which of the repeats is printed: the median, or the least on a machine that is busy otherwise.
enum class Pick { median, least };

double pick(std::vector<double> values, Pick which) {
  const std::size_t place = which == Pick::median ? values.size() / 2 : 0;
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[place];
}

/// One call; its time in seconds.
double detect(BroadPhase& detector, const Scene& scene, CandidatePairs& out) {
  const auto begin = std::chrono::steady_clock::now();
  if (scene.self)
    detector.find_self_pairs(scene.cloth.view(), out);
  else
    detector.find_pairs(scene.cloth.view(), scene.body.view(), out);
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Times {
  std::vector<double> cold, build, refit, query, warm;
};

void measure(Scene& scene, const BroadPhaseRegistry& registry, int repeats, int threads,
             Pick which) {
  const ThreadLimit limit(threads);
  std::map<std::string, Times> times;
  std::map<std::string, std::unique_ptr<BroadPhase>> kept;
  std::map<std::string, CandidatePairs> out;
  std::map<std::string, std::size_t> bytes;
  constexpr double speed = 0.08;  // m/s
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const auto& [name, make] : registry) {
      Times& t = times[name];
      kept[name] = make();
      move(scene.cloth, speed, 1);
      t.cold.push_back(detect(*kept[name], scene, out[name]));
      // A new promise to stand still makes the detector build its tree anew.
      move(scene.cloth, speed, 3);
      scene.cloth.static_id = 2;
      detect(*kept[name], scene, out[name]);
      t.build.push_back(kept[name]->last_cost().build_s);
      scene.cloth.static_id = 0;
      move(scene.cloth, speed, 2);
      t.warm.push_back(detect(*kept[name], scene, out[name]));
      const BroadPhaseCost cost = kept[name]->last_cost();
      t.refit.push_back(cost.refit_s + cost.build_s);
      t.query.push_back(cost.query_s);
      bytes[name] = cost.bytes;
    }
  }
  const std::size_t primitives = scene.cloth.x_t0.size() + scene.cloth.edges.size() +
                                 scene.cloth.triangles.size() + scene.body.x_t0.size() +
                                 scene.body.edges.size() + scene.body.triangles.size();
  for (auto& [name, t] : times)
    fmt::print(
        "{:<12} {:<12} {:>7} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9} {:>9} {:>7.1f} "
        "{:>6.0f}\n",
        scene.name, name, threads, 1e3 * pick(t.cold, which), 1e3 * pick(t.build, which),
        1e3 * pick(t.refit, which), 1e3 * pick(t.query, which), 1e3 * pick(t.warm, which),
        out[name].point_triangle.size() + out[name].triangle_point.size(),
        out[name].edge_edge.size(), 1e-6 * static_cast<double>(bytes[name]),
        static_cast<double>(bytes[name]) / static_cast<double>(primitives));
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Seconds of the broad phases by part");
  std::vector<int> sizes = {50, 100, 200};
  std::vector<int> threads = {1, 2};
  int repeats = 9, largest_brute = 50;
  app.add_option("--size", sizes, "vertices a side")->check(CLI::Range(2, 3000));
  app.add_option("--threads", threads, "threads");
  app.add_option("--repeats", repeats, "calls of which the median is printed")
      ->check(CLI::Range(1, 1000));
  app.add_option("--largest-brute", largest_brute, "largest size that brute force is run on");
  bool least = false;
  app.add_flag("--least", least, "print the least time instead of the median");
  CLI11_PARSE(app, argc, argv);

  fmt::print("times in ms; MB and bytes per primitive: what the detector keeps between calls\n");
  fmt::print("{:<12} {:<12} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>6}\n", "scene",
             "detector", "threads", "cold", "build", "refit", "query", "warm", "pt", "ee", "MB",
             "B/prim");
  for (const int size : sizes)
    for (auto* make : {drape, crumple}) {
      Scene scene = make(size);
      BroadPhaseRegistry registry = methods_of_this_build().broad_phases;
      if (size > largest_brute) registry.erase("brute_force");
      for (const int count : threads)
        measure(scene, registry, repeats, count, least ? Pick::least : Pick::median);
    }
}
