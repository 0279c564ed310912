// SPDX-License-Identifier: MIT
#include <selvedge/data/makers/detail/implicit_surface.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>
#include <utility>

namespace selvedge::detail {

namespace {

constexpr std::size_t kSamplesPerTask = 1024;
constexpr std::size_t kVerticesPerTask = 256;
// Range of a crossing along a grid edge; keeps the corners of a tetrahedron's faces apart.
constexpr double kLeastCrossing = 0.05, kMostCrossing = 0.95;

// ---------------------------------------------------------------- marching tetrahedra

using Corner = std::array<int, 3>;

class TetrahedraMarch {
 public:
  TetrahedraMarch(Field field, const ImplicitSurfaceConfig& config)
      : field_(field), config_(config) {
    for (int k = 0; k < 3; ++k)
      nodes_[k] =
          static_cast<int>(std::ceil((config.upper[k] - config.lower[k]) / config.cell)) + 1;
  }

  TriangleMesh run() {
    sample();
    edge_vertex_.assign(7 * value_.size(), -1);
    for (int k = 0; k + 1 < nodes_[2]; ++k)
      for (int j = 0; j + 1 < nodes_[1]; ++j)
        for (int i = 0; i + 1 < nodes_[0]; ++i) march_cell({i, j, k});
    return std::move(mesh_);
  }

 private:
  std::size_t node(const Corner& c) const {
    return (static_cast<std::size_t>(c[2]) * nodes_[1] + c[1]) * nodes_[0] + c[0];
  }
  Vec3 position(const Corner& c) const {
    return config_.lower + config_.cell * Vec3(c[0], c[1], c[2]);
  }

  void sample() {
    const std::size_t nx = nodes_[0], ny = nodes_[1], nz = nodes_[2];
    value_.resize(nx * ny * nz);
    parallel_for(value_.size(), kSamplesPerTask, [&](std::size_t begin, std::size_t end) {
      for (std::size_t n = begin; n < end; ++n)
        value_[n] = field_(position({static_cast<int>(n % nx), static_cast<int>(n / nx % ny),
                                     static_cast<int>(n / nx / ny)}));
    });
  }

  bool inside(const Corner& c) const { return value_[node(c)] < 0.0; }

  // Six tetrahedra around the diagonal of the cell, one for each order of the axes.
  void march_cell(const Corner& base) {
    constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int o = 0; o < 6; ++o) {
      std::array<Corner, 4> chain{base, base, base, base};
      for (int step = 0; step < 3; ++step)
        for (int later = step; later < 3; ++later) ++chain[later + 1][orders[o][step]];
      march_tetrahedron(chain, o < 3);
    }
  }

  // Sorts the corners, inside first. Each exchange reverses the orientation of the tetrahedron.
  void march_tetrahedron(std::array<Corner, 4> c, bool positive) {
    int within = 0;
    for (int k = 0; k < 4; ++k)
      if (inside(c[k])) {
        if (k != within) {
          std::swap(c[k], c[within]);
          positive = !positive;
        }
        ++within;
      }
    if (within == 1) add_face(vertex(c[0], c[1]), vertex(c[0], c[2]), vertex(c[0], c[3]), positive);
    if (within == 3) add_face(vertex(c[0], c[3]), vertex(c[1], c[3]), vertex(c[2], c[3]), positive);
    if (within == 2) {
      const std::int32_t ac = vertex(c[0], c[2]), ad = vertex(c[0], c[3]);
      const std::int32_t bd = vertex(c[1], c[3]), bc = vertex(c[1], c[2]);
      add_face(ac, ad, bd, positive);
      add_face(ac, bd, bc, positive);
    }
  }

  void add_face(std::int32_t a, std::int32_t b, std::int32_t c, bool positive) {
    mesh_.triangles.push_back(positive ? Triangle{a, b, c} : Triangle{a, c, b});
  }

  // The crossing on a grid edge, created once. An edge is its lower end and one of seven
  // directions.
  std::int32_t vertex(Corner a, Corner b) {
    if (node(b) < node(a)) std::swap(a, b);
    const int direction = (b[0] - a[0]) + 2 * (b[1] - a[1]) + 4 * (b[2] - a[2]);
    std::int32_t& index = edge_vertex_[7 * node(a) + direction - 1];
    if (index >= 0) return index;
    const double va = value_[node(a)], vb = value_[node(b)];
    const double s = std::clamp(va / (va - vb), kLeastCrossing, kMostCrossing);
    index = static_cast<std::int32_t>(mesh_.vertices.size());
    mesh_.vertices.push_back((1.0 - s) * position(a) + s * position(b));
    return index;
  }

  Field field_;
  const ImplicitSurfaceConfig& config_;
  std::array<int, 3> nodes_;
  std::vector<double> value_;
  std::vector<std::int32_t> edge_vertex_;
  TriangleMesh mesh_;
};

// ---------------------------------------------------------------- projection to the surface

constexpr int kNewtonSteps = 3;  // starts within a cell of the surface, ends below 1e-6 of a cell
// Central differences: the error is about step² times the field's curvature, the rounding
// 1e-16/step.
constexpr double kDifferenceStep = 1e-3;  // of a cell

class Surface {
 public:
  Surface(Field field, double cell) : field_(field), cell_(cell) {}

  // x -= f ∇f / |∇f|², with steps of at most a cell. Returns the unit normal in `normal`.
  void project(Vec3& x, Vec3& normal) const {
    for (int step = 0; step < kNewtonSteps; ++step) {
      const Vec3 g = gradient(x);
      const double length = g.norm();
      if (!(length > 0.0)) return;
      normal = g / length;
      x -= std::clamp(field_(x) / length, -cell_, cell_) * normal;
    }
  }

  void project(std::vector<Vec3>& x, std::vector<Vec3>& normal) const {
    normal.resize(x.size(), Vec3::Zero());
    parallel_for(x.size(), kVerticesPerTask, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) project(x[i], normal[i]);
    });
  }

 private:
  Vec3 gradient(const Vec3& x) const {
    const double step = kDifferenceStep * cell_;
    Vec3 g;
    for (int k = 0; k < 3; ++k) {
      Vec3 ahead = x, behind = x;
      ahead[k] += step;
      behind[k] -= step;
      g[k] = (field_(ahead) - field_(behind)) / (2.0 * step);
    }
    return g;
  }

  Field field_;
  double cell_;
};

// ---------------------------------------------------------------- coarsening

constexpr int kMostNeighbours = 9;
constexpr double kLeastAlignment = 0.5;  // cosine between a face and the surface at its corners

// Collapses the cheapest edge until the target number of faces remains. Cost: the squared length
// plus the change of the normal times curved_radius, so faces are smaller where the surface is
// curved. Order and link condition follow [Hoppe1996], but vertices stay on the implicit surface.
class Coarsening {
 public:
  Coarsening(const Surface& surface, double curved_radius, TriangleMesh& mesh,
             std::vector<Vec3>& normal)
      : surface_(surface),
        bend_(curved_radius * curved_radius),
        mesh_(mesh),
        normal_(normal),
        faces_of_(mesh.vertices.size()),
        version_(mesh.vertices.size(), 0),
        left_(mesh.triangles.size()) {
    for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
      for (const std::int32_t v : mesh.triangles[k])
        faces_of_[v].push_back(static_cast<std::int32_t>(k));
    for (const Edge& e : unique_edges(mesh.triangles)) push(e[0], e[1]);
  }

  void run(std::size_t faces) {
    while (left_ > faces && !queue_.empty()) {
      const Candidate c = queue_.top();
      queue_.pop();
      if (version_[c.a] == c.version_a && version_[c.b] == c.version_b) try_collapse(c.a, c.b);
    }
    compact();
  }

 private:
  struct Candidate {
    double cost;
    std::int32_t a, b;
    int version_a, version_b;
    bool operator<(const Candidate& o) const {  // cheapest on top; ties are decided by index
      return std::tie(o.cost, o.a, o.b) < std::tie(cost, a, b);
    }
  };

  void push(std::int32_t a, std::int32_t b) {
    const double cost = (mesh_.vertices[a] - mesh_.vertices[b]).squaredNorm() +
                        bend_ * (normal_[a] - normal_[b]).squaredNorm();
    queue_.push({cost, a, b, version_[a], version_[b]});
  }

  std::vector<std::int32_t> neighbours(std::int32_t v) const {
    std::vector<std::int32_t> ring;
    for (const std::int32_t f : faces_of_[v])
      for (const std::int32_t w : mesh_.triangles[f])
        if (w != v) ring.push_back(w);
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    return ring;
  }

  // Link condition: exactly two common neighbours, so the surface stays manifold.
  bool is_legal(std::int32_t a, std::int32_t b) const {
    const std::vector<std::int32_t> ring_a = neighbours(a), ring_b = neighbours(b);
    std::vector<std::int32_t> common;
    std::set_intersection(ring_a.begin(), ring_a.end(), ring_b.begin(), ring_b.end(),
                          std::back_inserter(common));
    if (common.size() != 2) return false;
    for (const std::int32_t v : common)
      if (faces_of_[v].size() <= 3) return false;
    return ring_a.size() + ring_b.size() - 4 <= kMostNeighbours;
  }

  static bool has(const Triangle& t, std::int32_t v) { return t[0] == v || t[1] == v || t[2] == v; }

  // True if every remaining face still faces outward when `moved` goes to x.
  bool stays_outward(std::int32_t moved, std::int32_t gone, const Vec3& x, const Vec3& n) const {
    for (const std::int32_t f : faces_of_[moved]) {
      const Triangle& t = mesh_.triangles[f];
      if (has(t, gone)) continue;
      Vec3 p[3];
      for (int k = 0; k < 3; ++k) p[k] = t[k] == moved ? x : mesh_.vertices[t[k]];
      const Vec3 face = (p[1] - p[0]).cross(p[2] - p[0]);
      const double least = kLeastAlignment * face.norm();
      for (int k = 0; k < 3; ++k)
        if (!(face.dot(t[k] == moved ? n : normal_[t[k]]) > least)) return false;
    }
    return true;
  }

  void try_collapse(std::int32_t a, std::int32_t b) {
    if (!is_legal(a, b)) return;
    Vec3 x = 0.5 * (mesh_.vertices[a] + mesh_.vertices[b]);
    Vec3 n = normal_[a];
    surface_.project(x, n);
    if (stays_outward(a, b, x, n) && stays_outward(b, a, x, n)) collapse(a, b, x, n);
  }

  void collapse(std::int32_t a, std::int32_t b, const Vec3& x, const Vec3& n) {
    mesh_.vertices[a] = x;
    normal_[a] = n;
    for (const std::int32_t f : faces_of_[b]) {
      Triangle& t = mesh_.triangles[f];
      if (has(t, a)) {
        remove_face(f, b);
        continue;
      }
      std::replace(t.begin(), t.end(), b, a);
      faces_of_[a].push_back(f);
    }
    faces_of_[b].clear();
    ++version_[a];
    ++version_[b];
    for (const std::int32_t v : neighbours(a)) push(std::min(a, v), std::max(a, v));
  }

  void remove_face(std::int32_t f, std::int32_t except) {
    for (const std::int32_t v : mesh_.triangles[f])
      if (v != except) std::erase(faces_of_[v], f);
    mesh_.triangles[f] = {-1, -1, -1};
    --left_;
  }

  void compact() {
    std::erase_if(mesh_.triangles, [](const Triangle& t) { return t[0] < 0; });
    std::vector<std::int32_t> place(mesh_.vertices.size(), -1);
    std::int32_t kept = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (faces_of_[i].empty()) continue;
      mesh_.vertices[kept] = mesh_.vertices[i];
      normal_[kept] = normal_[i];
      place[i] = kept++;
    }
    mesh_.vertices.resize(kept);
    normal_.resize(kept);
    for (Triangle& t : mesh_.triangles)
      for (std::int32_t& v : t) v = place[v];
  }

  const Surface& surface_;
  double bend_;
  TriangleMesh& mesh_;
  std::vector<Vec3>& normal_;
  std::vector<std::vector<std::int32_t>> faces_of_;
  std::vector<int> version_;
  std::size_t left_;
  std::priority_queue<Candidate> queue_;
};

// ---------------------------------------------------------------- smoothing

constexpr double kRelaxation = 0.5;

// Moves every vertex in its tangent plane towards the mean of its neighbours.
void relax(const std::vector<Edge>& edges, const std::vector<Vec3>& normal, std::vector<Vec3>& x) {
  std::vector<Vec3> sum(x.size(), Vec3::Zero());
  std::vector<int> count(x.size(), 0);
  for (const auto& [a, b] : edges) {
    sum[a] += x[b];
    sum[b] += x[a];
    ++count[a];
    ++count[b];
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 move = kRelaxation * (sum[i] / std::max(count[i], 1) - x[i]);
    x[i] += move - normal[i].dot(move) * normal[i];
  }
}

}  // namespace

TriangleMesh mesh_implicit_surface(Field field, const ImplicitSurfaceConfig& config) {
  TriangleMesh mesh = TetrahedraMarch(field, config).run();
  const Surface surface(field, config.cell);
  std::vector<Vec3> normal;
  surface.project(mesh.vertices, normal);
  Coarsening(surface, config.curved_radius, mesh, normal)
      .run(static_cast<std::size_t>(config.faces));
  const std::vector<Edge> edges = unique_edges(mesh.triangles);
  for (int round = 0; round < config.relaxations; ++round) {
    relax(edges, normal, mesh.vertices);
    surface.project(mesh.vertices, normal);
  }
  return mesh;
}

}  // namespace selvedge::detail
