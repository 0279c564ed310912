// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/force_sum.h>

#include <Eigen/Core>

#include <span>
#include <vector>

namespace selvedge::detail {

/// One number for each link between two particles instead of its 3x3 Jacobian, fixed once: the
/// trace of the block, which bounds it whatever direction the link turns to. The survey gives all
/// links of a Hooke net the same K; links between triangles get theirs the same way, those that
/// would push apart are left out.
class LinkConstants {
 public:
  LinkConstants(const ForceSum& forces, std::size_t particles);

  /// Takes them from the Jacobian at `state`, unless that has been done or restored.
  void fix(const ForceState& state);
  bool fixed() const { return !stiffness_.empty() || links_.empty(); }

  std::span<const Edge> links() const { return links_; }
  std::span<const double> stiffness() const { return stiffness_; }  ///< N/m
  std::span<const double> damping() const { return damping_; }      ///< N·s/m

  /// out_i += Σ_j w_ij (v_i - v_j), w = elastic·stiffness + damped·damping.
  void add_laplacian(double elastic, double damped, std::span<const Vec3> v,
                     std::span<Vec3> out) const;
  /// Pieces that links hold together: which one each particle belongs to, and how many there are.
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

/// Gives the pieces of cloth that nothing holds the momentum and angular momentum that the forces
/// give them in a step, by a rigid motion of each.
class RigidCorrection {
 public:
  explicit RigidCorrection(const LinkConstants& links);
  /// `f`: forces on all particles at the start, N; v: at the end, changed.
  void apply(const Particles& particles, std::span<const Vec3> f, double h, bool linear,
             std::span<Vec3> v);

 private:
  struct Piece {
    bool free;
    double mass;
    Vec3 centre, momentum, spin;  // spin: angular momentum that is missing
    Mat3 inertia;
  };
  const LinkConstants& links_;
  std::vector<Piece> pieces_;
};

}  // namespace selvedge::detail
