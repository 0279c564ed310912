// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/detail/water.h>

#include <algorithm>
#include <stdexcept>

namespace selvedge::detail {
namespace {

/// The mesh for areas and angles: the flat cloth, if its vertices are those of the surface. It has
/// no triangles of bodies that answer, which take no water.
TriangleMesh shape_of(const BuiltScene& built) {
  const bool same = built.rest.triangles == built.cloth.surface.triangles &&
                    built.rest.vertices.size() == built.cloth.surface.vertices.size();
  TriangleMesh shape = same ? built.rest : built.cloth.surface;
  for (const BuiltSolid& solid : built.solids)
    std::erase_if(shape.triangles, [&](const Triangle& t) {
      return t[0] >= built.piece_begin[solid.piece] && t[0] < solid.leader;
    });
  return shape;
}

}  // namespace

Water::Water(const Scene& scene, const BuiltScene& built)
    : config_(scene.water->wetting), shape_(shape_of(built)), dry_(built.cloth.mass) {
  wetting_.emplace(config_, shape_, dry_);
  for (const WaterSource& source : scene.water->sources) {
    const auto piece = std::find_if(
        scene.cloths.begin(), scene.cloths.end(),
        [&](const ClothSpec& c) { return c.name == source.geometry && solid_of(c) == nullptr; });
    if (piece == scene.cloths.end() || source.vertices.empty())
      throw std::invalid_argument(
          fmt::format("water: no particles of a piece of cloth \"{}\"", source.geometry));
    const std::int32_t first = built.piece_begin[piece - scene.cloths.begin()];
    const double share = source.rate / static_cast<double>(source.vertices.size());
    for (const std::int32_t v : source.vertices)
      drops_.push_back({first + v, share, source.begin, source.end, source.velocity});
  }
}

void Water::advance(double t0, double h, SimulationState& state, std::vector<double>& mass) {
  for (const Drop& drop : drops_) {
    const double seconds = std::min(t0 + h, drop.end) - std::max(t0, drop.begin);
    if (seconds > 0.0 && drop.rate > 0.0)
      wetting_->add_water(drop.vertex, drop.rate * seconds, drop.velocity, state.v[drop.vertex]);
  }
  dripped_ += wetting_->advance(h, state.v);
  note(state, mass);
}

void Water::note(SimulationState& state, std::vector<double>& mass) const {
  state.water.assign(wetting_->water().begin(), wetting_->water().end());
  mass.assign(wetting_->mass().begin(), wetting_->mass().end());
}

void Water::restore(const SimulationState& state, std::vector<double>& mass) {
  wetting_.emplace(config_, shape_, dry_);
  Vec3 unused = Vec3::Zero();
  for (std::size_t i = 0; i < state.water.size(); ++i)
    if (state.water[i] > 0.0)
      wetting_->add_water(static_cast<std::int32_t>(i), state.water[i], Vec3::Zero(), unused);
  mass.assign(wetting_->mass().begin(), wetting_->mass().end());
}

}  // namespace selvedge::detail
