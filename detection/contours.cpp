// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/detection/internal/contours.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace selvedge {
namespace {

// Union-find whose links carry whether the two ends have the same side.
class SidedSets {
 public:
  explicit SidedSets(std::size_t n) : parent_(n), flipped_(n, 0) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = i;
  }
  std::pair<std::size_t, std::uint8_t> find(std::size_t i) const {
    std::uint8_t flip = 0;
    for (; parent_[i] != i; i = parent_[i]) flip ^= flipped_[i];
    return {i, flip};
  }
  void join(std::size_t i, std::size_t j, std::uint8_t flip) {
    const auto [a, flip_a] = find(i);
    const auto [b, flip_b] = find(j);
    if (a == b) return;
    const auto [low, high] = std::minmax(a, b);
    parent_[high] = low;
    flipped_[high] = flip ^ flip_a ^ flip_b;
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<std::uint8_t> flipped_;
};

// A pair of triangles that a crossing belongs to: (lower, higher), and the crossing.
struct PairMember {
  std::int32_t low, high;
  std::size_t crossing;
  bool edge_is_low;
  auto key() const { return std::pair(low, high); }
};

std::vector<PairMember> members_of_pairs(const JointSurface& surface,
                                         std::span<const EdgeCrossing> crossings) {
  std::vector<PairMember> members;
  for (std::size_t i = 0; i < crossings.size(); ++i)
    for (const std::int32_t t : surface.triangles_of_edge(crossings[i].edge)) {
      const auto [low, high] = std::minmax(t, crossings[i].triangle);
      members.push_back({low, high, i, t == low});
    }
  std::stable_sort(members.begin(), members.end(),
                   [](const auto& a, const auto& b) { return a.key() < b.key(); });
  return members;
}

}  // namespace

std::vector<Contour> trace_contours(const JointSurface& surface,
                                    std::span<const EdgeCrossing> crossings) {
  SidedSets sets(crossings.size());
  const std::vector<PairMember> members = members_of_pairs(surface, crossings);
  for (std::size_t k = 0; k + 1 < members.size(); ++k)
    if (members[k].key() == members[k + 1].key())
      sets.join(members[k].crossing, members[k + 1].crossing,
                members[k].edge_is_low == members[k + 1].edge_is_low ? 0 : 1);
  std::vector<Contour> contours;
  std::map<std::size_t, std::size_t> index;  // contour of a root
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const auto [root, side] = sets.find(i);
    const auto [at, is_new] = index.try_emplace(root, contours.size());
    if (is_new) contours.emplace_back();
    contours[at->second].nodes.push_back(crossings[i]);
    contours[at->second].side.push_back(side);
  }
  return contours;
}

CutRegions::CutRegions(const JointSurface& surface, std::span<const Contour> contours,
                       std::span<const Vec3> x, std::span<std::int32_t> kept)
    : surface_(surface) {
  std::vector<std::pair<std::int32_t, std::size_t>> cuts;  // (edge, label)
  for (std::size_t c = 0; c < contours.size(); ++c)
    for (std::size_t i = 0; i < contours[c].nodes.size(); ++i)
      cuts.emplace_back(contours[c].nodes[i].edge, 2 * c + contours[c].side[i]);
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t k = 0; k < cuts.size();) {
    std::size_t end = k;
    while (end < cuts.size() && cuts[end] == cuts[k]) ++end;
    if ((end - k) % 2 == 1) {  // an edge that passes through and back cuts nothing
      if (cut_edges_.empty() || cut_edges_.back() != cuts[k].first) {
        cut_edges_.push_back(cuts[k].first);
        labels_of_edge_.emplace_back();
      }
      labels_of_edge_.back().push_back(cuts[k].second);
    }
    k = end;
  }
  find_components();
  find_roots(x, kept);
  find_regions(2 * contours.size());
}

// Connected sets of vertices of the cut parts, without the cut edges.
void CutRegions::find_components() {
  component_.assign(surface_.vertices(), -1);
  std::vector<char> cut_part(surface_.parts(), 0);
  for (const std::int32_t e : cut_edges_) cut_part[surface_.part(surface_.edges()[e][0])] = 1;
  std::vector<std::int32_t> stack;
  for (std::size_t first = 0; first < surface_.vertices(); ++first) {
    const std::int32_t part = surface_.part(static_cast<std::int32_t>(first));
    if (component_[first] >= 0 || !cut_part[part]) continue;
    const auto component = static_cast<std::int32_t>(members_.size());
    members_.emplace_back();
    part_of_component_.push_back(part);
    component_[first] = component;
    stack.push_back(static_cast<std::int32_t>(first));
    while (!stack.empty()) {
      const std::int32_t v = stack.back();
      stack.pop_back();
      members_.back().push_back(v);
      for (const std::int32_t e : surface_.edges_of_vertex(v)) {
        const std::int32_t w = surface_.other_end(e, v);
        if (component_[w] >= 0 || std::binary_search(cut_edges_.begin(), cut_edges_.end(), e))
          continue;
        component_[w] = component;
        stack.push_back(w);
      }
    }
    std::sort(members_.back().begin(), members_.back().end());
  }
}

void CutRegions::find_roots(std::span<const Vec3> x, std::span<std::int32_t> kept) {
  root_.assign(surface_.parts(), -1);
  bool all_known = true;
  for (const std::int32_t part : part_of_component_) {
    if (kept[part] >= 0) root_[part] = component_[kept[part]];
    all_known = all_known && kept[part] >= 0;
  }
  if (all_known) return;
  choose_roots(x, kept);
  const std::vector<std::int32_t> within = deepest();
  for (const std::int32_t part : part_of_component_)
    if (kept[part] < 0) kept[part] = within[root_[part]];
}

void CutRegions::choose_roots(std::span<const Vec3> x, std::span<const std::int32_t> kept) {
  std::vector<double> area(members_.size(), 0.0);
  for (const Triangle& t : surface_.triangles()) {
    const double third = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm() / 6.0;
    for (const std::int32_t v : t)
      if (component_[v] >= 0) area[component_[v]] += third;
  }
  const std::vector<Triangle> closed = closed_bodies(surface_);
  std::vector<int> root_rank(surface_.parts(), -1);
  for (std::size_t c = 0; c < members_.size(); ++c) {
    const std::int32_t part = part_of_component_[c], v = members_[c].front();
    if (kept[part] >= 0) continue;
    const bool outside = !surface_.is_cloth(v) || !is_inside(x, closed, x[v]);
    const bool wanted = kept[part] == kUnknown ||
                        component_[not_that_of(kept[part])] != static_cast<std::int32_t>(c);
    const int rank = (outside ? 2 : 0) + (wanted ? 1 : 0);
    std::int32_t& root = root_[part];
    if (rank < root_rank[part] || (rank == root_rank[part] && area[c] <= area[root])) continue;
    root = static_cast<std::int32_t>(c);
    root_rank[part] = rank;
  }
}

// The vertex of each component that is the most edges away from its cuts.
std::vector<std::int32_t> CutRegions::deepest() const {
  std::vector<std::int32_t> last(members_.size(), -1), ring;
  std::vector<char> seen(surface_.vertices(), 0);
  for (const std::int32_t e : cut_edges_)
    for (const std::int32_t v : surface_.edges()[e])
      if (!std::exchange(seen[v], 1)) ring.push_back(v);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    last[component_[ring[i]]] = ring[i];
    for (const std::int32_t e : surface_.edges_of_vertex(ring[i])) {
      const std::int32_t w = surface_.other_end(e, ring[i]);
      if (component_[w] == component_[ring[i]] && !std::exchange(seen[w], 1)) ring.push_back(w);
    }
  }
  for (std::size_t c = 0; c < last.size(); ++c)
    if (last[c] < 0) last[c] = members_[c].front();
  return last;
}

// The components that cannot be reached from the root of their part without crossing the contour.
void CutRegions::find_regions(std::size_t labels) {
  cut_off_.resize(labels);
  std::vector<std::int32_t> part_of_label(labels, -1);
  for (std::size_t k = 0; k < cut_edges_.size(); ++k)
    for (const std::size_t label : labels_of_edge_[k])
      part_of_label[label] = surface_.part(surface_.edges()[cut_edges_[k]][0]);
  for (std::size_t label = 0; label < labels; ++label) {
    const std::int32_t part = part_of_label[label];
    if (part < 0) continue;
    const std::vector<char> reached = reach(root_[part], label);
    std::vector<char> off(members_.size(), 0);
    bool any = false;
    for (std::size_t c = 0; c < members_.size(); ++c)
      if (part_of_component_[c] == part && !reached[c]) off[c] = any = true;
    if (any) cut_off_[label] = std::move(off);
  }
}

// Components that are connected to the first across all cut edges except those of one label.
std::vector<char> CutRegions::reach(std::int32_t first, std::size_t barred) const {
  std::vector<char> reached(members_.size(), 0);
  reached[first] = 1;
  for (bool grows = true; grows;) {
    grows = false;
    for (std::size_t k = 0; k < cut_edges_.size(); ++k) {
      const Edge& e = surface_.edges()[cut_edges_[k]];
      char &a = reached[component_[e[0]]], &b = reached[component_[e[1]]];
      const auto& labels = labels_of_edge_[k];
      if (a == b || std::find(labels.begin(), labels.end(), barred) != labels.end()) continue;
      a = b = 1;
      grows = true;
    }
  }
  return reached;
}

bool CutRegions::is_cut_off(std::size_t contour, int side, std::int32_t v) const {
  const auto& off = cut_off_[2 * contour + static_cast<std::size_t>(side)];
  return !off.empty() && component_[v] >= 0 && off[component_[v]];
}

std::vector<std::int32_t> CutRegions::region(std::size_t contour, int side) const {
  std::vector<std::int32_t> vertices;
  const auto& off = cut_off_[2 * contour + static_cast<std::size_t>(side)];
  for (std::size_t c = 0; c < off.size(); ++c)
    if (off[c]) vertices.insert(vertices.end(), members_[c].begin(), members_[c].end());
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

std::vector<Triangle> closed_bodies(const JointSurface& surface) {
  std::vector<Triangle> closed;
  for (const Triangle& t : surface.triangles())
    if (!surface.is_cloth(t[0]) && surface.is_closed(surface.part(t[0]))) closed.push_back(t);
  return closed;
}

bool is_inside(std::span<const Vec3> x, std::span<const Triangle> closed, const Vec3& p) {
  double angle = 0.0;
  for (const Triangle& t : closed) {
    const Vec3 a = x[t[0]] - p, b = x[t[1]] - p, c = x[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    // tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)
    angle += 2.0 * elementary::atan2(a.dot(b.cross(c)),
                                     la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return std::abs(angle) > 2.0 * std::numbers::pi;  // once around is 4π, not at all 0
}

}  // namespace selvedge
