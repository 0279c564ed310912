// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/force.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Replaces the 3×3 Jacobian of each link between two particles by one number, fixed once: the
/// trace of the block, which bounds it for any direction of the link. The survey gives all links of
/// a Hooke net the same K; links between triangles are treated in the same way. Links that would
/// push apart are omitted.
class LinkConstants {
 public:
  LinkConstants(const ForceSum& forces, std::size_t particles);

  /// Computes the constants from the Jacobian at `state` unless they are already computed or
  /// restored.
  void fix(const ForceState& state);
  bool fixed() const { return !stiffness_.empty() || links_.empty(); }

  std::span<const Edge> links() const { return links_; }
  std::span<const double> stiffness() const { return stiffness_; }  ///< N/m
  std::span<const double> damping() const { return damping_; }      ///< N·s/m

  /// out_i += Σ_j w_ij (v_i - v_j), w = elastic·stiffness + damped·damping.
  void add_laplacian(double elastic, double damped, std::span<const Vec3> v,
                     std::span<Vec3> out) const;
  /// Connected components of the links: the component of each particle, and their number.
  std::span<const std::int32_t> piece_of() const { return piece_of_; }
  std::int32_t pieces() const { return pieces_; }

  void save(std::vector<double>& memory) const;
  std::span<const double> restore(std::span<const double> memory);

 private:
  void find_pieces(std::size_t particles);

  std::span<const std::unique_ptr<Force>> forces_;
  BlockMatrix jacobian_;
  std::vector<Edge> links_;  // ascending, each once
  std::vector<double> stiffness_, damping_;
  std::vector<std::int32_t> piece_of_;
  std::int32_t pieces_ = 0;
};

/// Restores the momentum and angular momentum that the forces give to each free piece of cloth in a
/// step, by adding a rigid motion to the piece.
class RigidCorrection {
 public:
  explicit RigidCorrection(const LinkConstants& links);
  /// `f`: forces on all particles at the start, N; `v`: end velocities, m/s, changed.
  void apply(const Particles& particles, std::span<const Vec3> f, double h, bool linear,
             std::span<Vec3> v);

 private:
  struct Piece {
    bool free;
    double mass;
    Vec3 centre, momentum, spin;  // spin: missing angular momentum
    Mat3 inertia;
  };
  const LinkConstants& links_;
  std::vector<Piece> pieces_;
};

}  // namespace selvedge::detail
