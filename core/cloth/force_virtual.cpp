// SPDX-License-Identifier: MIT
//
// Virtual springs after Z. Yuan et al., "Real-time simulation of tissue cutting with CUDA based on
// GPGPU", 2010 (survey section 2.8): a spring of zero rest length from every particle to its
// position in the rest shape. As in the survey ("return to their original position") the target is
// fixed in space, so the cloth cannot move or rotate freely. With `follow` the rest shape moves
// along: g_i = R (q_i - q̄) + x̄ with the rotation R that minimises Σ k_i |x_i - g_i|² (shape
// matching). R and x̄ are minimisers, so the gradient of that energy is k_i (x_i - g_i): no net
// force and no net moment.
//
// The Jacobian of the fixed springs is exact. That of the following springs couples all particles
// and is omitted; an implicit step treats them explicitly, which is stable below 2 sqrt(m/k).
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>

namespace selvedge {
namespace {

// Moments of inertia below this share of the largest are rounding errors: no rotation about these
// axes.
constexpr double kLeastTurned = 1e-15;

class VirtualSprings final : public Force {
 public:
  VirtualSprings(std::span<const Vec3> rest, std::span<const double> stiffness, bool follow)
      : rest_(rest.begin(), rest.end()),
        stiffness_(stiffness.begin(), stiffness.end()),
        follow_(follow) {
    if (rest.size() != stiffness.size())
      throw std::invalid_argument("virtual springs: " + std::to_string(stiffness.size()) +
                                  " stiffnesses for " + std::to_string(rest.size()) + " particles");
    for (std::size_t i = 0; i < rest.size(); ++i) {
      detail::require_number_of("stiffness", "virtual spring", i, stiffness[i]);
      total_ += stiffness[i];
      rest_centre_ += stiffness[i] * rest[i];
    }
    detail::require_number("sum of the stiffnesses of the virtual springs", total_, false);
    rest_centre_ /= total_;
    while (stiffness_[anchor_] <= 0.0) ++anchor_;
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const Pose pose = pose_of(state.x);
    const Twist left = follow_ ? left_over(pose, state.x) : Twist{};
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const Vec3 arm = pose.arm(state.x[i]);
      f[i] += stiffness_[i] * (pose.from(state.x[i], rest_[i]) - left.shift - left.turn.cross(arm));
    }
  }

  double energy(const ForceState& state) const override {
    const Pose pose = pose_of(state.x);
    double sum = 0.0;
    for (std::size_t i = 0; i < rest_.size(); ++i)
      sum += 0.5 * stiffness_[i] * pose.from(state.x[i], rest_[i]).squaredNorm();
    return sum;
  }

  bool is_external() const override { return !follow_; }
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}

  void add_jacobian(const ForceState&, double h, BlockMatrix& a) const override {
    if (follow_) return;
    for (std::size_t i = 0; i < stiffness_.size(); ++i)
      a.diagonal(i).diagonal().array() += h * h * stiffness_[i];
  }

  void add_stiffness_bound(const ForceState&, std::span<double> stiffness,
                           std::span<double>) const override {
    // Following can only lower the energy, so this bounds the eigenvalues in both cases.
    for (std::size_t i = 0; i < stiffness_.size(); ++i) stiffness[i] += stiffness_[i];
  }

 private:
  /// g = rotation (q - q0) + (centre + origin). Positions are relative to the particle `origin`, so
  /// no digits are lost far from the origin of space.
  struct Pose {
    Mat3 rotation = Mat3::Identity();
    Vec3 rest_centre = Vec3::Zero(), origin = Vec3::Zero(), centre = Vec3::Zero();
    Vec3 arm(const Vec3& x) const { return (x - origin) - centre; }
    Vec3 from(const Vec3& x, const Vec3& q) const { return rotation * (q - rest_centre) - arm(x); }
  };
  struct Twist {
    Vec3 shift = Vec3::Zero(), turn = Vec3::Zero();
  };

  /// The rounding error of the sum and moment of the forces, expressed as a small rigid motion.
  /// Near the rest shape the forces themselves are not much larger.
  Twist left_over(const Pose& pose, std::span<const Vec3> x) const {
    Twist left;
    for (std::size_t i = 0; i < rest_.size(); ++i)
      left.shift += (stiffness_[i] / total_) * pose.from(x[i], rest_[i]);
    Vec3 moment = Vec3::Zero();
    Mat3 inertia = Mat3::Zero();
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const Vec3 arm = pose.arm(x[i]);
      moment += stiffness_[i] * arm.cross(pose.from(x[i], rest_[i]) - left.shift);
      inertia += stiffness_[i] * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
    }
    // If the particles are collinear or coincide, some axis has no rotation and no moment.
    left.turn = pseudo_inverse(inertia, kLeastTurned) * moment;
    return left;
  }

  Pose pose_of(std::span<const Vec3> x) const {
    Pose pose;
    if (!follow_) return pose;
    pose.rest_centre = rest_centre_;
    pose.origin = x[anchor_];
    for (std::size_t i = 0; i < rest_.size(); ++i)
      pose.centre += (stiffness_[i] / total_) * (x[i] - pose.origin);
    Mat3 moments = Mat3::Zero();
    for (std::size_t i = 0; i < rest_.size(); ++i)
      moments += stiffness_[i] * ((x[i] - pose.origin) - pose.centre) *
                 (rest_[i] - rest_centre_).transpose();
    pose.rotation = nearest_rotation(moments);
    return pose;
  }

  std::vector<Vec3> rest_;
  std::vector<double> stiffness_;
  bool follow_;
  std::size_t anchor_ = 0;  // a particle that has a spring
  double total_ = 0.0;
  Vec3 rest_centre_ = Vec3::Zero();
};

}  // namespace

std::unique_ptr<Force> make_virtual_springs(std::span<const Vec3> rest,
                                            std::span<const double> stiffness, bool follow) {
  return std::make_unique<VirtualSprings>(rest, stiffness, follow);
}

void register_virtual_springs(FabricLaws& laws) {
  laws.forces.add_keyed(
      "virtual_springs", "geometry.*.virtual_springs",
      {.promise = "minus the gradient of its energy; fixed in space or following",
       .source = "Yuan et al., Real-time simulation of tissue cutting with CUDA, 2010"});
}

}  // namespace selvedge
