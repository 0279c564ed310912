// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/solid_force.h>

#include <array>
#include <cmath>
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

class Joints final : public Force {
 public:
  Joints(std::vector<Pin> pins, std::vector<Damper> dampers)
      : pins_(std::move(pins)), dampers_(std::move(dampers)) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (const Pin& pin : pins_) {
      const Vec3 pull = -pin.stiffness * off(pin, state);
      for (int k = 0; k < 4; ++k) f[pin.leader + k] += pin.weight[k] * pull;
    }
    for (const Damper& d : dampers_) f[d.particle] -= d.damping * state.v[d.particle];
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (const Pin& pin : pins_) sum += 0.5 * pin.stiffness * off(pin, state).squaredNorm();
    return sum;
  }
  bool is_external() const override { return true; }
  void add_links(std::vector<Edge>& links) const override {
    for (const Pin& pin : pins_)
      for (int a = 0; a < 4; ++a)
        for (int b = a + 1; b < 4; ++b) links.push_back({pin.leader + a, pin.leader + b});
  }
  void bind(const BlockMatrix& matrix) override {
    slots_.clear();
    for (const Pin& pin : pins_)
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b)
          slots_.push_back(a == b ? -1 : matrix.slot(pin.leader + a, pin.leader + b));
  }
  void add_jacobian(const ForceState&, double h, BlockMatrix& matrix) const override {
    auto slot = slots_.begin();
    for (const Pin& pin : pins_)
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b, ++slot) {
          Mat3& block = a == b ? matrix.diagonal(pin.leader + a) : matrix.values()[*slot];
          block.diagonal().array() += h * h * pin.stiffness * pin.weight[a] * pin.weight[b];
        }
    for (const Damper& d : dampers_)
      matrix.diagonal(d.particle).diagonal().array() += h * d.damping;
  }
  void add_stiffness_bound(const ForceState&, std::span<double> stiffness,
                           std::span<double> damping) const override {
    for (const Damper& d : dampers_) damping[d.particle] += d.damping;
    for (const Pin& pin : pins_) {
      double sum = 0.0;
      for (const double w : pin.weight) sum += std::abs(w);
      for (int k = 0; k < 4; ++k)
        stiffness[pin.leader + k] += pin.stiffness * std::abs(pin.weight[k]) * sum;
    }
  }

 private:
  static Vec3 off(const Pin& pin, const ForceState& state) {
    Vec3 off = -pin.place;
    for (int k = 0; k < 4; ++k) off += pin.weight[k] * state.x[pin.leader + k];
    return off;
  }

  std::vector<Pin> pins_;
  std::vector<std::int32_t> slots_;  // of each pin in turn
  std::vector<Damper> dampers_;
};

}  // namespace

std::unique_ptr<Force> make_joints(std::vector<Pin> pins, std::vector<Damper> dampers) {
  return std::make_unique<Joints>(std::move(pins), std::move(dampers));
}

std::unique_ptr<Force> make_rods(std::vector<Rod> rods) {
  return std::make_unique<Rods>(std::move(rods));
}

}  // namespace selvedge::detail
