// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/solid_force.h>

#include <array>
#include <utility>

namespace selvedge::detail {
namespace {

class Rods final : public Force {
 public:
  explicit Rods(std::vector<Rod> rods) : rods_(std::move(rods)) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (const Rod& rod : rods_) {
      const Vec3 way = state.x[rod.b] - state.x[rod.a];
      const Vec3 pull = rod.stiffness * (way.norm() - rod.length) * way.normalized();
      f[rod.a] += pull;
      f[rod.b] -= pull;
    }
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (const Rod& rod : rods_) {
      const double longer = (state.x[rod.b] - state.x[rod.a]).norm() - rod.length;
      sum += 0.5 * rod.stiffness * longer * longer;
    }
    return sum;
  }
  void add_links(std::vector<Edge>& links) const override {
    for (const Rod& rod : rods_) links.push_back({rod.a, rod.b});
  }
  void bind(const BlockMatrix& matrix) override {
    slots_.clear();
    for (const Rod& rod : rods_)
      slots_.push_back({matrix.slot(rod.a, rod.b), matrix.slot(rod.b, rod.a)});
  }
  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    for (std::size_t k = 0; k < rods_.size(); ++k) {
      const Rod& rod = rods_[k];
      const Vec3 along = (state.x[rod.b] - state.x[rod.a]).normalized();
      const Mat3 block = h * h * rod.stiffness * along * along.transpose();
      a.diagonal(rod.a) += block;
      a.diagonal(rod.b) += block;
      for (const std::int32_t slot : slots_[k]) a.values()[slot] -= block;
    }
  }
  void add_stiffness_bound(const ForceState&, std::span<double> stiffness,
                           std::span<double>) const override {
    for (const Rod& rod : rods_)
      for (const std::int32_t i : {rod.a, rod.b}) stiffness[i] += 2.0 * rod.stiffness;
  }

 private:
  std::vector<Rod> rods_;
  std::vector<std::array<std::int32_t, 2>> slots_;
};

}  // namespace

std::unique_ptr<Force> make_rods(std::vector<Rod> rods) {
  return std::make_unique<Rods>(std::move(rods));
}

}  // namespace selvedge::detail
