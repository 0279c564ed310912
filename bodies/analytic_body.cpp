// SPDX-License-Identifier: MIT
#include <selvedge/bodies/body.h>
#include <selvedge/core/base/internal/elementary.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {

namespace {

using std::numbers::pi;
using Vec2 = Eigen::Vector2d;

// ---------------------------------------------------------------- signed distance

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - s * (b - a)).norm();
}

// Signed box distance from q_i = |x_i| - half size: outside, the norm of the positive part; inside,
// the largest component.
template <class Vec>
double distance_beyond(const Vec& q) {
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

double distance_to(const Plane&, const Vec3& x) { return x.z(); }

double distance_to(const Box& box, const Vec3& x) {
  return distance_beyond(Vec3(x.cwiseAbs() - 0.5 * box.size));
}

double distance_to(const Sphere& sphere, const Vec3& x) { return x.norm() - sphere.radius; }

double distance_to(const Capsule& capsule, const Vec3& x) {
  const double z = std::clamp(x.z(), -0.5 * capsule.length, 0.5 * capsule.length);
  return Vec3(x.x(), x.y(), x.z() - z).norm() - capsule.radius;
}

double distance_to(const Cylinder& cylinder, const Vec3& x) {
  return distance_beyond(Vec2(elementary::hypot(x.x(), x.y()) - cylinder.radius,
                              std::abs(x.z()) - 0.5 * cylinder.height));
}

// In the half-plane (ρ, z) a cone is the triangle of axis, base and slant.
double distance_to(const Cone& cone, const Vec3& x) {
  const Vec2 p(elementary::hypot(x.x(), x.y()), x.z());
  const Vec2 centre(0.0, -0.5 * cone.height), rim(cone.radius, -0.5 * cone.height);
  const Vec2 tip(0.0, 0.5 * cone.height);
  const double distance =
      std::min(distance_to_segment(p, centre, rim), distance_to_segment(p, rim, tip));
  const Vec2 outward(cone.height, cone.radius);  // of the slant, not unit
  const bool inside = p.y() > centre.y() && outward.dot(p - rim) < 0.0;
  return inside ? -distance : distance;
}

double distance_to(const Torus& torus, const Vec3& x) {
  return elementary::hypot(elementary::hypot(x.x(), x.y()) - torus.radius, x.z()) - torus.tube;
}

// ---------------------------------------------------------------- tessellation

void require_positive(double value, const char* what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) +
                                " m, but must be positive and finite");
}

// Distance of a chord from its arc, at its midpoint, for `segments` segments of a unit circle.
double sagitta(int segments) { return 1.0 - elementary::cos(pi / segments); }

// Largest distance between a face's plane and the sphere on which its corners lie.
double largest_sagitta(const TriangleMesh& mesh, const Vec3& centre, double radius) {
  double largest = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3 n = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
    largest = std::max(largest, radius - n.dot(a - centre));
  }
  return largest;
}

// n points on the circle of radius rho about the axis; one point on the axis if rho is 0.
struct Ring {
  double rho, z;
  int n;
};

std::int32_t append_ring(const Ring& ring, TriangleMesh& mesh) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  for (int i = 0; i < ring.n; ++i) {
    const double angle = 2.0 * pi * i / ring.n;
    mesh.vertices.push_back(
        {ring.rho * elementary::cos(angle), ring.rho * elementary::sin(angle), ring.z});
  }
  return first;
}

// Triangles between two rings. Each step takes the diagonal with the smaller angle, in integers.
void zip_rings(std::int32_t a, int na, std::int32_t b, int nb, TriangleMesh& mesh) {
  const int steps_a = na > 1 ? na : 0, steps_b = nb > 1 ? nb : 0;
  for (int i = 0, j = 0; i < steps_a || j < steps_b;) {
    const bool advance_a =
        j == steps_b || (i < steps_a && (2LL * i + 1) * steps_b <= (2LL * j + 1) * steps_a);
    if (advance_a) {
      mesh.triangles.push_back({a + i % na, a + (i + 1) % na, b + j % nb});
      ++i;
    } else {
      mesh.triangles.push_back({a + i % na, b + (j + 1) % nb, b + j % nb});
      ++j;
    }
  }
}

// The surface of revolution through rings from the lowest point of the axis to the highest.
TriangleMesh revolve(const std::vector<Ring>& rings) {
  TriangleMesh mesh;
  std::int32_t below = append_ring(rings[0], mesh);
  for (std::size_t k = 1; k < rings.size(); ++k) {
    const std::int32_t above = append_ring(rings[k], mesh);
    zip_rings(below, rings[k - 1].n, above, rings[k].n, mesh);
    below = above;
  }
  return mesh;
}

// Rings of a flat cap from its rim (omitted) to its centre. Each ring has half as many segments as
// the ring around it, so the cap has about three triangles per segment of the rim and no slivers.
std::vector<Ring> cap_rings(const Ring& rim) {
  constexpr int fan_segments = 8;  // few enough for a triangle fan about the centre
  std::vector<Ring> rings;
  Ring ring = rim;
  while (ring.n > fan_segments) {
    const double segment = 2.0 * pi * ring.rho / ring.n;
    ring = {ring.rho - 1.2 * segment, ring.z, (ring.n + 1) / 2};
    if (ring.rho <= segment) break;
    rings.push_back(ring);
  }
  rings.push_back({0.0, rim.z, 1});
  return rings;
}

void append_reversed(const std::vector<Ring>& tail, std::vector<Ring>& rings) {
  rings.insert(rings.end(), tail.rbegin(), tail.rend());
}

// The side of a cylinder, capsule or cone has at most about this many faces. A body that is so thin
// that it would need more gets longer triangles instead. They do not move the surface, because the
// side is straight along the axis.
constexpr int kMaxSideFaces = 4'000'000;

// Rows of a straight side with n segments of this length, so that none of its triangles is longer
// than about four times its width.
int side_rows(double length, double segment, int n) {
  const double most = kMaxSideFaces / (2 * n);
  return static_cast<int>(std::clamp(std::ceil(length / (4.0 * segment)), 1.0, most));
}

TriangleMesh tessellate_shape(const Plane& plane, int) {
  require_positive(plane.size, "the size of a plane");
  const double h = 0.5 * plane.size;
  return {{{-h, -h, 0.0}, {h, -h, 0.0}, {h, h, 0.0}, {-h, h, 0.0}}, {{0, 1, 2}, {0, 2, 3}}};
}

TriangleMesh tessellate_shape(const Box& box, int) {
  for (int k = 0; k < 3; ++k) require_positive(box.size[k], "the size of a box");
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    mesh.vertices.push_back(side.cwiseProduct(box.size));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// An icosahedron with corners at both poles.
TriangleMesh icosahedron() {
  TriangleMesh mesh;
  const double z = 1.0 / std::sqrt(5.0), rho = 2.0 / std::sqrt(5.0);
  mesh.vertices.push_back({0.0, 0.0, -1.0});
  for (int ring = 0; ring < 2; ++ring)
    for (int i = 0; i < 5; ++i) {
      const double angle = 2.0 * pi * (i + 0.5 * ring) / 5.0;
      mesh.vertices.push_back(
          {rho * elementary::cos(angle), rho * elementary::sin(angle), ring == 0 ? -z : z});
    }
  mesh.vertices.push_back({0.0, 0.0, 1.0});
  for (int i = 0; i < 5; ++i) {
    const int j = (i + 1) % 5;
    mesh.triangles.push_back({0, 1 + j, 1 + i});
    mesh.triangles.push_back({1 + i, 1 + j, 6 + i});
    mesh.triangles.push_back({6 + i, 1 + j, 6 + j});
    mesh.triangles.push_back({6 + i, 6 + j, 11});
  }
  return mesh;
}

// Splits every edge of `coarse` into `cuts` parts and creates every new vertex once.
class Subdivision {
 public:
  Subdivision(const TriangleMesh& coarse, int cuts) : coarse_(coarse), cuts_(cuts) {
    mesh_.vertices = coarse.vertices;
    for (const Triangle& t : coarse.triangles) subdivide(t);
  }
  TriangleMesh take() { return std::move(mesh_); }

 private:
  // Vertex at fraction i/cuts from a to c and j/cuts from a to b of a coarse triangle.
  std::int32_t vertex(const Triangle& t, int i, int j) {
    const int k = cuts_ - i - j;  // weights of t[0], t[1], t[2]: k, j, i
    if (k == cuts_) return t[0];
    if (j == cuts_) return t[1];
    if (i == cuts_) return t[2];
    if (i == 0) return edge_vertex(t[0], t[1], j);
    if (j == 0) return edge_vertex(t[0], t[2], i);
    if (k == 0) return edge_vertex(t[1], t[2], i);
    return inner_[static_cast<std::size_t>(i * cuts_ + j)];
  }

  std::int32_t edge_vertex(std::int32_t a, std::int32_t b, int step) {
    if (a > b) std::swap(a, b), step = cuts_ - step;
    const auto [entry, added] = edges_.try_emplace({a, b, step}, 0);
    if (added) {
      entry->second = static_cast<std::int32_t>(mesh_.vertices.size());
      const double s = static_cast<double>(step) / cuts_;
      mesh_.vertices.push_back((1.0 - s) * coarse_.vertices[a] + s * coarse_.vertices[b]);
    }
    return entry->second;
  }

  void add_inner(const Triangle& t) {
    inner_.assign(static_cast<std::size_t>(cuts_) * cuts_, -1);
    const Vec3 &a = coarse_.vertices[t[0]], &b = coarse_.vertices[t[1]],
               &c = coarse_.vertices[t[2]];
    for (int i = 1; i < cuts_; ++i)
      for (int j = 1; i + j < cuts_; ++j) {
        inner_[static_cast<std::size_t>(i * cuts_ + j)] =
            static_cast<std::int32_t>(mesh_.vertices.size());
        mesh_.vertices.push_back(((cuts_ - i - j) * a + j * b + i * c) / cuts_);
      }
  }

  void subdivide(const Triangle& t) {
    add_inner(t);
    for (int i = 0; i < cuts_; ++i)
      for (int j = 0; i + j < cuts_; ++j) {
        mesh_.triangles.push_back({vertex(t, i, j), vertex(t, i, j + 1), vertex(t, i + 1, j)});
        if (i + j + 1 < cuts_)
          mesh_.triangles.push_back(
              {vertex(t, i, j + 1), vertex(t, i + 1, j + 1), vertex(t, i + 1, j)});
      }
  }

  const TriangleMesh& coarse_;
  int cuts_;
  TriangleMesh mesh_;
  std::vector<std::int32_t> inner_;
  std::map<std::array<std::int32_t, 3>, std::int32_t> edges_;
};

TriangleMesh tessellate_shape(const Sphere& sphere, int resolution) {
  require_positive(sphere.radius, "the radius of a sphere");
  const TriangleMesh coarse = icosahedron();
  // With c cuts, the middle faces of a projected icosahedron have a circumradius of about 0.764/c.
  // The target is sin(π/resolution), so c is about 0.243 resolution.
  // Neither this count nor that of the capsule depends on the radius, and both end far below their
  // bounds for every resolution.
  TriangleMesh mesh;
  for (int cuts = std::max(1, resolution * 23 / 100); cuts <= resolution; ++cuts) {
    mesh = Subdivision(coarse, cuts).take();
    for (Vec3& x : mesh.vertices) x.normalize();
    if (largest_sagitta(mesh, Vec3::Zero(), 1.0) <= sagitta(resolution)) break;
  }
  for (Vec3& x : mesh.vertices) x *= sphere.radius;
  return mesh;
}

// Rings of the lower half sphere of radius 1 about the origin, pole first, equator (n) last.
std::vector<Ring> hemisphere_rings(int n) {
  // Row height: that of equilateral triangles over the segments of the equator.
  const int rows = std::max(1, static_cast<int>(std::ceil(n / (2.0 * std::sqrt(3.0)))));
  std::vector<Ring> rings{{0.0, -1.0, 1}};
  for (int k = 1; k < rows; ++k) {
    const double angle = 0.5 * pi * k / rows;
    const int segments = std::max(3, static_cast<int>(std::ceil(n * elementary::sin(angle))));
    rings.push_back({elementary::sin(angle), -elementary::cos(angle), segments});
  }
  rings.push_back({1.0, 0.0, n});
  return rings;
}

TriangleMesh tessellate_shape(const Capsule& capsule, int resolution) {
  require_positive(capsule.radius, "the radius of a capsule");
  require_positive(capsule.length, "the length of a capsule");
  const double r = capsule.radius, half = 0.5 * capsule.length;
  int n = resolution + resolution / 10;  // near-equilateral triangles need at most 2/√3 as many
  const int most = 2 * resolution + 2;
  while (n < most &&
         largest_sagitta(revolve(hemisphere_rings(n)), Vec3::Zero(), 1.0) > sagitta(resolution))
    n += 1 + n / 100;
  const std::vector<Ring> unit = hemisphere_rings(n);
  std::vector<Ring> rings;
  for (const Ring& ring : unit) rings.push_back({r * ring.rho, r * ring.z - half, ring.n});
  const int rows = side_rows(capsule.length, 2.0 * pi * r / n, n);
  for (int k = 1; k < rows; ++k) rings.push_back({r, capsule.length * k / rows - half, n});
  for (auto ring = unit.rbegin(); ring != unit.rend(); ++ring)
    rings.push_back({r * ring->rho, half - r * ring->z, ring->n});
  return revolve(rings);
}

TriangleMesh tessellate_shape(const Cylinder& cylinder, int resolution) {
  require_positive(cylinder.radius, "the radius of a cylinder");
  require_positive(cylinder.height, "the height of a cylinder");
  const double r = cylinder.radius, half = 0.5 * cylinder.height;
  std::vector<Ring> rings;
  append_reversed(cap_rings({r, -half, resolution}), rings);
  const int rows = side_rows(cylinder.height, 2.0 * pi * r / resolution, resolution);
  for (int k = 0; k <= rows; ++k)
    rings.push_back({r, cylinder.height * k / rows - half, resolution});
  for (const Ring& ring : cap_rings({r, half, resolution})) rings.push_back(ring);
  return revolve(rings);
}

// A chord lies ρ(1 - cos(π/n)) ≈ ρπ²/2n² inside the circle of radius ρ, so n ∝ √ρ keeps that
// distance at its value on the base.
//
// With s² the part of the slant that is left, a ring has n ≥ N s segments, N those of the base, and
// is followed by the next one at a distance of 2·2πρ/n ≤ c s slants, c = 4πr/(N·slant). The side
// then has about 2N/c faces. As long as n > 3, n ≤ ⁴⁄₃ N s: every ring makes s smaller by ⅜c or
// more, so there are fewer than 3/c rings. A ring of three segments is the last one: towards the
// tip of a thin cone smaller ones would only repeat the same triangles, without end.
std::vector<Ring> slant_rings(const Cone& cone, int resolution) {
  constexpr int smallest = 3;  // segments of a ring
  const double slant = elementary::hypot(cone.radius, cone.height);
  const double c = 4.0 * pi * (cone.radius / slant) / resolution;
  const double least_c = 2.0 * resolution / kMaxSideFaces;
  const double stretch = c < least_c ? least_c / c : 1.0;  // of the distances, in too thin a cone
  const int most = 1 + static_cast<int>(std::ceil(3.0 / std::max(c, least_c)));
  std::vector<Ring> rings;
  double left = 1.0;  // fraction of the slant that remains above
  Ring ring{cone.radius, -0.5 * cone.height, resolution};
  for (int k = 0; k < most && ring.n > smallest; ++k) {
    const double step = 2.0 * (2.0 * pi * ring.rho / ring.n) / slant * stretch;
    left -= step;
    if (!(left >= 0.5 * step)) break;
    const int n = static_cast<int>(std::ceil(resolution * std::sqrt(left)));
    ring = {cone.radius * left, cone.height * (0.5 - left), std::max(smallest, n)};
    rings.push_back(ring);
  }
  rings.push_back({0.0, 0.5 * cone.height, 1});
  return rings;
}

TriangleMesh tessellate_shape(const Cone& cone, int resolution) {
  require_positive(cone.radius, "the radius of a cone");
  require_positive(cone.height, "the height of a cone");
  const Ring base{cone.radius, -0.5 * cone.height, resolution};
  std::vector<Ring> rings;
  append_reversed(cap_rings(base), rings);
  rings.push_back(base);
  for (const Ring& ring : slant_rings(cone, resolution)) rings.push_back(ring);
  return revolve(rings);
}

// Segments around the tube such that their chord distance equals that of the outer rim.
int tube_segments(const Torus& torus, int resolution) {
  const double part = torus.tube / (torus.radius + torus.tube);
  return std::max(6, static_cast<int>(std::ceil(resolution * std::sqrt(part))));
}

TriangleMesh tessellate_shape(const Torus& torus, int resolution) {
  require_positive(torus.radius, "the radius of a torus");
  require_positive(torus.tube, "the tube radius of a torus");
  if (torus.tube >= torus.radius)
    throw std::invalid_argument("the tube radius of a torus is " + std::to_string(torus.tube) +
                                " m, but must be smaller than its radius " +
                                std::to_string(torus.radius) + " m");
  const int m = tube_segments(torus, resolution);
  TriangleMesh mesh;
  for (int j = 0; j < m; ++j) {
    const double angle = 2.0 * pi * j / m;
    append_ring({torus.radius + torus.tube * elementary::cos(angle),
                 torus.tube * elementary::sin(angle), resolution},
                mesh);
  }
  for (int j = 0; j < m; ++j)
    zip_rings(j * resolution, resolution, (j + 1) % m * resolution, resolution, mesh);
  return mesh;
}

// More than a million faces for a sphere; a larger value is a typing error that would fill the
// memory.
constexpr int kMaxResolution = 1000;

}  // namespace

double signed_distance(const AnalyticShape& shape, const Vec3& x) {
  return std::visit([&](const auto& s) { return distance_to(s, x); }, shape);
}

TriangleMesh tessellate(const AnalyticShape& shape, int resolution) {
  if (resolution < 3 || resolution > kMaxResolution)
    throw std::invalid_argument("the resolution of a body is " + std::to_string(resolution) +
                                ", but must lie between 3 and " + std::to_string(kMaxResolution));
  return std::visit([&](const auto& s) { return tessellate_shape(s, resolution); }, shape);
}

}  // namespace selvedge
