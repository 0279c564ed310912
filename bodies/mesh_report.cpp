// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/triangle_crossing.h>
#include <selvedge/bodies/internal/triangle_tree.h>
#include <selvedge/bodies/mesh_report.h>
#include <selvedge/core/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace selvedge {

namespace {

constexpr std::size_t kQueriesPerTask = 256;
struct Bounds {
  Vec3 lower, upper;

  bool overlaps(const Bounds& other) const {
    return (lower.array() <= other.upper.array()).all() &&
           (other.lower.array() <= upper.array()).all();
  }
};

// One triangle's traversal of an edge.
struct EdgeRun {
  Edge edge;  // lower index first
  std::int32_t triangle;
  bool forward;  // from the lower to the higher index
};

bool lexicographic(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// Union-find over the triangles.
class Parts {
 public:
  explicit Parts(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t root(std::int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // The lower root stays, so the result depends only on the sets.
  void join(std::int32_t a, std::int32_t b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::int32_t> parent_;
};

class MeshInspection {
 public:
  explicit MeshInspection(const TriangleMesh& mesh)
      : mesh_(mesh), parts_(mesh.triangles.size()), open_(mesh.triangles.size(), false) {
    check_indices();
  }

  MeshReport report() {
    report_.vertices = mesh_.vertices.size();
    report_.triangles = mesh_.triangles.size();
    measure_extent();
    count_vertices();
    count_faces();
    inspect_edges();
    inspect_parts();
    count_self_intersections();
    return report_;
  }

 private:
  void check_indices() const {
    const auto n = static_cast<std::int32_t>(mesh_.vertices.size());
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i)
      if (!mesh_.vertices[i].allFinite())
        throw std::invalid_argument("mesh report: vertex " + std::to_string(i) +
                                    " has a coordinate that is not finite");
    for (std::size_t k = 0; k < mesh_.triangles.size(); ++k)
      for (const std::int32_t v : mesh_.triangles[k])
        if (v < 0 || v >= n)
          throw std::invalid_argument("mesh report: triangle " + std::to_string(k) +
                                      " names vertex " + std::to_string(v) + " of " +
                                      std::to_string(n));
  }

  void measure_extent() {
    if (mesh_.vertices.empty()) return;
    report_.lower = report_.upper = mesh_.vertices[0];
    for (const Vec3& x : mesh_.vertices) {
      report_.lower = report_.lower.cwiseMin(x);
      report_.upper = report_.upper.cwiseMax(x);
    }
  }

  // place_[i]: the first vertex at the position of vertex i.
  void count_vertices() {
    const auto n = static_cast<std::int32_t>(mesh_.vertices.size());
    std::vector<std::int32_t> order(mesh_.vertices.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
      const Vec3 &xa = mesh_.vertices[a], &xb = mesh_.vertices[b];
      return xa == xb ? a < b : lexicographic(xa, xb);
    });
    place_.resize(order.size());
    for (std::int32_t i = 0; i < n; ++i) {
      const bool same = i > 0 && mesh_.vertices[order[i]] == mesh_.vertices[order[i - 1]];
      place_[order[i]] = same ? place_[order[i - 1]] : order[i];
      report_.duplicate_vertices += same;
    }
    std::vector<bool> used(order.size(), false);
    for (const Triangle& t : mesh_.triangles)
      for (const std::int32_t v : t) used[v] = true;
    report_.unused_vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
  }

  static bool has_repeated_index(const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
  }

  detail::Corners corners(std::size_t k) const { return corners(mesh_.triangles[k]); }
  detail::Corners corners(const Triangle& t) const {
    return {mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]};
  }

  void count_faces() {
    std::vector<Triangle> sorted = mesh_.triangles;
    for (Triangle& t : sorted) std::sort(t.begin(), t.end());
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t k = 1; k < sorted.size(); ++k)
      report_.duplicate_faces += sorted[k] == sorted[k - 1];
    for (std::size_t k = 0; k < mesh_.triangles.size(); ++k)
      report_.zero_area_faces += detail::has_no_area(corners(k));
  }

  std::vector<EdgeRun> sorted_runs() const {
    std::vector<EdgeRun> runs;
    runs.reserve(3 * mesh_.triangles.size());
    for (std::size_t k = 0; k < mesh_.triangles.size(); ++k) {
      const Triangle& t = mesh_.triangles[k];
      if (has_repeated_index(t)) continue;  // not a surface; counted as a face without area
      for (int i = 0; i < 3; ++i) {
        const std::int32_t a = t[i], b = t[(i + 1) % 3];
        runs.push_back({{std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(k), a < b});
      }
    }
    std::sort(runs.begin(), runs.end(), [](const EdgeRun& a, const EdgeRun& b) {
      return a.edge != b.edge ? a.edge < b.edge : a.triangle < b.triangle;
    });
    return runs;
  }

  void inspect_edges() {
    const std::vector<EdgeRun> runs = sorted_runs();
    for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
      while (end < runs.size() && runs[end].edge == runs[begin].edge) ++end;
      inspect_edge({runs.data() + begin, end - begin});
    }
  }

  void inspect_edge(std::span<const EdgeRun> runs) {
    const bool inconsistent = runs.size() == 2 && runs[0].forward == runs[1].forward;
    report_.boundary_edges += runs.size() == 1;
    report_.non_manifold_edges += runs.size() > 2;
    report_.inconsistent_edges += inconsistent;
    for (const EdgeRun& run : runs) {
      parts_.join(runs[0].triangle, run.triangle);
      if (runs.size() != 2 || inconsistent) open_[run.triangle] = true;
    }
  }

  // Six times the signed volume of the tetrahedron of triangle k and the centre.
  double volume_of(std::size_t k) const {
    const Vec3 centre = 0.5 * (report_.lower + report_.upper);
    const detail::Corners c = corners(k);
    return (c[0] - centre).dot((c[1] - centre).cross(c[2] - centre));
  }

  void inspect_parts() {
    std::vector<double> volume(mesh_.triangles.size(), 0.0);
    std::vector<bool> open(mesh_.triangles.size(), false);
    for (std::size_t k = 0; k < mesh_.triangles.size(); ++k) {
      const std::int32_t part = parts_.root(static_cast<std::int32_t>(k));
      volume[part] += volume_of(k) / 6.0;
      if (open_[k]) open[part] = true;
    }
    for (std::size_t k = 0; k < mesh_.triangles.size(); ++k) {
      if (parts_.root(static_cast<std::int32_t>(k)) != static_cast<std::int32_t>(k)) continue;
      if (has_repeated_index(mesh_.triangles[k])) continue;
      ++report_.components;
      report_.inward_components += !open[k] && volume[k] < 0.0;
    }
    if (report_.closed()) report_.volume = std::accumulate(volume.begin(), volume.end(), 0.0);
  }

  struct Crossings {
    std::size_t apart = 0, neighbours = 0;
  };

  // Common corners are found by position, so that in a mesh whose triangles own their corners not
  // every neighbour counts as a crossing. Common corners come first in both triangles.
  void judge_pair(std::size_t a, std::size_t b, Crossings& found) const {
    Triangle ta = mesh_.triangles[a], tb = mesh_.triangles[b];
    int common = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = common; j < 3; ++j)
        if (place_[ta[i]] == place_[tb[j]]) {
          std::swap(ta[i], ta[common]);
          std::swap(tb[j], tb[common++]);
          break;
        }
    const detail::Corners ca = corners(ta), cb = corners(tb);
    found.apart += common == 0 && detail::triangles_meet(ca, cb);
    found.neighbours += (common == 1 && detail::wedges_meet(ca, cb)) ||
                        (common == 2 && detail::leaves_overlap(ca, cb));
  }

  void count_self_intersections() {
    const std::size_t n = mesh_.triangles.size();
    if (n == 0) return;
    std::vector<Bounds> boxes(n);
    for (std::size_t k = 0; k < n; ++k) {
      const detail::Corners c = corners(k);
      boxes[k] = {c[0].cwiseMin(c[1]).cwiseMin(c[2]), c[0].cwiseMax(c[1]).cwiseMax(c[2])};
    }
    TriangleTree tree(mesh_.triangles);
    tree.fit(mesh_.vertices);
    std::vector<Crossings> found((n + kQueriesPerTask - 1) / kQueriesPerTask);
    parallel_for(n, kQueriesPerTask, [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a)
        tree.for_each_in_box(boxes[a].lower, boxes[a].upper, [&](std::int32_t b) {
          if (static_cast<std::size_t>(b) > a && boxes[a].overlaps(boxes[b]))
            judge_pair(a, b, found[a / kQueriesPerTask]);
        });
    });
    for (const Crossings& part : found) {
      report_.self_intersections += part.apart;
      report_.folded_neighbours += part.neighbours;
    }
  }

  const TriangleMesh& mesh_;
  MeshReport report_;
  std::vector<std::int32_t> place_;
  Parts parts_;
  std::vector<bool> open_;  // triangles with an edge that leaves their component without an inside
};

void add_sentence(std::size_t n, const char* one, const char* many,
                  std::vector<std::string>& sentences) {
  if (n == 1) sentences.push_back(std::string("1 ") + one + ".");
  if (n > 1) sentences.push_back(std::to_string(n) + " " + many + ".");
}

}  // namespace

MeshReport report_mesh(const TriangleMesh& mesh) { return MeshInspection(mesh).report(); }

std::vector<std::string> MeshReport::sentences() const {
  std::vector<std::string> s;
  if (triangles == 0) s.emplace_back("The mesh has no faces.");
  add_sentence(boundary_edges, "edge has only one face: the surface is open",
               "edges have only one face: the surface is open", s);
  add_sentence(non_manifold_edges, "edge has more than two faces: the surface branches",
               "edges have more than two faces: the surface branches", s);
  add_sentence(inconsistent_edges, "edge lies between faces of opposite orientation",
               "edges lie between faces of opposite orientation", s);
  add_sentence(duplicate_faces, "face duplicates another one", "faces duplicate another one", s);
  add_sentence(zero_area_faces, "face has no area", "faces have no area", s);
  add_sentence(duplicate_vertices, "vertex coincides with another one",
               "vertices coincide with another one", s);
  add_sentence(unused_vertices, "vertex belongs to no face", "vertices belong to no face", s);
  add_sentence(inward_components, "closed component is inside out",
               "closed components are inside out", s);
  add_sentence(self_intersections, "pair of faces crosses or touches",
               "pairs of faces cross or touch", s);
  add_sentence(folded_neighbours, "pair of neighbouring faces overlaps or touches",
               "pairs of neighbouring faces overlap or touch", s);
  return s;
}

}  // namespace selvedge
