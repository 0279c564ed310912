// SPDX-License-Identifier: MIT
#include "broadphase_scenes.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

namespace selvedge::bench {
namespace {

constexpr double kBodyRadius = 0.3;  // m
constexpr int kBodySides = 116;      // 2·116·115 = 26,680 faces
// At a resolution of 200 a side, these constants give about as many pairs as the scenes of the
// speed targets: 96 thousand and 243 thousand, 633 thousand and 1.80 million.
constexpr double kDrapeGap = 0.0085;    // m
constexpr double kDrapeSpeed = 0.5;     // m/s
constexpr double kCrumpleBox = 0.38;    // m
constexpr double kCrumpleSpeed = 0.25;  // m/s

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

/// A bumpy sphere in polar coordinates.
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
  return s;
}

SearchScene drape(int n) {
  SearchScene scene{fmt::format("drape {}", n), sheet(n), body(), kDrapeSpeed};
  for (Vec3& x : scene.cloth.x_t0) {
    const double wrinkle = 0.002 * std::sin(60.0 * x.x()) * std::sin(50.0 * x.y());
    x = on_body(std::hypot(x.x(), x.y()) / kBodyRadius, std::atan2(x.y(), x.x()),
                kDrapeGap + wrinkle);
  }
  scene.cloth.x_t1 = scene.cloth.x_t0;
  scene.body.static_id = 1;
  return scene;
}

SearchScene crumple(int n) {
  SearchScene scene{fmt::format("crumple {}", n), sheet(n), {}, kCrumpleSpeed, true};
  const auto fold = [](double u) { return std::abs(std::remainder(u, 2.0 * kCrumpleBox)); };
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(0.0, 1.0);
  for (Vec3& x : scene.cloth.x_t0) {
    const double u = x.x() + 0.31 * x.y(), v = x.y() - 0.27 * x.x();
    x = {fold(u + 0.02 * std::sin(17.0 * v)), fold(v + 0.02 * std::sin(13.0 * u)),
         0.04 * std::sin(11.0 * u + 7.0 * v) + 0.01 * std::sin(31.0 * v) + 0.001 * noise(random)};
  }
  scene.cloth.x_t1 = scene.cloth.x_t0;
  return scene;
}

}  // namespace

Surface tiny_copy(Surface s, double scale) {
  for (Vec3& x : s.x_t0) x = scale * x + Vec3(0.6, 0.6, 0.0);
  return s;
}

SearchScene make_scene(const std::string& kind, int size) {
  if (kind == "drape") return drape(size);
  if (kind == "crumple") return crumple(size);
  throw std::invalid_argument("no scene '" + kind + "'; there are drape and crumple");
}

void move(SearchScene& scene, double speed, unsigned seed) {
  Surface& s = scene.cloth;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) {
    const Vec3 x = s.x_t0[i] - scene.origin;
    const Vec3 flow(std::sin(9.0 * x.y() + seed), std::sin(7.0 * x.z()), std::cos(8.0 * x.x()));
    const double way = kStep * speed * (i < s.tiny_from ? 1.0 : scene.tiny);
    s.x_t1[i] = s.x_t0[i] + way * (flow + Vec3(noise(random), noise(random), noise(random)));
  }
}

}  // namespace selvedge::bench
