// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/solver/detail/link_constants.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace selvedge::detail {
namespace {

// Fraction of the largest moment of inertia below which a piece has no inertia about an axis
// (particles in a line, or a single particle).
constexpr double kNoInertia = 1e-12;

// s: J(τ)/τ² = K + D/τ for a long τ and J(τ)/τ = D + τ K for a short one. With springs damped for
// milliseconds (D = 1e-3 s K), each contains about a millionth of the other part.
constexpr double kLong = 1e3, kShort = 1e-9;

}  // namespace

LinkConstants::LinkConstants(const ForceSum& forces, std::size_t particles)
    : forces_(forces.members()) {
  std::vector<Edge> links;
  for (const auto& force : forces_) force->add_links(links);
  jacobian_ = BlockMatrix(particles, std::move(links));
  for (const auto& force : forces_) force->bind(jacobian_);
  const auto rows = jacobian_.row_begin(), columns = jacobian_.columns();
  for (std::size_t i = 0; i < particles; ++i)
    for (std::int32_t k = rows[i]; k < rows[i + 1]; ++k)
      if (columns[static_cast<std::size_t>(k)] > static_cast<std::int32_t>(i))
        links_.push_back({static_cast<std::int32_t>(i), columns[static_cast<std::size_t>(k)]});
  find_pieces(particles);
}

void LinkConstants::find_pieces(std::size_t particles) {
  std::vector<std::int32_t> root(particles);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const Edge& link : links_)
    root[std::max(find(link[0]), find(link[1]))] = std::min(find(link[0]), find(link[1]));
  piece_of_.resize(particles);
  for (std::size_t i = 0; i < particles; ++i) {
    const std::int32_t r = find(static_cast<std::int32_t>(i));
    piece_of_[i] = r == static_cast<std::int32_t>(i) ? pieces_++ : piece_of_[r];
  }
}

void LinkConstants::fix(const ForceState& state) {
  if (fixed()) return;
  const auto read_constants = [&](double tau, double gain, std::vector<double>& constants) {
    jacobian_.set_zero();
    for (const auto& force : forces_) force->add_jacobian(state, tau, jacobian_);
    constants.resize(links_.size());
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const Mat3& block = jacobian_.values()[jacobian_.slot(links_[l][0], links_[l][1])];
      constants[l] = std::max(0.0, -gain * block.trace());
    }
  };
  read_constants(kLong, 1.0 / (kLong * kLong), stiffness_);
  read_constants(kShort, 1.0 / kShort, damping_);
}

void LinkConstants::add_laplacian(double elastic, double damped, std::span<const Vec3> v,
                                  std::span<Vec3> out) const {
  for (std::size_t l = 0; l < links_.size(); ++l) {
    const auto [i, j] = links_[l];
    const Vec3 pull = (elastic * stiffness_[l] + damped * damping_[l]) * (v[i] - v[j]);
    out[i] += pull;
    out[j] -= pull;
  }
}

void LinkConstants::save(std::vector<double>& memory) const {
  memory.push_back(static_cast<double>(stiffness_.size()));
  memory.insert(memory.end(), stiffness_.begin(), stiffness_.end());
  memory.insert(memory.end(), damping_.begin(), damping_.end());
}

std::span<const double> LinkConstants::restore(std::span<const double> memory) {
  require_memory("link constants", memory.size(), 1);
  const auto count = static_cast<std::size_t>(memory[0]);
  if (count != 0 && count != links_.size()) require_memory("link constants", 0, links_.size());
  require_memory("link constants", memory.size(), 1 + 2 * count);
  const auto first = memory.begin() + 1, middle = first + static_cast<std::ptrdiff_t>(count);
  stiffness_.assign(first, middle);
  damping_.assign(middle, middle + static_cast<std::ptrdiff_t>(count));
  return memory.subspan(1 + 2 * count);
}

RigidCorrection::RigidCorrection(const LinkConstants& links)
    : links_(links), pieces_(static_cast<std::size_t>(links.pieces())) {}

void RigidCorrection::apply(const Particles& p, std::span<const Vec3> f, double h, bool linear,
                            std::span<Vec3> v) {
  const auto piece_of = links_.piece_of();
  for (Piece& piece : pieces_)
    piece = {true, 0.0, Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Mat3::Zero()};
  for (std::size_t i = 0; i < p.size(); ++i) {
    Piece& piece = pieces_[piece_of[i]];
    piece.free = piece.free && p.inv_mass[i] > 0.0;
    piece.mass += p.mass[i];
    piece.centre += p.mass[i] * p.x[i];
    piece.momentum += h * f[i] - p.mass[i] * (v[i] - p.v[i]);
  }
  for (Piece& piece : pieces_) piece.centre /= piece.mass;
  for (std::size_t i = 0; i < p.size(); ++i) {
    Piece& piece = pieces_[piece_of[i]];
    const Vec3 arm = p.x[i] - piece.centre;
    piece.spin += arm.cross(h * f[i] - p.mass[i] * (v[i] - p.v[i]));
    piece.inertia += p.mass[i] * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
  }
  for (Piece& piece : pieces_) {  // from here on: the missing velocities
    piece.momentum = linear ? Vec3(piece.momentum / piece.mass) : Vec3::Zero();
    const SymmetricEigen axes = symmetric_eigen(piece.inertia);
    const double least = kNoInertia * axes.values[2];
    Vec3 turn = axes.vectors.transpose() * piece.spin;
    for (int k = 0; k < 3; ++k) turn[k] = axes.values[k] > least ? turn[k] / axes.values[k] : 0.0;
    piece.spin = axes.vectors * turn;
  }
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Piece& piece = pieces_[piece_of[i]];
    if (piece.free) v[i] += piece.momentum + piece.spin.cross(p.x[i] - piece.centre);
  }
}

}  // namespace selvedge::detail
