// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/limb_search.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace selvedge::detail {
namespace {

/// Maximum number of slabs of one cut. A slab is also at least a few edges high, otherwise a ring
/// of edges would fall into pieces.
constexpr int kMostSlabs = 48;
constexpr double kEdgesPerSlab = 3.0;
/// Maximum depth of repeated cuts of a limb: trunk with arms -> arms -> hands.
constexpr int kMostCuts = 3;
/// A limb has at least this many vertices, and at least a fixed fraction of the part that it is cut
/// from; a smaller one joins its neighbour.
constexpr std::size_t kLeastVertices = 48;
constexpr std::size_t kLeastPart = 32;
/// A piece with less than 1/kBumpPart of the vertices of a mean slab is a bump, not a branch.
constexpr std::size_t kBumpPart = 16;
/// Neighbours whose thicknesses differ by more than this factor are separate limbs, such as
/// shoulder and arm, or head and neck.
constexpr double kStep = 2.0;

using Link = std::pair<std::int32_t, std::int32_t>;

/// Disjoint sets with union; the lowest member identifies a set.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  std::int32_t find(std::int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// Makes i a set of its own; call it for all members of a set.
  void reset(std::int32_t i) { parent_[i] = i; }
  void unite(std::int32_t i, std::int32_t j) {
    i = find(i);
    j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<std::int32_t> parent_;
};

/// Positions of some of the vertices, moved and scaled into a cube of side 2, so that squares
/// neither overflow nor underflow.
struct Scaled {
  Vec3 middle = Vec3::Zero();
  double size = 0.0;

  Scaled(std::span<const Vec3> x, std::span<const std::int32_t> vertices) {
    if (vertices.empty()) return;
    Vec3 lo = x[vertices[0]], hi = lo;
    for (const std::int32_t v : vertices) {
      lo = lo.cwiseMin(x[v]);
      hi = hi.cwiseMax(x[v]);
    }
    middle = 0.5 * lo + 0.5 * hi;
    size = (0.5 * hi - 0.5 * lo).maxCoeff();
  }
  bool is_point() const { return !(size > 0.0); }
  Vec3 operator()(const Vec3& x) const { return (x - middle) / size; }
};

/// A connected piece of a slab.
struct Piece {
  std::size_t vertices = 0;
  Vec3 sum = Vec3::Zero();  ///< of scaled positions without their component along the axis
  double squares = 0.0;

  void add(const Vec3& across) {
    ++vertices;
    sum += across;
    squares += across.squaredNorm();
  }
  /// Root of the mean squared distance from the middle.
  double thickness() const {
    const auto n = static_cast<double>(vertices);
    return std::sqrt(std::max(0.0, squares / n - (sum / n).squaredNorm()));
  }
};

/// A part of the surface: its vertices and the edges between them.
struct Part {
  std::vector<std::int32_t> vertices;
  std::vector<Edge> edges;
};

class LimbSearch {
 public:
  LimbSearch(const SurfaceView& surface, const Vec3& axis)
      : surface_(surface),
        axis_(axis),
        connected_(surface.x_t0.size()),
        label_(surface.x_t0.size()),
        slab_(surface.x_t0.size()) {
    limbs_.of_vertex.assign(surface.x_t0.size(), 0);
  }

  Limbs run() {
    Part all;
    all.vertices.resize(surface_.x_t0.size());
    std::iota(all.vertices.begin(), all.vertices.end(), 0);
    all.edges.assign(surface_.edges.begin(), surface_.edges.end());
    if (all.edges.empty())
      for (const Triangle& t : surface_.triangles)
        for (const int k : {0, 1, 2}) all.edges.push_back({t[k], t[(k + 1) % 3]});
    if (!all.vertices.empty()) split(std::move(all), kMostCuts);
    return std::move(limbs_);
  }

 private:
  void split(Part part, int cuts) {
    if (cuts == 0 || part.vertices.size() < 2 * kLeastVertices || !lay_slabs(part))
      return finish(part.vertices);
    label_pieces(part);
    const std::vector<Link> links = linked_pieces(part);
    const std::vector<std::int32_t> group = group_pieces(part, links);
    const std::int32_t groups = *std::max_element(group.begin(), group.end()) + 1;
    if (groups == 1) return finish(part.vertices);
    std::vector<Part> below(groups);
    for (const std::int32_t v : part.vertices)
      below[group_of_vertex(group, v)].vertices.push_back(v);
    for (const Edge& e : part.edges)
      if (group_of_vertex(group, e[0]) == group_of_vertex(group, e[1]))
        below[group_of_vertex(group, e[0])].edges.push_back(e);
    const bool has_rest = rest_ >= 0;
    const std::int32_t rest = rest_;
    part = {};
    for (std::int32_t g = 0; g < groups; ++g)
      split(std::move(below[g]), has_rest && g == rest ? 0 : cuts - 1);
  }

  void finish(const std::vector<std::int32_t>& vertices) {
    for (const std::int32_t v : vertices) limbs_.of_vertex[v] = limbs_.count;
    ++limbs_.count;
  }

  std::int32_t group_of_vertex(const std::vector<std::int32_t>& group, std::int32_t v) const {
    return group[label_[v]];
  }

  /// Assigns a slab to each vertex; returns false if there would be only one.
  bool lay_slabs(const Part& part) {
    const std::span<const Vec3> x = surface_.x_t0;
    scaled_ = Scaled(x, part.vertices);
    if (scaled_.is_point()) return false;
    direction_ = axis_.isZero() ? longest_axis(surface_, part.vertices) : axis_;
    double lo = std::numeric_limits<double>::infinity(), hi = -lo, edges = 0.0;
    for (const std::int32_t v : part.vertices) {
      const double s = direction_.dot(scaled_(x[v]));
      lo = std::min(lo, s);
      hi = std::max(hi, s);
    }
    if (!(hi > lo)) return false;
    for (const Edge& e : part.edges) edges += (scaled_(x[e[0]]) - scaled_(x[e[1]])).norm();
    const double mean_edge = edges / std::max<double>(1.0, static_cast<double>(part.edges.size()));
    const double wanted = (hi - lo) / (kEdgesPerSlab * mean_edge);
    slabs_ = wanted < kMostSlabs ? static_cast<int>(wanted) : kMostSlabs;
    if (slabs_ < 2) return false;
    for (const std::int32_t v : part.vertices) {
      const double at = (direction_.dot(scaled_(x[v])) - lo) / (hi - lo) * slabs_;
      slab_[v] = std::min(static_cast<int>(at), slabs_ - 1);
    }
    return true;
  }

  /// Numbers the connected pieces of slabs (label_ of each vertex) and measures them.
  void label_pieces(const Part& part) {
    for (const std::int32_t v : part.vertices) connected_.reset(v);
    for (const Edge& e : part.edges)
      if (slab_[e[0]] == slab_[e[1]]) connected_.unite(e[0], e[1]);
    pieces_.clear();
    for (const std::int32_t v : part.vertices) {  // In ascending order: the lowest member comes
                                                  // first.
      const std::int32_t name = connected_.find(v);
      if (name == v) {
        label_[v] = static_cast<std::int32_t>(pieces_.size());
        pieces_.emplace_back();
      } else {
        label_[v] = label_[name];
      }
      const Vec3 y = scaled_(surface_.x_t0[v]);
      pieces_[label_[v]].add(y - direction_ * direction_.dot(y));
    }
  }

  /// Pairs of pieces that an edge connects, the one in the lower slab first.
  std::vector<Link> linked_pieces(const Part& part) const {
    std::vector<Link> links;
    for (const Edge& e : part.edges) {
      const auto [low, high] = slab_[e[0]] < slab_[e[1]] ? Link(e[0], e[1]) : Link(e[1], e[0]);
      if (label_[low] != label_[high]) links.emplace_back(label_[low], label_[high]);
    }
    std::sort(links.begin(), links.end());
    links.erase(std::unique(links.begin(), links.end()), links.end());
    return links;
  }

  /// The group of each piece; rest_ is the group of the unconnected small pieces, or -1.
  std::vector<std::int32_t> group_pieces(const Part& part, const std::vector<Link>& links) {
    DisjointSets sets(pieces_.size());
    const std::size_t bump = part.vertices.size() / (static_cast<std::size_t>(slabs_) * kBumpPart);
    join_chains(links, bump, sets);
    // Bumps first, then whole chains that are too short for a limb.
    join_small(links, bump, sets);
    join_small(links, std::max(kLeastVertices, part.vertices.size() / kLeastPart), sets);
    return number_groups(part, sets);
  }

  void join_chains(const std::vector<Link>& links, std::size_t bump, DisjointSets& sets) const {
    const auto counts = [&](const Link& l) {
      return pieces_[l.first].vertices > bump && pieces_[l.second].vertices > bump;
    };
    std::vector<int> above(pieces_.size()), below(pieces_.size());
    for (const Link& l : links)
      if (counts(l)) {
        ++above[l.first];
        ++below[l.second];
      }
    for (const Link& l : links) {
      if (!counts(l) || above[l.first] != 1 || below[l.second] != 1) continue;
      const double a = pieces_[l.first].thickness(), b = pieces_[l.second].thickness();
      if (a <= kStep * b && b <= kStep * a) sets.unite(l.first, l.second);
    }
  }

  /// Joins groups of at most `small` vertices to the largest group linked to them, until none is
  /// left.
  void join_small(const std::vector<Link>& links, std::size_t small, DisjointSets& sets) const {
    for (bool joined = true; joined;) {
      joined = false;
      const std::vector<std::size_t> size = sizes(sets);
      std::vector<std::int32_t> best(pieces_.size(), -1);
      for (const Link& l : links) {
        const std::int32_t a = sets.find(l.first), b = sets.find(l.second);
        if (a == b) continue;
        if (best[a] < 0 || size[b] > size[best[a]]) best[a] = b;
        if (best[b] < 0 || size[a] > size[best[b]]) best[b] = a;
      }
      for (std::size_t i = 0; i < pieces_.size(); ++i)
        if (best[i] >= 0 && size[i] <= small) {
          sets.unite(static_cast<std::int32_t>(i), best[i]);
          joined = true;
        }
    }
  }

  std::vector<std::size_t> sizes(DisjointSets& sets) const {
    std::vector<std::size_t> size(pieces_.size(), 0);
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      size[sets.find(static_cast<std::int32_t>(i))] += pieces_[i].vertices;
    return size;
  }

  std::vector<std::int32_t> number_groups(const Part& part, DisjointSets& sets) {
    const std::vector<std::size_t> size = sizes(sets);
    const std::size_t least = std::max(kLeastVertices, part.vertices.size() / kLeastPart);
    std::vector<std::int32_t> group(pieces_.size(), -1);
    std::int32_t groups = 0;
    rest_ = -1;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const std::int32_t root = sets.find(static_cast<std::int32_t>(i));
      if (group[root] < 0 && size[root] > least) group[root] = groups++;
      if (group[root] < 0) {
        if (rest_ < 0) rest_ = groups++;
        group[root] = rest_;
      }
      group[i] = group[root];
    }
    return group;
  }

  const SurfaceView& surface_;
  Vec3 axis_;
  Limbs limbs_;
  // Of the current cut, for its vertices only.
  DisjointSets connected_;
  std::vector<std::int32_t> label_;
  std::vector<int> slab_;
  Scaled scaled_{{}, {}};
  Vec3 direction_ = Vec3::UnitX();
  int slabs_ = 0;
  std::vector<Piece> pieces_;
  std::int32_t rest_ = -1;
};

}  // namespace

Limbs find_limbs(const SurfaceView& surface, const Vec3& axis) {
  return LimbSearch(surface, axis).run();
}

Limbs one_limb(const SurfaceView& surface) {
  return {std::vector<std::int32_t>(surface.x_t0.size(), 0), surface.x_t0.empty() ? 0 : 1};
}

Vec3 longest_axis(const SurfaceView& surface, std::span<const std::int32_t> vertices) {
  const Scaled scaled(surface.x_t0, vertices);
  if (scaled.is_point()) return Vec3::UnitX();
  Vec3 mean = Vec3::Zero();
  for (const std::int32_t v : vertices) mean += scaled(surface.x_t0[v]);
  mean /= static_cast<double>(vertices.size());
  Mat3 spread = Mat3::Zero();
  for (const std::int32_t v : vertices) {
    const Vec3 y = scaled(surface.x_t0[v]) - mean;
    spread += y * y.transpose();
  }
  const SymmetricEigen eigen = symmetric_eigen(spread);
  const Vec3 axis = eigen.vectors.col(2);
  return eigen.converged && axis.allFinite() ? axis : Vec3::UnitX();
}

}  // namespace selvedge::detail
