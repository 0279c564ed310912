// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/measure.h>
#include <selvedge/dress/detail/pulls.h>

#include <cmath>
#include <memory>

namespace selvedge::detail {
namespace {

constexpr double kStiffness = 4000.0;  // N/m³, of the pull
constexpr double kStrongest = 200.0;   // N/m², that a hand pulls
/// Share of the area of a garment that is its own mirror image; a pocket may be on one side.
constexpr double kSymmetric = 0.9;

/// f = A k e / √(1 + (k e / p)²) along the axis, e: the way to the target, k: stiffness, p: the
/// strongest pull.
class PullForce final : public Force {
 public:
  explicit PullForce(const std::vector<Pull>& pulls) : pulls_(pulls) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    for (const Pull& pull : pulls_) {
      const double e = way(pull, state);
      f[pull.vertex] += pull.area * kStiffness * e / root(e) * pull.axis;
    }
  }
  double energy(const ForceState& state) const override {
    double sum = 0.0;
    for (const Pull& pull : pulls_)
      sum += pull.area * kStrongest * kStrongest / kStiffness * (root(way(pull, state)) - 1.0);
    return sum;
  }
  // The Jacobian has blocks on the diagonal only, which every matrix has.
  void add_links(std::vector<Edge>&) const override {}
  void bind(const BlockMatrix&) override {}
  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    for (const Pull& pull : pulls_)
      a.diagonal(static_cast<std::size_t>(pull.vertex)) +=
          h * h * stiffness(pull, state) * pull.axis * pull.axis.transpose();
  }
  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness_sum,
                           std::span<double>) const override {
    for (const Pull& pull : pulls_) stiffness_sum[pull.vertex] += stiffness(pull, state);
  }

 private:
  static double way(const Pull& pull, const ForceState& state) {
    return pull.target - pull.axis.dot(state.x[pull.vertex]);
  }
  static double root(double e) {
    const double share = kStiffness * e / kStrongest;
    return std::sqrt(1.0 + share * share);
  }
  static double stiffness(const Pull& pull, const ForceState& state) {
    const double r = root(way(pull, state));
    return pull.area * kStiffness / (r * r * r);
  }

  const std::vector<Pull>& pulls_;
};

}  // namespace

Methods with_pulls(const Methods& methods, const std::vector<Pull>& pulls) {
  Methods with = methods;
  with.force_laws.add("pulls", {},
                      [&pulls](const MethodOptions&, const ClothMesh&) {
                        ForceList forces;
                        forces.push_back(std::make_unique<PullForce>(pulls));
                        return forces;
                      },
                      {.promise = "minus the gradient of its energy", .source = "selvedge"});
  return with;
}

Straightening::Straightening(const Garment& garment, const Dressing& dressing)
    : middle_(dressing.middle.value_or(0.0)),
      area_(vertex_areas(garment.flat.vertices, garment.flat.triangles)),
      image_(area_.size(), -1) {
  if (!dressing.middle || garment.image.size() != area_.size()) return;
  double all = 0.0, with = 0.0;
  for (std::size_t v = 0; v < area_.size(); ++v) {
    all += area_[v];
    if (garment.image[v] >= 0) with += area_[v];
  }
  if (with >= kSymmetric * all) image_ = garment.image;
}

void Straightening::add_pulls(const Garment& garment, std::vector<Pull>& pulls) {
  straightened_.clear();
  for (std::size_t v = 0; v < image_.size(); ++v) {
    if (image_[v] < 0) continue;
    const std::int32_t vertex = garment.corner[v];
    straightened_.push_back({pulls.size(), vertex, garment.corner[image_[v]]});
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())})
      pulls.push_back({.vertex = vertex, .axis = axis, .target = 0.0, .area = area_[v]});
  }
}

void Straightening::aim(std::span<const Vec3> x, std::vector<Pull>& pulls) const {
  for (const Straightened& s : straightened_) {
    const Vec3 target = 0.5 * (x[s.vertex] + mirrored(x[s.image]));
    for (int k = 0; k < 3; ++k) pulls[s.pull + static_cast<std::size_t>(k)].target = target[k];
  }
}

}  // namespace selvedge::detail
