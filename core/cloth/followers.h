// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/cloth_mesh.h>

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace selvedge {

/// Particles that follow others, x_i = Σ weight·x_leader, and the leaders, which move by
/// themselves: x = P y, where y are the positions of the leaders. A hanging node follows the two
/// ends of its side; if these hang as well, it follows their leaders.
class Followers {
 public:
  struct Share {
    std::int32_t leader;  ///< number among the leaders
    double weight;        ///< those of a follower sum to 1; > 0 but for rigid bodies
  };

  Followers() = default;
  /// The hanging nodes of a cloth, and the vertices of rigid bodies. Throws std::invalid_argument
  /// if a node hangs on itself.
  explicit Followers(const ClothMesh& cloth);
  /// The particles of its dense layers, which follow the sparse ones.
  static Followers of_layers(const ClothMesh& cloth);

  bool empty() const { return nodes_.empty(); }
  std::size_t particles() const { return begin_.size() - 1; }
  /// The particles that lead and those that follow, both ascending.
  std::span<const std::int32_t> leaders() const { return leaders_; }
  std::span<const std::int32_t> nodes() const { return nodes_; }
  /// Row i of P; a leader has itself.
  std::span<const Share> shares(std::size_t i) const {
    return std::span(shares_).subspan(begin_[i], begin_[i + 1] - begin_[i]);
  }

  /// Whether particles belong to rigid bodies.
  bool has_rigid() const { return !rigid_.empty(); }
  bool is_rigid(std::int32_t particle) const {
    return std::binary_search(rigid_.begin(), rigid_.end(), particle);
  }
  /// 1/kg, the mobility of each vertex of a rigid body, Σ weight²/mass of its leaders, in place of
  /// its own inverse mass. `mass` and `inv_mass` of all particles; those of others stay.
  void set_mobility(std::span<const double> mass, std::span<double> inv_mass) const;
  /// kg, the inverse of that in place of the masses of such vertices.
  void set_inertia(std::span<const double> mass, std::span<double> inertia) const;

  /// y of x.
  std::vector<Vec3> select(std::span<const Vec3> x) const;
  /// x = P y.
  void spread(std::span<const Vec3> y, std::span<Vec3> x) const;
  /// Sets the followers in x from the leaders in x.
  void place(std::span<Vec3> x) const;
  /// to += Pᵀ from, for Vec3 and double.
  template <class T>
  void gather(std::span<const T> from, std::span<T> to) const {
    for (std::size_t i = 0; i < from.size(); ++i)
      for (const Share& s : shares(i)) to[s.leader] += s.weight * from[i];
  }
  /// Restores x = P y after a method has moved single particles. A follower returns to P y, and its
  /// free leaders move so that Σ mass·x, and thus the momentum, is conserved unless a leader is
  /// held. `mass` and `inv_mass` (0: held) of all particles.
  void hand_over(std::span<const double> mass, std::span<const double> inv_mass,
                 std::span<Vec3> x) const;
  /// The same for followers that keep an offset d from P y. A method has moved them from P y + d by
  /// `off`: they stay there, and their leaders in `v` receive the momentum Σ mass·off.
  void push_leaders(std::span<const double> mass, std::span<const double> inv_mass,
                    std::span<const Vec3> off, std::span<Vec3> v) const;

 private:
  void set_rows(std::span<const std::vector<std::pair<std::int32_t, double>>> rows);

  std::vector<std::int32_t> leaders_, nodes_;
  std::vector<std::size_t> begin_{0};
  std::vector<Share> shares_;
  std::vector<std::int32_t> rigid_;  // particles that follow as vertices of rigid bodies, ascending
};

}  // namespace selvedge
