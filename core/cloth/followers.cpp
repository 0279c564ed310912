// SPDX-License-Identifier: MIT
//
// x = P y for the dense layers of bilayered meshes [KangCho2002; survey 2.4], and for the hanging
// nodes of adaptive meshes [VillardBorouchaki2005; survey 2.5], x_mid = (a + b)/2. With the weights
// of P, the forces Pᵀ f(P y) have the sum and the moment of f, and the row sums of Pᵀ M P have the
// mass, the centre of mass and the momentum of M.
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/followers.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

/// The leaders of a particle with their weights, by particle.
using Leaders = std::map<std::int32_t, double>;

/// Follows the ends of sides until none of them hangs.
class Chains {
 public:
  explicit Chains(const std::vector<HangingNode>& nodes) {
    for (const HangingNode& node : nodes) ends_[node.v[0]] = {node.v[1], node.v[2]};
  }

  bool hangs(std::int32_t i) const { return ends_.contains(i); }
  void add(std::int32_t i, double weight, Leaders& out, std::size_t depth = 0) const {
    const auto found = ends_.find(i);
    if (found == ends_.end()) {
      out[i] += weight;
      return;
    }
    if (depth > ends_.size())
      throw std::invalid_argument("hanging node " + std::to_string(i) + " hangs on itself");
    for (const std::int32_t end : found->second) add(end, 0.5 * weight, out, depth + 1);
  }

 private:
  std::map<std::int32_t, Edge> ends_;
};

}  // namespace

// Rows name particles; one that names itself leads.
void Followers::set_rows(std::span<const std::vector<std::pair<std::int32_t, double>>> rows) {
  std::vector<std::int32_t> number(rows.size(), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto self = static_cast<std::int32_t>(i);
    if (rows[i].size() != 1 || rows[i][0].first != self) {
      nodes_.push_back(self);
      continue;
    }
    number[i] = static_cast<std::int32_t>(leaders_.size());
    leaders_.push_back(self);
  }
  for (const auto& row : rows) {
    for (const auto& [leader, weight] : row) shares_.push_back({number[leader], weight});
    begin_.push_back(shares_.size());
  }
}

Followers::Followers(const ClothMesh& cloth) {
  if (cloth.hanging.empty() && cloth.rigid.empty()) return;
  const Chains chains(cloth.hanging);
  std::vector<std::vector<std::pair<std::int32_t, double>>> rows;
  for (std::size_t i = 0; i < cloth.surface.vertices.size(); ++i) {
    Leaders leaders;
    chains.add(static_cast<std::int32_t>(i), 1.0, leaders);
    rows.emplace_back(leaders.begin(), leaders.end());
  }
  for (const RigidVertex& vertex : cloth.rigid) {
    auto& row = rows[vertex.v[0]];
    row.clear();
    for (std::size_t k = 0; k < vertex.weight.size(); ++k)
      if (vertex.weight[k] != 0.0) row.emplace_back(vertex.v[k + 1], vertex.weight[k]);
    rigid_.push_back(vertex.v[0]);
  }
  std::sort(rigid_.begin(), rigid_.end());
  set_rows(rows);
}

void Followers::set_mobility(std::span<const double> mass, std::span<double> inv_mass) const {
  std::vector<double> whole(leaders_.size(), 0.0);
  gather(mass, std::span(whole));
  for (const std::int32_t i : rigid_) {
    if (inv_mass[i] <= 0.0) continue;
    double sum = 0.0;
    for (const Share& s : shares(i)) sum += s.weight * s.weight / whole[s.leader];
    inv_mass[i] = sum;
  }
}

void Followers::set_inertia(std::span<const double> mass, std::span<double> inertia) const {
  std::vector<double> mobility(mass.size(), 1.0);
  set_mobility(mass, mobility);
  for (const std::int32_t i : rigid_) inertia[i] = 1.0 / mobility[i];
}

Followers Followers::of_layers(const ClothMesh& cloth) {
  Followers followers;
  if (cloth.layers.empty()) return followers;
  std::vector<std::vector<std::pair<std::int32_t, double>>> rows(cloth.surface.vertices.size());
  for (const Tie<4>& tie : cloth.layers)
    for (int k = 0; k < 4; ++k)
      if (tie.weight[k] > 0.0) rows[tie.v[0]].emplace_back(tie.v[k + 1], tie.weight[k]);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].empty()) rows[i].emplace_back(static_cast<std::int32_t>(i), 1.0);
  followers.set_rows(rows);
  return followers;
}

std::vector<Vec3> Followers::select(std::span<const Vec3> x) const {
  std::vector<Vec3> y;
  y.reserve(leaders_.size());
  for (const std::int32_t i : leaders_) y.push_back(x[i]);
  return y;
}

void Followers::spread(std::span<const Vec3> y, std::span<Vec3> x) const {
  for (std::size_t i = 0; i < particles(); ++i) {
    const std::span<const Share> own = shares(i);
    Vec3 sum = own[0].weight * y[own[0].leader];
    for (const Share& s : own.subspan(1)) sum += s.weight * y[s.leader];
    x[i] = sum;
  }
}

void Followers::place(std::span<Vec3> x) const {
  for (const std::int32_t i : nodes_) {
    Vec3 sum = Vec3::Zero();
    for (const Share& s : shares(i)) sum += s.weight * x[leaders_[s.leader]];
    x[i] = sum;
  }
}

// With x = P y + e at the followers, y_l += Σ_i w_il m_i e_i / M_l, where M_l = Σ_i w_il m_i. Then
// Σ M_l y_l = Σ m_i x_i. Motion that keeps x = P y stays as it is.
void Followers::hand_over(std::span<const double> mass, std::span<const double> inv_mass,
                          std::span<Vec3> x) const {
  if (empty()) return;
  std::vector<Vec3> off(particles(), Vec3::Zero());
  for (const std::int32_t i : nodes_) {
    off[i] = x[i];
    for (const Share& s : shares(i)) off[i] -= s.weight * x[leaders_[s.leader]];
  }
  push_leaders(mass, inv_mass, off, x);
  place(x);
}

void Followers::push_leaders(std::span<const double> mass, std::span<const double> inv_mass,
                             std::span<const Vec3> off, std::span<Vec3> v) const {
  std::vector<double> whole(leaders_.size(), 0.0);
  gather(mass, std::span(whole));
  std::vector<Vec3> given(leaders_.size(), Vec3::Zero());
  std::vector<double> moved(mass.begin(), mass.end());
  if (has_rigid()) set_inertia(mass, moved);
  for (const std::int32_t i : nodes_)
    for (const Share& s : shares(i)) given[s.leader] += (s.weight * moved[i]) * off[i];
  for (std::size_t l = 0; l < leaders_.size(); ++l)
    if (inv_mass[leaders_[l]] > 0.0) v[leaders_[l]] += given[l] / whole[l];
}

LayerParts split_layers(const ClothMesh& cloth) {
  const auto n = static_cast<std::int32_t>(cloth.surface.vertices.size());
  std::vector<std::int32_t> dense(static_cast<std::size_t>(n), -1), others(dense);
  for (const Tie<4>& tie : cloth.layers) dense[tie.v[0]] = tie.v[0];
  for (std::int32_t i = 0; i < n; ++i)
    if (dense[i] < 0) others[i] = i;
  LayerParts parts;
  for (ClothMesh* part : {&parts.carrying, &parts.local}) {
    part->surface = cloth.surface;
    part->edges = cloth.edges;
    part->mass = cloth.mass;
    add_elements(*part, cloth, part == &parts.carrying ? others : dense);
  }
  parts.local.layers = cloth.layers;
  return parts;
}

}  // namespace selvedge
