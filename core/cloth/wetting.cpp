// SPDX-License-Identifier: MIT
//
// Y. Chen, N. Thalmann, B. Allen, "Physical simulation of wet clothing for virtual humans", The
// Visual Computer 2012. The mass of the particles follows the water (survey section 3.2.6). The
// survey does not say how momentum is transported; here water carries the velocity of the vertex it
// leaves. On a square grid the cotangents give the five-point stencil: the mode of wave number k
// decays as D k² (1 - (k d)²/12 + …), and the explicit step is stable up to d²/(4D).
#include <selvedge/core/cloth/detail/force_checks.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/cloth/fabric_laws.h>
#include <selvedge/core/cloth/force.h>
#include <selvedge/core/cloth/wetting.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <string>

namespace selvedge {
namespace {

/// Cotangents of the angles of a triangle; zero if it has no area.
Vec3 cotangents(std::span<const Vec3> x, const Triangle& t) {
  Vec3 c = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 u = x[t[(k + 1) % 3]] - x[t[k]], v = x[t[(k + 2) % 3]] - x[t[k]];
    const double area = u.cross(v).norm();
    if (area > 0.0) c[k] = u.dot(v) / area;
  }
  return c;
}

/// Half the sum of the cotangents of the angles opposite each edge; edges as in unique_edges.
std::vector<double> cotangent_weights(const TriangleMesh& mesh, const std::vector<Edge>& edges) {
  std::vector<double> weight(edges.size(), 0.0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 c = cotangents(mesh.vertices, t);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[(k + 1) % 3], b = t[(k + 2) % 3];
      const Edge key{std::min(a, b), std::max(a, b)};
      weight[std::lower_bound(edges.begin(), edges.end(), key) - edges.begin()] += 0.5 * c[k];
    }
  }
  return weight;
}

/// The area nearest to each vertex; in obtuse triangles a half and two quarters of the area. The
/// areas sum to the total area.
std::vector<double> nearest_areas(const TriangleMesh& mesh) {
  const std::vector<Vec3>& x = mesh.vertices;
  std::vector<double> area(x.size(), 0.0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3 c = cotangents(x, t);
    const double whole = 0.5 * (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).norm();
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      if (c.minCoeff() < 0.0)
        area[t[k]] += whole * (c[k] < 0.0 ? 0.5 : 0.25);
      else
        area[t[k]] += ((x[t[next]] - x[t[k]]).squaredNorm() * c[last] +
                       (x[t[last]] - x[t[k]]).squaredNorm() * c[next]) /
                      8.0;
    }
  }
  return area;
}

}  // namespace

Wetting::Wetting(const WettingConfig& config, const TriangleMesh& rest,
                 std::span<const double> dry_mass)
    : config_(config),
      dry_(dry_mass.begin(), dry_mass.end()),
      water_(dry_.size(), 0.0),
      mass_(dry_),
      change_(dry_.size()),
      momentum_(dry_.size()),
      stable_step_(std::numeric_limits<double>::infinity()) {
  detail::require_number("diffusivity", config.diffusivity);
  detail::require_number("saturation", config.saturation, false);
  validate(rest, "wetting");
  area_ = nearest_areas(rest);
  if (dry_.size() != rest.vertices.size())
    throw std::invalid_argument("wetting: " + std::to_string(dry_.size()) + " masses for " +
                                std::to_string(rest.vertices.size()) + " vertices");
  std::vector<char> is_cloth(dry_.size(), 0);
  for (const Triangle& t : rest.triangles)
    for (const std::int32_t v : t) is_cloth[v] = 1;
  for (std::size_t i = 0; i < dry_.size(); ++i) {
    detail::require_number_of("mass", "vertex", i, dry_[i], false);
    if (is_cloth[i]) detail::require_number_of("area", "vertex", i, area_[i], false);
  }
  const std::vector<Edge> edges = unique_edges(rest.triangles);
  const std::vector<double> weight = cotangent_weights(rest, edges);
  std::vector<double> rows(dry_.size(), 0.0);
  constexpr double rounding = 1e-12;  // rounding error of the cotangent of a right angle
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const double conductance = config.diffusivity * weight[e];
    // Between obtuse angles water would flow uphill, so no water flows along such an edge.
    if (conductance <= rounding * config.diffusivity) continue;
    channels_.push_back({edges[e], conductance});
    for (const std::int32_t v : edges[e]) rows[v] += std::abs(conductance);
  }
  // Gershgorin: the rates are at most 2 Σ|conductance|/area, and an explicit step needs h·rate < 2.
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] > 0.0) stable_step_ = std::min(stable_step_, area_[i] / rows[i]);
}

void Wetting::add_water(std::int32_t vertex, double kg, const Vec3& velocity_of_water, Vec3& v) {
  detail::require_particle("water", 0, vertex, water_.size());
  detail::require_number("water", kg);
  const double before = mass_[vertex];
  water_[vertex] += kg;
  mass_[vertex] = dry_[vertex] + water_[vertex];
  v = (before * v + kg * velocity_of_water) / (before + kg);
}

double Wetting::advance(double seconds, std::span<Vec3> v) {
  detail::require_number("seconds", seconds);
  if (v.size() != water_.size())
    throw std::invalid_argument("wetting: " + std::to_string(v.size()) + " velocities for " +
                                std::to_string(water_.size()) + " vertices");
  // Half of the longest stable step: a vertex then never gives away more water than it has.
  constexpr double share = 0.5;
  const bool spreads = !channels_.empty() && seconds > 0.0;
  const double steps = spreads ? std::ceil(seconds / (share * stable_step_)) : 0.0;
  constexpr double most_steps = 1e7;
  require(steps <= most_steps, "seconds", seconds,
          "so short that at most ten million stable steps of diffusion fit into it");
  double dripped = drip();
  for (double k = 0.0; k < steps; k += 1.0) {
    spread(seconds / steps, v);
    dripped += drip();
  }
  return dripped;
}

void Wetting::spread(double seconds, std::span<Vec3> v) {
  std::fill(change_.begin(), change_.end(), 0.0);
  for (std::size_t i = 0; i < mass_.size(); ++i) momentum_[i] = mass_[i] * v[i];
  for (const Channel& c : channels_) {
    const auto [a, b] = c.ends;
    const double kg = seconds * c.conductance * (water_[b] / area_[b] - water_[a] / area_[a]);
    change_[a] += kg;
    change_[b] -= kg;
    const Vec3 carried = kg * v[kg > 0.0 ? b : a];
    momentum_[a] += carried;
    momentum_[b] -= carried;
  }
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    if (change_[i] == 0.0) continue;
    water_[i] += change_[i];
    mass_[i] = dry_[i] + water_[i];
    v[i] = momentum_[i] / mass_[i];
  }
}

double Wetting::drip() {
  double dripped = 0.0;
  for (std::size_t i = 0; i < water_.size(); ++i) {
    const double excess = water_[i] - config_.saturation * dry_[i];
    if (excess <= 0.0) continue;
    dripped += excess;
    water_[i] -= excess;
    mass_[i] = dry_[i] + water_[i];
  }
  return dripped;
}

void register_water(FabricLaws& laws) {
  laws.forces.add_keyed(
      "water", "water",
      {.promise = "no water, mass or momentum is lost until it drips",
       .source = "Chen, Magnenat Thalmann, Allen, Physical simulation of wet clothing, 2012"});
}

}  // namespace selvedge
