// SPDX-License-Identifier: MIT
// A position-based-dynamics program on plain arrays that takes its collisions from selvedge: our
// broad phase and exact narrow phase find them, its own constraints answer them. A square cloth
// falls on a ball. The program prints the time of its solver beside that of the detection, and
// compares the collisions of some steps with those of brute force.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/core/base/types.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <set>
#include <tuple>
#include <vector>

namespace {

using selvedge::Contact;
using selvedge::ContactKind;
using selvedge::Vec3;

constexpr int kCells = 32, kSteps = 120, kIterations = 10, kPasses = 6;
constexpr double kStep = 1.0 / 120.0, kGap = 0.002;  // s, m

// -- the simulator: particles and constraints of distance ----------------------------------------

struct Cloth {
  std::vector<Vec3> x, v;
  std::vector<selvedge::Triangle> triangles;
  std::vector<selvedge::Edge> edges;
  std::vector<double> length;  // m, of the edges at rest
};

Cloth make_cloth() {
  Cloth c;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i)
      c.x.emplace_back(double(i) / kCells - 0.5, double(j) / kCells - 0.5, 0.32);
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const int k = j * (kCells + 1) + i;
      c.triangles.push_back({k, k + 1, k + kCells + 2});
      c.triangles.push_back({k, k + kCells + 2, k + kCells + 1});
    }
  c.edges = selvedge::unique_edges(c.triangles);
  c.v.assign(c.x.size(), Vec3::Zero());
  for (const auto& [a, b] : c.edges) c.length.push_back((c.x[a] - c.x[b]).norm());
  return c;
}

/// Where the particles want to be at the end of the step.
std::vector<Vec3> solve(const Cloth& c) {
  std::vector<Vec3> p(c.x.size());
  for (std::size_t i = 0; i < p.size(); ++i)
    p[i] = c.x[i] + kStep * (0.99 * c.v[i] + kStep * Vec3(0.0, 0.0, -9.81));
  for (int k = 0; k < kIterations; ++k)
    for (std::size_t e = 0; e < c.edges.size(); ++e) {
      const auto [a, b] = c.edges[e];
      const Vec3 d = p[a] - p[b];
      const Vec3 shift = 0.5 * (1.0 - c.length[e] / d.norm()) * d;
      p[a] -= shift;
      p[b] += shift;
    }
  return p;
}

// -- the ball, a mesh that rests
// -------------------------------------------------------------------

struct Ball {
  std::vector<Vec3> x;
  std::vector<selvedge::Triangle> triangles;
  std::vector<selvedge::Edge> edges;
};

Ball make_ball(double radius, int rings) {
  Ball ball;
  const int sides = 2 * rings;
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < sides; ++i) {
      const double polar = std::numbers::pi * j / rings, turn = 2.0 * std::numbers::pi * i / sides;
      ball.x.push_back(radius * Vec3(std::sin(polar) * std::cos(turn),
                                     std::sin(polar) * std::sin(turn), std::cos(polar)));
    }
  const int top = static_cast<int>(ball.x.size()), bottom = top + 1;
  ball.x.emplace_back(0.0, 0.0, radius);
  ball.x.emplace_back(0.0, 0.0, -radius);
  for (int i = 0; i < sides; ++i) {
    const int next = (i + 1) % sides, last = (rings - 2) * sides;
    ball.triangles.push_back({top, i, next});
    ball.triangles.push_back({bottom, last + next, last + i});
    for (int j = 0; j + 2 < rings; ++j) {
      const int a = j * sides, b = a + sides;
      ball.triangles.push_back({a + i, b + i, b + next});
      ball.triangles.push_back({a + i, b + next, a + next});
    }
  }
  ball.edges = selvedge::unique_edges(ball.triangles);
  return ball;
}

// -- detection by selvedge ------------------------------------------------------------------------

/// Collisions of one step: of the cloth with the ball, and with itself.
struct Collisions {
  std::vector<Contact> body, self;
  std::size_t size() const { return body.size() + self.size(); }
};

class Detector {
 public:
  explicit Detector(const char* broad_phase)
      : broad_(selvedge::broad_phases().at(broad_phase)()),
        narrow_(selvedge::narrow_phases().at("ccd_exact")()) {}

  void find(const Cloth& cloth, const std::vector<Vec3>& end, const Ball& ball, Collisions& out) {
    const selvedge::SurfaceView a{cloth.x, end, cloth.edges, cloth.triangles, 0.0, 0};
    const selvedge::SurfaceView b{ball.x, ball.x, ball.edges, ball.triangles, 0.0, 0};
    broad_->find_pairs(a, b, pairs_);
    narrow_->find_contacts(a, b, pairs_, out.body);
    candidates += pairs_.size();
    broad_->find_self_pairs(a, pairs_);
    narrow_->find_contacts(a, a, pairs_, out.self);
    candidates += pairs_.size();
  }

  std::size_t candidates = 0;

 private:
  std::unique_ptr<selvedge::BroadPhase> broad_;
  std::unique_ptr<selvedge::NarrowPhase> narrow_;
  selvedge::CandidatePairs pairs_;
};

// -- the response of this program -----------------------------------------------------------------

/// Whether vertex k of a contact with the ball is a vertex of the cloth.
bool is_cloth(ContactKind kind, int k) {
  if (kind == ContactKind::point_triangle) return k == 0;
  return kind == ContactKind::triangle_point ? k > 0 : k < 2;
}

/// Moves the vertices of the cloth along the normal until the pair ends with the gap between its
/// primitives. Unless `gentle`, they stay at their start instead.
void answer(const Contact& c, bool self, bool gentle, const Cloth& cloth, const Ball& ball,
            std::vector<Vec3>& end) {
  Vec3 apart = Vec3::Zero();
  double share = 0.0;
  for (int k = 0; k < 4; ++k) {
    const bool ours = self || is_cloth(c.kind, k);
    apart += c.weight[k] * (ours ? end[c.vertex[k]] : ball.x[c.vertex[k]]);
    if (ours) share += c.weight[k] * c.weight[k];
  }
  const double lacking = kGap - apart.dot(c.normal);
  for (int k = 0; k < 4; ++k) {
    if (!self && !is_cloth(c.kind, k)) continue;
    if (!gentle)
      end[c.vertex[k]] = cloth.x[c.vertex[k]];
    else if (lacking > 0.0)
      end[c.vertex[k]] += lacking * c.weight[k] / share * c.normal;
  }
}

/// Changes the ends until no path collides: the last resort is that colliding vertices stay.
void resolve(Detector& detector, const Cloth& cloth, const Ball& ball, std::vector<Vec3>& end,
             std::size_t& answered) {
  Collisions found;
  for (int pass = 0;; ++pass) {
    detector.find(cloth, end, ball, found);
    if (found.size() == 0) return;
    answered += found.size();
    for (const Contact& c : found.body) answer(c, false, pass < kPasses, cloth, ball, end);
    for (const Contact& c : found.self) answer(c, true, pass < kPasses, cloth, ball, end);
  }
}

// -- the check ------------------------------------------------------------------------------------

using Key = std::tuple<int, int, int, int, int>;

std::set<Key> keys_of(const std::vector<Contact>& contacts) {
  std::set<Key> keys;
  for (const Contact& c : contacts)
    keys.emplace(static_cast<int>(c.kind), c.vertex[0], c.vertex[1], c.vertex[2], c.vertex[3]);
  return keys;
}

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

int main() {
  Cloth cloth = make_cloth();
  const Ball ball = make_ball(0.3, 24);
  Detector detector("bvh_aabb"), brute_force("brute_force");
  double solver_s = 0.0, detection_s = 0.0;
  std::size_t answered = 0, compared = 0, missed = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double t0 = seconds();
    std::vector<Vec3> end = solve(cloth);
    const double t1 = seconds();
    solver_s += t1 - t0;
    if (step % 24 == 23) {
      Collisions ours, all;
      detector.find(cloth, end, ball, ours);
      brute_force.find(cloth, end, ball, all);
      for (const auto& [mine, every] :
           {std::pair{&ours.body, &all.body}, {&ours.self, &all.self}}) {
        const std::set<Key> found = keys_of(*mine), wanted = keys_of(*every);
        compared += wanted.size();
        for (const Key& key : wanted) missed += found.count(key) == 0;
        if (found.size() > wanted.size()) return 1;
      }
    }
    const double t2 = seconds();
    resolve(detector, cloth, ball, end, answered);
    detection_s += seconds() - t2;
    for (std::size_t i = 0; i < end.size(); ++i) cloth.v[i] = (end[i] - cloth.x[i]) / kStep;
    cloth.x = std::move(end);
  }
  std::printf("%d steps of %zu particles: solver %.2f s, detection and response %.2f s\n", kSteps,
              cloth.x.size(), solver_s, detection_s);
  std::printf("%zu candidates, %zu collisions answered\n", detector.candidates, answered);
  std::printf("brute force finds %zu collisions in 5 of these steps: recall %g\n", compared,
              compared == 0 ? 0.0 : 1.0 - double(missed) / double(compared));
  return compared > 0 && missed == 0 ? 0 : 1;
}
