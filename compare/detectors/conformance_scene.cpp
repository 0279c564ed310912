// SPDX-License-Identifier: MIT
#include <selvedge/compare/detectors/conformance.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/base/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace selvedge {
namespace {

/// Random numbers computed from raw bits, because std::uniform_real_distribution differs between
/// libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double uniform(double lo, double hi) {
    constexpr double unit = 0x1p-53;
    return lo + (hi - lo) * (static_cast<double>(engine_() >> 11) * unit);
  }
  /// A number in [lo, hi], both included.
  int integer(int lo, int hi) {
    return lo + static_cast<int>(engine_() % static_cast<std::uint64_t>(hi - lo + 1));
  }
  bool one_in(int n) { return integer(1, n) == 1; }
  Vec3 vector(double r) {
    const double x = uniform(-r, r), y = uniform(-r, r);
    return {x, y, uniform(-r, r)};
  }

 private:
  std::mt19937_64 engine_;
};

struct Surface {
  std::vector<Vec3> x_t0 = {}, x_t1 = {};
  std::vector<Edge> edges = {};
  std::vector<Triangle> triangles = {};
  double thickness = 0.0;
  std::uint64_t static_id = 0;
  std::string kind = {};
  double size = 1.0;  ///< metres, approximate
  bool closed = false;
  bool beyond_float = false;

  void finish() {
    x_t1 = x_t0;
    edges = unique_edges(triangles);
  }
  void move_all(const Vec3& shift) {
    for (auto* xs : {&x_t0, &x_t1})
      for (Vec3& x : *xs) x += shift;
  }
  void scale(double factor) {
    for (auto* xs : {&x_t0, &x_t1})
      for (Vec3& x : *xs) x *= factor;
    thickness *= factor;
    size *= factor;
  }
  int vertex_count() const { return static_cast<int>(x_t0.size()); }
};

void jiggle(Surface& s, Random& random, double amount) {
  for (std::size_t i = 0; i < s.x_t0.size(); ++i) s.x_t1[i] = s.x_t0[i] + random.vector(amount);
}

Surface sheet(int nx, int ny) {
  Surface s{.kind = "sheet"};
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i)
      s.x_t0.push_back({static_cast<double>(i) / nx, static_cast<double>(j) / ny, 0.0});
  const auto at = [nx](int i, int j) { return j * (nx + 1) + i; };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      s.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      s.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  s.finish();
  return s;
}

/// Triangles whose vertices are near each other by index. Vertices may belong to no triangle, and
/// triangles may coincide. With a small `reach`, neighbours by index are neighbours in space.
Surface soup(Random& random, int vertices, int triangles, double reach) {
  Surface s{.kind = "soup"};
  for (int i = 0; i < vertices; ++i)
    s.x_t0.push_back(reach < 1.0 && i % 17 ? Vec3(s.x_t0.back() + random.vector(reach))
                                           : random.vector(1.0));
  for (int i = 0; i < triangles && vertices > 3; ++i) {
    const int v = random.integer(0, vertices - 1), step = random.integer(1, 2);
    s.triangles.push_back({v, (v + step) % vertices, (v + step + 1) % vertices});
  }
  s.finish();
  return s;
}

/// Folds a sheet into a small box: many layers, many pairs.
void crumple(Surface& s, Random& random, double box, double noise) {
  for (Vec3& x : s.x_t0)
    for (int k = 0; k < 3; ++k) {
      const double fold = std::remainder(x[k] * (1.0 + 0.3 * k) + x[(k + 1) % 3], 2.0 * box);
      x[k] = std::abs(fold) + random.uniform(0.0, noise);
    }
  s.x_t1 = s.x_t0;
}

/// A bumpy ball of `rings` bands and as many sectors, triangles oriented outwards.
Surface ball(Random& random, int rings) {
  Surface s{.kind = "closed body"};
  const int sectors = std::max(rings, 3);
  const double stretch = random.uniform(1.0, 3.0), bump = random.uniform(0.0, 0.2);
  const auto at = [&](double polar, double azimuth) {
    const auto [sine, cosine] = elementary::sin_cos(polar);
    const auto [across, along] = elementary::sin_cos(azimuth);
    const double r = 0.3 * (1.0 + bump * elementary::sin(3.0 * azimuth) * sine * sine * sine);
    return Vec3(r * sine * along, r * sine * across, stretch * r * cosine);
  };
  s.x_t0.push_back(at(0.0, 0.0));
  for (int ring = 1; ring < rings; ++ring)
    for (int i = 0; i < sectors; ++i)
      s.x_t0.push_back(at(std::numbers::pi * ring / rings, 2.0 * std::numbers::pi * i / sectors));
  s.x_t0.push_back(at(std::numbers::pi, 0.0));
  const int south = s.vertex_count() - 1;
  const auto index = [&](int ring, int i) { return 1 + (ring - 1) * sectors + i % sectors; };
  for (int i = 0; i < sectors; ++i) {
    s.triangles.push_back({0, index(1, i), index(1, i + 1)});
    s.triangles.push_back({index(rings - 1, i), south, index(rings - 1, i + 1)});
    for (int ring = 1; ring + 1 < rings; ++ring) {
      s.triangles.push_back({index(ring, i), index(ring + 1, i), index(ring + 1, i + 1)});
      s.triangles.push_back({index(ring, i), index(ring + 1, i + 1), index(ring, i + 1)});
    }
  }
  s.finish();
  s.closed = true;
  return s;
}

/// A sheet of which a few vertices move far, so that their boxes cover a large part of the scene.
Surface spiked_sheet(Random& random) {
  Surface s = sheet(10, 10);
  jiggle(s, random, 0.01);
  const double length = std::array<double, 3>{1.0, 10.0, 1000.0}[random.integer(0, 2)];
  for (int i = random.integer(1, 2); i > 0; --i)
    s.x_t1[random.integer(0, s.vertex_count() - 1)] += random.vector(length);
  s.kind = "spikes of " + std::to_string(static_cast<int>(length)) + " m";
  return s;
}

Surface one_point() {
  Surface s = sheet(5, 5);
  for (Vec3& x : s.x_t0) x = Vec3(0.3, 0.1, -0.7);
  s.x_t1 = s.x_t0;
  s.kind = "one point";
  return s;
}

Surface integers(Random& random) {
  Surface s = soup(random, 40, 60, 1.0);
  for (Vec3& x : s.x_t0) x = (3.0 * x).array().round();
  s.x_t1 = s.x_t0;
  s.kind = "integer coordinates";
  return s;
}

/// Points and edges without a triangle.
Surface loose(Random& random) {
  Surface s = soup(random, 60, 30, 0.3);
  for (int i = 0; i < 20; ++i) {
    const int v = random.integer(0, 58);
    s.edges.push_back({v, random.integer(v + 1, 59)});
  }
  std::sort(s.edges.begin(), s.edges.end());
  s.edges.erase(std::unique(s.edges.begin(), s.edges.end()), s.edges.end());
  jiggle(s, random, 0.1);
  s.kind = "loose points and edges";
  return s;
}

/// Sizes over many orders of magnitude; in every third seed up to the limits of float.
Surface all_sizes(Random& random) {
  Surface s = soup(random, 50, 50, 1.0);
  s.beyond_float = random.one_in(3);
  for (Vec3& x : s.x_t0) x *= elementary::pow(10.0, random.integer(-30, s.beyond_float ? 200 : 12));
  s.finish();
  s.kind = s.beyond_float ? "sizes from 1e-30 to 1e200" : "sizes from 1e-30 to 1e12";
  return s;
}

Surface fan(Random& random) {
  Surface s{.kind = "fan"};
  for (int i = 0; i < 60; ++i) s.x_t0.push_back(random.vector(1.0));
  for (int i = 1; i + 1 < 60; ++i) s.triangles.push_back({0, i, i + 1});
  s.finish();
  return s;
}

Surface one_triangle(Random& random) {
  Surface s{.kind = "one triangle"};
  for (int i = 0; i < 3; ++i) s.x_t0.push_back(random.vector(1.0));
  s.triangles = {{0, 1, 2}};
  s.finish();
  return s;
}

/// Each vertex moves by up to `motion` and lies up to as far from the fold.
Surface crumpled_sheet(Random& random, int n, double box, double motion) {
  Surface s = sheet(n, n);
  crumple(s, random, box, motion);
  jiggle(s, random, motion);
  s.kind = "crumple";
  return s;
}

constexpr std::uint64_t kKinds = 14;

Surface make_surface(Random& random, std::uint64_t kind) {
  switch (kind) {
    case 0:
      return soup(random, random.integer(0, 40), random.integer(0, 60), 1.0);
    case 1: {
      Surface s = soup(random, 90, 90, 0.05);
      jiggle(s, random, 0.05);
      return s;
    }
    case 2: {
      Surface s = sheet(random.integer(1, 10), 10);
      jiggle(s, random, 0.1);
      return s;
    }
    case 3:
      return crumpled_sheet(random, 8, 0.45, 0.01);
    case 4:
      return spiked_sheet(random);
    case 5:
      return one_point();
    case 6:
      return integers(random);
    case 7:  // All in one plane; contacts touch exactly.
      return sheet(random.integer(2, 10), random.integer(2, 10));
    case 8:
      return loose(random);
    case 9:
      return one_triangle(random);
    case 10:
      return all_sizes(random);
    case 11:
      return fan(random);
    case 12:
      return Surface{.kind = "empty"};
    default:
      return ball(random, random.integer(2, 9));
  }
}

/// The same surface with its vertices in another order: the same counts, other triangles.
void relabel(Surface& s, Random& random) {
  std::vector<std::int32_t> other(s.x_t0.size());
  for (std::size_t i = 0; i < other.size(); ++i) other[i] = static_cast<std::int32_t>(i);
  for (int i = s.vertex_count() - 1; i > 0; --i) std::swap(other[i], other[random.integer(0, i)]);
  for (Triangle& t : s.triangles)
    for (std::int32_t& v : t) v = other[v];
  for (Edge& e : s.edges) {
    for (std::int32_t& v : e) v = other[v];
    if (e[0] > e[1]) std::swap(e[0], e[1]);
  }
  std::sort(s.edges.begin(), s.edges.end());
}

}  // namespace

struct ConformanceScene::State {
  explicit State(std::uint64_t scene_seed)
      : seed(scene_seed), random(scene_seed * 0x9e3779b97f4a7c15u + 1) {
    make_surfaces();
    set_thickness();
    place();
    b_keeps_shape = random.one_in(2);
    if (b_keeps_shape) keep_static(b);
    steps = is_large() ? 2 : 3;
  }

  bool is_large() const { return seed % 100 == 99; }

  void make_surfaces() {
    if (is_large()) {
      constexpr int n = 23;
      constexpr double box = 0.7, motion = 0.001;
      a = crumpled_sheet(random, n, box, motion);
      b = crumpled_sheet(random, n - 5, box, motion);
    } else {
      a = make_surface(random, seed % kKinds);
      if (random.one_in(6)) {
        b = a;
        b.kind += ", the same again";
      } else {
        b = make_surface(random, random.one_in(4) ? kKinds - 1 : random.integer(0, kKinds - 1));
      }
    }
  }

  void set_thickness() {
    for (Surface* s : {&a, &b}) s->thickness = is_large() ? 0.0 : 0.01 * random.integer(0, 2);
  }

  void place() {
    if (random.one_in(8) && a.vertex_count() > 0) {
      b.scale(1e-5);
      b.move_all(a.x_t0[random.integer(0, a.vertex_count() - 1)]);
      how += ", b is 1e5 times smaller";
    }
    if (random.one_in(8)) {
      for (Surface* s : {&a, &b}) s->move_all(Vec3(1e6, -1e6, 1e6));
      how += ", 1e6 m away";
    } else if (random.one_in(8)) {
      const double unit = random.one_in(2) ? 1e-3 : 1e3;
      for (Surface* s : {&a, &b}) s->scale(unit);
      how += unit < 1.0 ? ", in millimetres" : ", in kilometres";
    }
  }

  /// From here on b must not move; its id is new to every detector.
  void keep_static(Surface& s) {
    s.x_t1 = s.x_t0;
    // A scene uses at most three ids per step.
    s.static_id = 32 * seed + ++ids;
  }

  void change_thickness(Surface& s) {
    const double unit = is_large() ? 0.01 * s.size : s.size;
    s.thickness = unit * std::array<double, 3>{0.0, 0.02, 0.05}[random.integer(0, 2)];
    changed = "other thickness";
  }

  void change(Surface& s) {
    s.static_id = 0;
    switch (random.integer(0, 8)) {
      case 0:  // Continues from its current position, as in a simulation.
      case 1:
        s.x_t0 = s.x_t1;
        jiggle(s, random, 0.02 * s.size);
        changed = "moved on";
        break;
      case 2:
        s.x_t0 = s.x_t1;
        changed = "stands still";
        break;
      case 3:
        if (!s.x_t0.empty())
          s.x_t1[random.integer(0, s.vertex_count() - 1)] += random.vector(s.size);
        changed = "one vertex moved";
        break;
      case 4:
        s.move_all(random.vector(s.size * (random.one_in(2) ? 0.1 : 1000.0)));
        changed = "taken elsewhere";
        break;
      case 5:
        if (s.closed) break;
        relabel(s, random);
        changed = "other triangles in the same arrays";
        break;
      case 6:
        if (s.closed) break;
        s.triangles.resize(s.triangles.size() - s.triangles.size() / 3);
        s.edges = unique_edges(s.triangles);
        changed = "fewer triangles";
        break;
      case 7:
        change_thickness(s);
        break;
      default:
        keep_static(s);
        changed = "static from here on";
        break;
    }
  }

  void advance() {
    changed.clear();
    change(a);
    if (b_keeps_shape) return;
    const std::string of_a = "a: " + changed;
    changed.clear();
    // Half of the time a static surface stays static; static_id does not cover the thickness.
    if (b.static_id == 0 || random.one_in(2))
      change(b);
    else if (random.one_in(3))
      change_thickness(b);
    changed = of_a + ", b: " + changed;
    if (random.one_in(6) && a.closed == b.closed) {
      std::swap(a, b);
      changed += ", then exchanged";
    }
  }

  std::uint64_t seed;
  Random random;
  Surface a, b;
  std::uint64_t ids = 0;
  int steps = 0;
  bool b_keeps_shape = false;
  std::string how, changed;
};

ConformanceScene::ConformanceScene(std::uint64_t seed) : state_(std::make_unique<State>(seed)) {}
ConformanceScene::~ConformanceScene() = default;

int ConformanceScene::step_count() const { return state_->steps; }
void ConformanceScene::advance() { state_->advance(); }

namespace {
SurfaceView view(const Surface& s) {
  return {s.x_t0, s.x_t1, s.edges, s.triangles, s.thickness, s.static_id};
}
}  // namespace

SurfaceView ConformanceScene::a() const { return view(state_->a); }
SurfaceView ConformanceScene::b() const { return view(state_->b); }

std::string ConformanceScene::description() const {
  const State& s = *state_;
  return s.a.kind + " and " + s.b.kind + s.how + (s.changed.empty() ? "" : "; " + s.changed);
}

bool ConformanceScene::b_is_closed() const { return state_->b.closed; }
bool ConformanceScene::b_keeps_shape() const { return state_->b_keeps_shape; }
bool ConformanceScene::is_large() const { return state_->is_large(); }
bool ConformanceScene::is_beyond_float() const {
  return state_->a.beyond_float || state_->b.beyond_float;
}

}  // namespace selvedge
