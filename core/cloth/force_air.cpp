// SPDX-License-Identifier: MIT
//
// Air drag that is linear in the velocity. The survey prints eq. 9 with a minus sign that pushes
// cloth upwind. Here a triangle feels C A [n·(u - v)] n in air of the velocity u: along the wind,
// and zero if it moves with the wind.
#include <selvedge/core/cloth/detail/air_flow.h>
#include <selvedge/core/cloth/detail/coloring.h>
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>

#include <Eigen/Geometry>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t kAirGrain = 512;

struct AirElement {
  Triangle v;
  double area;
};

/// Slots of the 9 blocks (i, j) of a triangle, row-major.
using TriangleSlots = std::array<std::int32_t, 9>;

Vec3 unit_normal(const Triangle& t, std::span<const Vec3> x) {
  const Vec3 n = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
  const double length = n.norm();
  return length > 0.0 ? Vec3(n / length) : Vec3::Zero();
}

Vec3 mean(std::span<const Vec3> of, const Triangle& t) {
  return (of[t[0]] + of[t[1]] + of[t[2]]) / 3.0;
}

class AirForce final : public Force {
 public:
  AirForce(const AirConfig& config, std::span<const Triangle> triangles,
           std::span<const double> rest_areas, std::size_t particles)
      : config_(config), flow_(config), vertex_area_(particles, 0.0), air_(particles) {
    detail::require_number("normal_drag", config.normal_drag);
    detail::require_number("viscous_drag", config.viscous_drag);
    if (rest_areas.size() != triangles.size())
      throw std::invalid_argument("air: " + std::to_string(rest_areas.size()) + " areas for " +
                                  std::to_string(triangles.size()) + " triangles");
    std::vector<std::int32_t> corners;
    for (std::size_t k = 0; k < triangles.size(); ++k) {
      detail::require_number("rest area of a triangle", rest_areas[k]);
      for (const std::int32_t v : triangles[k]) {
        detail::require_particle("triangle", k, v, particles);
        vertex_area_[v] += rest_areas[k] / 3.0;
        corners.push_back(v);
      }
    }
    if (config.normal_drag <= 0.0) return;  // no triangle feels a force, so none is stored
    detail::Coloring coloring = detail::color_elements(corners, 3, particles);
    for (const std::int32_t k : coloring.order) triangles_.push_back({triangles[k], rest_areas[k]});
    color_begin_ = std::move(coloring.color_begin);
  }

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const double c = config_.viscous_drag;
    parallel_for(f.size(), kAirGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        air_[i] = flow_.velocity(state.x[i], state.time);
        f[i] += c * vertex_area_[i] * (air_[i] - state.v[i]);
      }
    });
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& [t, area] = triangles_[i];
        const Vec3 n = unit_normal(t, state.x);
        const Vec3 u = flow_.is_uniform() ? config_.wind : mean(air_, t);
        const Vec3 v = mean(state.v, t);
        const Vec3 third = (config_.normal_drag * area / 3.0 * n.dot(u - v)) * n;
        for (const std::int32_t k : t) f[k] += third;
      }
    });
  }

  double energy(const ForceState&) const override { return 0.0; }

  bool is_external() const override { return true; }
  void add_links(std::vector<Edge>& links) const override {
    for (const AirElement& e : triangles_)
      for (int k = 0; k < 3; ++k) links.push_back({e.v[k], e.v[(k + 1) % 3]});
  }

  void bind(const BlockMatrix& matrix) override {
    slots_.assign(triangles_.size(), TriangleSlots{});
    for (std::size_t e = 0; e < triangles_.size(); ++e)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          slots_[e][3 * i + j] = matrix.slot(triangles_[e].v[i], triangles_[e].v[j]);
  }

  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override {
    for (std::size_t i = 0; i < vertex_area_.size(); ++i)
      a.diagonal(i).diagonal().array() += h * config_.viscous_drag * vertex_area_[i];
    const std::span<Mat3> values = a.values();
    detail::for_each_color(color_begin_, [&](std::size_t begin, std::size_t end) {
      for (std::size_t e = begin; e < end; ++e) {
        const Vec3 n = unit_normal(triangles_[e].v, state.x);
        const double scale = h * config_.normal_drag * triangles_[e].area / 9.0;
        const Mat3 block = (scale * n) * n.transpose();
        for (const std::int32_t slot : slots_[e]) values[slot] += block;
      }
    });
  }

  void add_stiffness_bound(const ForceState&, std::span<double>,
                           std::span<double> damping) const override {
    for (std::size_t i = 0; i < vertex_area_.size(); ++i)
      damping[i] += config_.viscous_drag * vertex_area_[i];
    for (const AirElement& e : triangles_)
      for (const std::int32_t v : e.v) damping[v] += config_.normal_drag * e.area / 3.0;
  }

 private:
  AirConfig config_;
  detail::AirFlow flow_;
  std::vector<double> vertex_area_;
  mutable std::vector<Vec3> air_;  // scratch: velocity of the air at the particles
  std::vector<AirElement> triangles_;
  std::vector<TriangleSlots> slots_;
  std::vector<std::size_t> color_begin_;
};

}  // namespace

std::unique_ptr<Force> make_air_force(const AirConfig& config, std::span<const Triangle> triangles,
                                      std::span<const double> rest_areas, std::size_t particles) {
  return std::make_unique<AirForce>(config, triangles, rest_areas, particles);
}

void register_air(FabricLaws& laws) {
  laws.forces.add_keyed("air", "air",
                        {.promise = "drag of triangles and particles by the air and its wind",
                         .source = "survey eq. 7, 9; sign of 9 corrected"});
}

}  // namespace selvedge
