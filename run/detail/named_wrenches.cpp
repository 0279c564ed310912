// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/run/detail/named_wrenches.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

Vec3 mean_of(std::span<const Vec3> x) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : x) sum += p;
  return x.empty() ? sum : Vec3(sum / static_cast<double>(x.size()));
}

Vec3 place_of(const Scene& scene, const HandleSpec& handle, const Simulation& simulation) {
  const auto piece = std::ranges::find(scene.cloths, handle.geometry, &ClothSpec::name);
  const std::int32_t first = simulation.built().piece_begin[piece - scene.cloths.begin()];
  std::vector<Vec3> x;
  for (const std::int32_t v : handle.vertices) x.push_back(simulation.positions()[first + v]);
  return mean_of(x);
}

std::string name_of(const HandleSpec& handle, std::size_t number) {
  return handle.name.empty() ? fmt::format("handle {}", number)
                             : fmt::format("handle \"{}\"", handle.name);
}

}  // namespace

bool wants_wrenches(const Scene& scene) {
  const std::vector<std::string> formats = scene.output.all_formats();
  return std::ranges::find(formats, "wrenches") != formats.end();
}

std::vector<NamedWrench> named_wrenches(const Scene& scene, const Simulation& simulation,
                                        const StepWrenches& wrenches) {
  std::vector<NamedWrench> rows;
  const auto add = [&](std::string on, const Vec3& about, const Wrench& w) {
    rows.push_back({std::move(on), about, w.force, w.torque_about(about)});
  };
  const VertexNames& names = simulation.names();
  const std::span<const Vec3> bodies = simulation.body_positions();
  const auto particles = static_cast<std::int32_t>(simulation.positions().size());
  for (std::size_t b = 0; b < wrenches.bodies.size(); ++b) {
    const std::size_t owner = names.pieces() + b;
    const std::size_t count = simulation.built().bodies[b]->vertex_count();
    add(names.owner_name(owner), mean_of(bodies.subspan(names.first(owner) - particles, count)),
        wrenches.bodies[b]);
  }
  for (std::size_t s = 0; s < wrenches.solids.size(); ++s) {
    const BuiltSolid& solid = simulation.built().solids[s];
    add(names.owner_name(solid.piece),
        mean_of(simulation.positions().subspan(solid.leader, solid.leaders)), wrenches.solids[s]);
  }
  for (std::size_t k = 0; k < wrenches.handles.size(); ++k)
    add(name_of(scene.handles[k], k), place_of(scene, scene.handles[k], simulation),
        wrenches.handles[k]);
  for (std::size_t k = 0; k < wrenches.held.size(); ++k)
    rows.push_back({names.vertex(wrenches.held[k]), simulation.positions()[wrenches.held[k]],
                    wrenches.held_force[k], Vec3::Zero()});
  for (const auto& [name, w] : wrenches.others) add("cloth: " + name, Vec3::Zero(), w);
  if (wrenches.h > 0.0) add("cloth: change of momentum", Vec3::Zero(), wrenches.change);
  return rows;
}

std::map<std::string, double> wrench_measures(const Scene& scene, const Simulation& simulation) {
  std::map<std::string, double> measures;
  const StepWrenches mean = simulation.frame_wrenches();
  for (const NamedWrench& w : named_wrenches(scene, simulation, mean)) {
    if (w.on.starts_with("vertex")) continue;  // the table has them
    for (int axis = 0; axis < 3; ++axis) {
      measures[fmt::format("{}: about_{}_m", w.on, "xyz"[axis])] = w.about[axis];
      measures[fmt::format("{}: force_{}_N", w.on, "xyz"[axis])] = w.force[axis];
      measures[fmt::format("{}: torque_{}_Nm", w.on, "xyz"[axis])] = w.torque[axis];
    }
  }
  measures["max_wrench_force_error"] = mean.force_error;
  measures["max_wrench_torque_error"] = mean.torque_error;
  return measures;
}

}  // namespace selvedge::detail
