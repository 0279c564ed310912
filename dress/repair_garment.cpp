// SPDX-License-Identifier: MIT
//
// Repair of a finished garment. First all of it near a vertex in the body is pushed out by a field
// that is smooth in space, so that folds and layers keep their order. Then a vertex of a place that
// is still bad gets a base, where the mesh around it wants
// it: the harmonic interpolation of its neighbours for a vertex that was pushed into the body or
// through a layer, its own place for the corner of a triangle that only crosses. From there it
// tries places ever farther off, out of the body or along the normal of the sheet, until its
// triangles meet nothing. All decisions are exact (find_meetings). Where no place is free, the
// vertices around join in. At last edges that are stretched too far draw in what is around them.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/body_surface.h>
#include <selvedge/dress/internal/repair_garment.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

namespace selvedge {
namespace {

constexpr std::size_t kMostPlaces = 8;  // that are named
constexpr double kNoDirection = 1e-3;   // of the gap; nearer points have no direction
constexpr double kFirstReach = 8.0;     // in which the skin is looked for, in gaps
constexpr int kTaut = 2;                // the first of them in which the cloth is pulled taut
constexpr int kTries = 14;              // places of a vertex in each of them
constexpr double kFartherOut = 1.4;     // factor of the distance from the body from try to try
constexpr double kFarthest = 2.0;       // of it, in mean edges: beyond, a vertex is a spike
constexpr int kPushes = 24;             // steps out of the body
constexpr double kPushStep = 0.25;      // the longest of them, in mean edges
constexpr double kPushReach = 2.5;      // of the field that moves along, in mean edges
constexpr int kMostFarther = 6;         // tries farther out in these steps
constexpr double kSpike = 2.0;          // factor of its edges at which a vertex has lost its place
constexpr std::size_t kAlone = 3;       // of so many neighbours at most one is in the body, too
constexpr int kRelaxations = 40;        // of edges that are stretched too far
constexpr double kRelaxed = 0.9;        // of the limit, to which they are drawn
constexpr double kShare = 0.25;         // of what such an edge is too long by, for each of its ends
constexpr int kIterations = 200;        // of the interpolation
constexpr double kResidual = 1e-6;      // of its start, at which it ends

/// The mesh of a garment in which vertices at equal positions are one.
struct Welded {
  explicit Welded(const TriangleMesh& mesh) {
    const auto before = [](const Vec3& p, const Vec3& q) {
      return std::lexicographical_compare(p.begin(), p.end(), q.begin(), q.end());
    };
    std::map<Vec3, std::int32_t, decltype(before)> found(before);
    for (const Vec3& p : mesh.vertices) {
      const auto [at, is_new] = found.try_emplace(p, static_cast<std::int32_t>(x.size()));
      if (is_new) x.push_back(p);
      number.push_back(at->second);
    }
    for (const Triangle& t : mesh.triangles) {
      const Triangle w{number[t[0]], number[t[1]], number[t[2]]};
      if (w[0] != w[1] && w[1] != w[2] && w[2] != w[0]) triangles.push_back(w);
    }
  }

  std::vector<Vec3> x;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> number;  // of each vertex of the file
};

class Repair {
 public:
  Repair(const TriangleMesh& garment, const TriangleMesh& body, const RepairConfig& config)
      : body_(body),
        config_(config),
        mesh_(garment),
        start_(mesh_.x),
        skin_(body),
        edges_(unique_edges(mesh_.triangles)),
        body_edges_(unique_edges(body.triangles)),
        neighbours_(mesh_.x.size()),
        role_(mesh_.x.size(), Role::fixed),
        was_inside_(mesh_.x.size(), 0),
        base_(mesh_.x),
        out_(mesh_.x.size(), 0),
        aside_(mesh_.x.size(), 0) {
    for (const auto& [a, b] : edges_) {
      neighbours_[a].push_back(b);
      neighbours_[b].push_back(a);
      mean_edge_ += (mesh_.x[a] - mesh_.x[b]).norm();
    }
    mean_edge_ /= static_cast<double>(std::max<std::size_t>(1, edges_.size()));
    find_around();
  }

  RepairResult run() {
    RepairResult result;
    Faults faults = find();
    result.body_before = static_cast<std::int64_t>(faults.body.size());
    result.self_before = static_cast<std::int64_t>(faults.self.size());
    result.inside = static_cast<std::int64_t>(faults.inside.size());
    if (!faults.none()) {
      choose(faults);
      fill(false);
      mesh_.x = base_;
      faults = find();
      push_out(faults);
      lose_place(faults);
    }
    for (int growth = 0; growth < config_.rounds && !faults.none(); ++growth) {
      if (growth > 0) grow(faults);
      fill(growth >= kTaut);
      for (int k = 0; k < kTries && !faults.none(); ++k) {
        place(k == 0 ? nullptr : &faults);
        faults = find();
      }
    }
    if (result.body_before + result.self_before + result.inside > 0 && faults.none()) relax();
    report(faults, result);
    return result;
  }

 private:
  enum class Role { fixed, own, filled };

  /// The neighbours with which a vertex is smooth: on a border those along it.
  void find_around() {
    around_ = neighbours_;
    const TrianglesOfEdges triangles(edges_, mesh_.triangles);
    std::vector<char> is_border(mesh_.x.size(), 0);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (triangles.at(static_cast<std::int32_t>(e)).size() != 1) continue;
      for (int k = 0; k < 2; ++k) {
        const std::int32_t v = edges_[e][k];
        if (!is_border[v]) around_[v].clear();
        is_border[v] = 1;
        around_[v].push_back(edges_[e][1 - k]);
      }
    }
  }

  /// What is wrong in a state.
  struct Faults {
    std::vector<TrianglePair> body, self;  // of the garment and the body; of the garment
    std::vector<std::int32_t> inside;      // vertices

    bool none() const { return body.empty() && self.empty() && inside.empty(); }
  };

  Faults find() {
    Faults faults;
    faults.body =
        find_meetings({mesh_.x, mesh_.triangles}, {body_.vertices, body_.triangles}).all();
    faults.self = find_meetings(mesh_.x, mesh_.triangles).all();
    faults.inside = inside_vertices();
    return faults;
  }

  /// Edges that do not meet the body join vertices on the same side of it, so one winding number
  /// decides for all of them.
  std::vector<std::int32_t> inside_vertices() {
    std::vector<EdgeTrianglePair> met;
    edge_test_.find(
        {.x_t0 = mesh_.x, .x_t1 = mesh_.x, .edges = edges_, .triangles = mesh_.triangles},
        {.x_t0 = body_.vertices,
         .x_t1 = body_.vertices,
         .edges = body_edges_,
         .triangles = body_.triangles},
        met);
    std::vector<char> is_met(edges_.size(), 0);
    for (const EdgeTrianglePair& pair : met) is_met[pair.edge] = 1;
    std::vector<std::int32_t> root(mesh_.x.size());
    std::iota(root.begin(), root.end(), 0);
    const auto root_of = [&](std::int32_t v) {
      while (root[v] != v) v = root[v] = root[root[v]];
      return v;
    };
    for (std::size_t e = 0; e < edges_.size(); ++e)
      if (!is_met[e]) {
        const std::int32_t a = root_of(edges_[e][0]), b = root_of(edges_[e][1]);
        root[std::max(a, b)] = std::min(a, b);
      }
    std::vector<std::int32_t> inside;
    std::vector<char> is_inside(mesh_.x.size(), 0);
    for (std::size_t i = 0; i < mesh_.x.size(); ++i) {
      const auto v = static_cast<std::int32_t>(i);
      const std::int32_t r = root_of(v);
      if (neighbours_[i].empty()) continue;
      is_inside[i] = r == v ? static_cast<char>(skin_.is_inside(mesh_.x[i])) : is_inside[r];
      if (is_inside[i]) inside.push_back(v);
    }
    return inside;
  }

  /// The vertices to move: those in the body, and the corners of triangles that meet something
  /// although none of theirs is. A vertex far from its neighbours, or in the
  /// body almost without them, has lost its place.
  void choose(const Faults& faults) {
    std::vector<char>& is_inside = was_inside_;
    for (const std::int32_t v : faults.inside) is_inside[v] = 1;
    const std::vector<double> outside = edges_outside(is_inside);
    for (const std::int32_t v : faults.inside) {
      double length = 0.0, around = 0.0;
      std::size_t known = 0, inside = 0;
      for (const std::int32_t w : neighbours_[v]) {
        length += (mesh_.x[v] - mesh_.x[w]).norm();
        around += outside[w];
        known += outside[w] > 0.0 ? 1 : 0;
        inside += is_inside[w] ? 1 : 0;
      }
      const std::size_t count = neighbours_[v].size();
      length /= static_cast<double>(count);
      around = known > 0 ? around / static_cast<double>(known) : mean_edge_;
      const bool is_alone = kAlone * inside <= count;
      role_[v] = is_alone || length > kSpike * around ? Role::filled : Role::own;
    }
    const auto explained = [&](std::int32_t triangle) {
      const Triangle& t = mesh_.triangles[triangle];
      return std::any_of(t.begin(), t.end(), [&](std::int32_t v) { return is_inside[v] != 0; });
    };
    for (const TrianglePair& pair : faults.body)
      if (!explained(pair.triangle_a))
        for (const std::int32_t v : mesh_.triangles[pair.triangle_a]) role_[v] = Role::own;
    std::vector<TrianglePair> left = faults.self;
    std::erase_if(left, [&](const TrianglePair& pair) {
      return explained(pair.triangle_a) || explained(pair.triangle_b);
    });
    choose_of_layers(std::move(left));
  }

  /// Of layers that cross away from the body, the corners that stand out the most from the vertices
  /// around them have lost their places: each explains the pairs of all its triangles.
  void choose_of_layers(std::vector<TrianglePair> left) {
    std::set<std::pair<double, std::int32_t>, std::greater<>> corners;  // by how far they stand out
    for (const TrianglePair& pair : left)
      for (const std::int32_t t : {pair.triangle_a, pair.triangle_b})
        for (const std::int32_t v : mesh_.triangles[t]) {
          Vec3 mean = Vec3::Zero();
          for (const std::int32_t w : around_[v]) mean += mesh_.x[w];
          mean /= static_cast<double>(std::max<std::size_t>(1, around_[v].size()));
          corners.insert({(mesh_.x[v] - mean).norm(), v});
        }
    for (const auto& [out, v] : corners) {
      const auto has_corner = [&, corner = v](std::int32_t triangle) {
        const Triangle& t = mesh_.triangles[triangle];
        return std::find(t.begin(), t.end(), corner) != t.end();
      };
      const std::size_t explained = std::erase_if(left, [&](const TrianglePair& pair) {
        return has_corner(pair.triangle_a) || has_corner(pair.triangle_b);
      });
      if (explained > 0) role_[v] = Role::filled;
    }
  }

  /// Pushes the garment out of the body in small steps. All of it near a vertex that has to go
  /// moves along, by a field that is smooth in space: a fold above such a vertex does not meet it.
  void push_out(Faults& faults) {
    const double most = kPushStep * mean_edge_;
    std::vector<int> tries(mesh_.x.size(), 0);
    for (int k = 0; k < kPushes && !(faults.body.empty() && faults.inside.empty()); ++k) {
      std::vector<std::int32_t> pushed;
      std::vector<Vec3> by;
      for (const auto& [v, is_inside] : to_push(faults)) {
        if (!is_inside && tries[v] < kMostFarther) ++tries[v];
        const Vec3 to = out_of_body(mesh_.x[v], clearance(tries[v]));
        const Vec3 way = to - mesh_.x[v];
        pushed.push_back(v);
        by.push_back(way.norm() > most ? Vec3(most * way.normalized()) : way);
      }
      carry(pushed, by);
      faults = find();
    }
  }

  /// From the body, m, that a vertex gets in a try.
  double clearance(int tries) const {
    const double most = std::max(config_.clearance, kFarthest * mean_edge_);
    double distance = config_.clearance;
    for (int k = 0; k < tries && distance < most; ++k) distance *= kFartherOut;
    return std::min(distance, most);
  }

  /// The vertices in the body, and the corners of triangles that cross it although none is inside:
  /// the body passes between them.
  std::map<std::int32_t, bool> to_push(const Faults& faults) const {
    std::map<std::int32_t, bool> found;
    for (const std::int32_t v : faults.inside) found[v] = true;
    std::set<std::int32_t> corners;
    for (const TrianglePair& pair : faults.body) {
      const Triangle& t = mesh_.triangles[pair.triangle_a];
      if (std::none_of(t.begin(), t.end(), [&](std::int32_t v) { return found.contains(v); }))
        corners.insert(t.begin(), t.end());
    }
    for (const std::int32_t v : corners) found[v] = false;
    return found;
  }

  /// Moves all vertices by the field u(p) = Σ wᵢ uᵢ / max(1, Σ wᵢ) with wᵢ = (1 - |p - pᵢ|²/R²)².
  void carry(const std::vector<std::int32_t>& pushed, const std::vector<Vec3>& by) {
    const double reach = kPushReach * mean_edge_;
    using Cell = std::array<std::int64_t, 3>;
    const auto cell_of = [&](const Vec3& p) {
      Cell cell;
      for (int k = 0; k < 3; ++k) cell[k] = static_cast<std::int64_t>(std::floor(p[k] / reach));
      return cell;
    };
    std::map<Cell, std::vector<std::size_t>> cells;  // the pushed vertices in and around each
    for (std::size_t i = 0; i < pushed.size(); ++i) {
      const Cell c = cell_of(mesh_.x[pushed[i]]);
      for (std::int64_t k = 0; k < 27; ++k)
        cells[{c[0] + k / 9 - 1, c[1] + k / 3 % 3 - 1, c[2] + k % 3 - 1}].push_back(i);
    }
    std::vector<Vec3> moved = mesh_.x;
    for (std::size_t v = 0; v < mesh_.x.size(); ++v) {
      const auto found = cells.find(cell_of(mesh_.x[v]));
      if (found == cells.end()) continue;
      Vec3 sum = Vec3::Zero();
      double weight = 0.0;
      for (const std::size_t i : found->second) {
        const double d = (mesh_.x[v] - mesh_.x[pushed[i]]).squaredNorm() / (reach * reach);
        const double w = d < 1.0 ? (1.0 - d) * (1.0 - d) : 0.0;
        sum += w * by[i];
        weight += w;
      }
      moved[v] += sum / std::max(1.0, weight);
    }
    mesh_.x = std::move(moved);
  }

  /// The nearest place at least `gap` above the skin, as far as the skin is flat.
  Vec3 out_of_body(const Vec3& p, double gap) const {
    const detail::BodySurface::Nearest near = skin_.nearest(p, kFirstReach * gap);
    const bool inside = skin_.is_inside(p);
    if (!inside && near.distance >= gap) return p;
    Vec3 way = inside ? Vec3(near.point - p) : Vec3(p - near.point);
    if (near.distance < kNoDirection * gap) way = skin_.normal(near.triangle);
    return near.point + gap * way.stableNormalized();
  }

  /// Vertices that came out of the body but below another layer have lost their places, too.
  void lose_place(const Faults& faults) {
    for (const std::int32_t v : at_fault(faults).second)
      if (was_inside_[v]) role_[v] = Role::filled;
  }

  /// Mean length of the edges of each vertex without an end in the body, m; 0: it has none.
  std::vector<double> edges_outside(const std::vector<char>& is_inside) const {
    std::vector<double> sum(mesh_.x.size(), 0.0);
    std::vector<int> count(mesh_.x.size(), 0);
    for (const auto& [a, b] : edges_) {
      if (is_inside[a] || is_inside[b]) continue;
      for (const std::int32_t v : {a, b}) {
        sum[v] += (mesh_.x[a] - mesh_.x[b]).norm();
        ++count[v];
      }
    }
    for (std::size_t v = 0; v < sum.size(); ++v) sum[v] /= std::max(1, count[v]);
    return sum;
  }

  /// Vertices at a place that is still bad, and their neighbours, are interpolated together.
  void grow(const Faults& faults) {
    const auto [with_body, with_self] = at_fault(faults);
    std::set<std::int32_t> grown(with_body);
    grown.insert(with_self.begin(), with_self.end());
    for (const std::int32_t v : std::set<std::int32_t>(grown))
      grown.insert(neighbours_[v].begin(), neighbours_[v].end());
    for (const std::int32_t v : grown) {
      role_[v] = Role::filled;
      out_[v] = aside_[v] = 0;
    }
  }

  /// Vertices of triangles that meet the body or are in it, and of those that meet the garment.
  std::pair<std::set<std::int32_t>, std::set<std::int32_t>> at_fault(const Faults& faults) const {
    std::set<std::int32_t> with_body(faults.inside.begin(), faults.inside.end()), with_self;
    for (const TrianglePair& pair : faults.body)
      for (const std::int32_t v : mesh_.triangles[pair.triangle_a]) with_body.insert(v);
    for (const TrianglePair& pair : faults.self)
      for (const std::int32_t t : {pair.triangle_a, pair.triangle_b})
        for (const std::int32_t v : mesh_.triangles[t]) with_self.insert(v);
    return {with_body, with_self};
  }

  /// Gives each of the vertices the mean of its neighbours that have a base, ring by ring. Returns
  /// for each vertex of the garment whether it has one.
  std::vector<char> start_from_fixed(const std::vector<std::int32_t>& filled) {
    std::vector<char> known(role_.size(), 1);
    for (const std::int32_t v : filled) known[v] = 0;
    for (std::vector<std::int32_t> left = filled; !left.empty();) {
      std::vector<std::pair<std::int32_t, Vec3>> found;
      for (const std::int32_t v : left) {
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for (const std::int32_t w : neighbours_[v])
          if (known[w]) {
            sum += base_[w];
            ++count;
          }
        if (count > 0) found.emplace_back(v, sum / count);
      }
      if (found.empty()) break;  // a whole part of the garment
      for (const auto& [v, x] : found) {
        base_[v] = x;
        known[v] = 1;
      }
      std::erase_if(left, [&](std::int32_t v) { return known[v] != 0; });
    }
    return known;
  }

  /// Interpolates the filled vertices: the surface that minimizes Σ |xᵥ - mean of its neighbours|²,
  /// which goes on with the folds around it, or, if it is taut, the sum of the squares of its
  /// edges. By conjugate gradients.
  void fill(bool taut) {
    std::vector<std::int32_t> filled;
    for (std::size_t v = 0; v < role_.size(); ++v) {
      base_[v] = mesh_.x[v];
      if (role_[v] == Role::filled) filled.push_back(static_cast<std::int32_t>(v));
    }
    const std::vector<char> known = start_from_fixed(filled);
    std::erase_if(filled, [&](std::int32_t v) { return known[v] == 0; });
    std::set<std::int32_t> rows(filled.begin(), filled.end());
    if (!taut)
      for (const std::int32_t v : filled) rows.insert(neighbours_[v].begin(), neighbours_[v].end());
    const auto add_gradient = [&](const std::vector<Vec3>& x, std::vector<Vec3>& gradient) {
      if (taut)
        add_gradient_of_edges(filled, x, gradient);
      else
        add_gradient_of_bends(rows, x, gradient);
    };
    std::vector<Vec3> r(base_.size(), Vec3::Zero()), d(r), q(r);
    const auto dot = [&](const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
      double sum = 0.0;
      for (const std::int32_t v : filled) sum += a[v].dot(b[v]);
      return sum;
    };
    add_gradient(base_, r);
    for (const std::int32_t v : filled) d[v] = r[v] = -r[v];
    double square = dot(r, r);
    const double small = square * kResidual * kResidual;
    for (int k = 0; k < kIterations && square > small; ++k) {
      std::fill(q.begin(), q.end(), Vec3::Zero());
      add_gradient(d, q);
      const double step = square / dot(d, q);
      for (const std::int32_t v : filled) {
        base_[v] += step * d[v];
        r[v] -= step * q[v];
      }
      const double next = dot(r, r);
      for (const std::int32_t v : filled) d[v] = r[v] + next / square * d[v];
      square = next;
    }
  }

  /// Adds half the gradient of Σ |xᵥ - mean of its neighbours|² over the rows.
  void add_gradient_of_bends(const std::set<std::int32_t>& rows, const std::vector<Vec3>& x,
                             std::vector<Vec3>& gradient) const {
    for (const std::int32_t v : rows) {
      const std::vector<std::int32_t>& around = around_[v];
      if (around.empty()) continue;
      Vec3 bend = Vec3::Zero();
      for (const std::int32_t w : around) bend += x[w];
      bend = x[v] - bend / static_cast<double>(around.size());
      gradient[v] += bend;
      for (const std::int32_t w : around) gradient[w] -= bend / static_cast<double>(around.size());
    }
  }

  /// The same of Σ |xᵥ - xᵤ|² over the edges, for the filled vertices.
  void add_gradient_of_edges(const std::vector<std::int32_t>& filled, const std::vector<Vec3>& x,
                             std::vector<Vec3>& gradient) const {
    for (const std::int32_t v : filled)
      for (const std::int32_t w : neighbours_[v]) gradient[v] += x[v] - x[w];
  }

  /// Moves the vertices that are not fixed: all to their bases, or those at fault to the next try.
  void place(const Faults* faults) {
    std::set<std::int32_t> with_body, with_self;
    if (faults) std::tie(with_body, with_self) = at_fault(*faults);
    std::vector<std::int32_t> moving;
    for (std::size_t i = 0; i < role_.size(); ++i) {
      const auto v = static_cast<std::int32_t>(i);
      if (role_[i] == Role::fixed) continue;
      if (with_body.contains(v))
        ++out_[i];
      else if (with_self.contains(v))
        ++aside_[i];
      else if (faults)
        continue;
      moving.push_back(v);
    }
    const std::vector<Vec3> normals = vertex_normals(base_, mesh_.triangles);
    for (const std::int32_t v : moving) {
      const int k = aside_[v];  // 0, +1, -1, +2, -2 ...
      const double aside = std::clamp(config_.clearance * (k % 2 == 1 ? (k + 1) / 2 : -k / 2),
                                      -kFarthest * mean_edge_, kFarthest * mean_edge_);
      mesh_.x[v] = out_of_body(base_[v] + aside * normals[v], clearance(out_[v]));
    }
  }

  /// Of an edge, relative to its length in the file.
  double stretch(const Edge& e) const {
    const double before = (start_[e[0]] - start_[e[1]]).norm();
    return (mesh_.x[e[0]] - mesh_.x[e[1]]).norm() / before - 1.0;
  }

  /// Draws the ends of edges that are stretched too far together, as long as nothing meets: a
  /// vertex that would meet something keeps its place.
  void relax() {
    const auto is_far = [&](const Edge& e) { return stretch(e) > config_.wearable_stretch; };
    for (int k = 0; k < kRelaxations && std::ranges::any_of(edges_, is_far); ++k) {
      const std::vector<Vec3> before = mesh_.x;
      std::vector<Vec3> way(mesh_.x.size(), Vec3::Zero());
      for (const Edge& e : edges_) {
        const Vec3 along = mesh_.x[e[1]] - mesh_.x[e[0]];
        const double allowed =
            (1.0 + kRelaxed * config_.wearable_stretch) * (start_[e[1]] - start_[e[0]]).norm();
        if (along.norm() <= allowed) continue;
        const Vec3 by = kShare * (1.0 - allowed / along.norm()) * along;
        way[e[0]] += by;
        way[e[1]] -= by;
      }
      for (std::size_t v = 0; v < way.size(); ++v)
        if (!way[v].isZero(0.0)) mesh_.x[v] = out_of_body(mesh_.x[v] + way[v], config_.clearance);
      for (Faults faults = find(); !faults.none(); faults = find()) {
        const auto [with_body, with_self] = at_fault(faults);
        for (const std::int32_t v : with_body) mesh_.x[v] = before[v];
        for (const std::int32_t v : with_self) mesh_.x[v] = before[v];
      }
    }
  }

  void report(const Faults& faults, RepairResult& result) const {
    result.body_after = static_cast<std::int64_t>(faults.body.size());
    result.self_after = static_cast<std::int64_t>(faults.self.size());
    result.inside_after = static_cast<std::int64_t>(faults.inside.size());
    std::vector<double> motion;
    for (std::size_t v = 0; v < mesh_.x.size(); ++v) {
      const double by = (mesh_.x[v] - start_[v]).norm();
      result.moved += by > 0.0 ? 1 : 0;
      result.largest_motion = std::max(result.largest_motion, by);
      if (!was_inside_[v]) motion.push_back(by);
    }
    if (!motion.empty()) {
      const auto middle = motion.begin() + static_cast<std::ptrdiff_t>(motion.size() / 2);
      std::nth_element(motion.begin(), middle, motion.end());
      result.median_motion = *middle;
    }
    const auto [with_body, with_self] = at_fault(faults);
    std::vector<char> marked(mesh_.x.size(), 0);
    for (const std::int32_t v : with_body) marked[v] = 1;
    for (const std::int32_t v : with_self) marked[v] = 1;
    result.left = places(marked, &RepairPlace::vertices);
    for (const Edge& e : edges_) {
      const double by = stretch(e);
      result.max_stretch = std::max(result.max_stretch, by);
      if (by > config_.wearable_stretch) marked[e[0]] = marked[e[1]] = 1;
    }
    result.stretched = places(marked, &RepairPlace::stretch);
    for (const std::int32_t n : mesh_.number) result.x.push_back(mesh_.x[n]);
  }

  /// The connected parts of marked vertices with the greatest sizes, at their most stretched
  /// vertices; unmarks all.
  template <class Size>
  std::vector<RepairPlace> places(std::vector<char>& marked, Size RepairPlace::*size) const {
    std::vector<RepairPlace> found;
    for (std::size_t first = 0; first < marked.size(); ++first) {
      if (!marked[first]) continue;
      RepairPlace place{.at = mesh_.x[first]};
      std::vector<std::int32_t> open = {static_cast<std::int32_t>(first)};
      marked[first] = 0;
      while (!open.empty()) {
        const std::int32_t v = open.back();
        open.pop_back();
        ++place.vertices;
        for (const std::int32_t w : neighbours_[v]) {
          if (const double by = stretch({v, w}); by > place.stretch) {
            place.stretch = by;
            place.at = mesh_.x[v];
          }
          if (marked[w]) {
            marked[w] = 0;
            open.push_back(w);
          }
        }
      }
      found.push_back(place);
    }
    std::stable_sort(found.begin(), found.end(),
                     [&](const RepairPlace& a, const RepairPlace& b) { return a.*size > b.*size; });
    if (found.size() > kMostPlaces) found.resize(kMostPlaces);
    return found;
  }

  const TriangleMesh& body_;
  const RepairConfig& config_;
  Welded mesh_;
  std::vector<Vec3> start_;  // m
  detail::BodySurface skin_;
  std::vector<Edge> edges_, body_edges_;
  EdgeTriangleTest edge_test_;
  std::vector<std::vector<std::int32_t>> neighbours_, around_;
  std::vector<Role> role_;
  std::vector<char> was_inside_;
  std::vector<Vec3> base_;        // m
  std::vector<int> out_, aside_;  // tries of each vertex
  double mean_edge_ = 0.0;        // m
};

}  // namespace

RepairResult repair_garment(const TriangleMesh& garment, const TriangleMesh& body,
                            const RepairConfig& config) {
  require(config.clearance > 0.0 && std::isfinite(config.clearance), "clearance", config.clearance,
          "positive and finite");
  require(config.rounds >= 1, "rounds", config.rounds, "at least 1");
  if (garment.triangles.empty()) throw std::invalid_argument("the garment has no triangles");
  if (body.triangles.empty()) throw std::invalid_argument("the body has no triangles");
  return Repair(garment, body, config).run();
}

}  // namespace selvedge
