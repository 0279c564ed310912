// SPDX-License-Identifier: MIT
#include <selvedge/scene/detail/read_geometry.h>

#include <numbers>

namespace selvedge::detail {
namespace {

std::optional<PlateSpec> read_plate(const Json& geometry) {
  if (!geometry.contains("plate")) return std::nullopt;
  return PlateSpec{geometry["plate"]["poisson"].get<double>()};
}

RefineSpec read_refine(const Json& j) {
  RefineSpec refine;
  refine.when = j["when"] == "settled" ? RefineSpec::When::settled : RefineSpec::When::curved;
  refine.levels = j["levels"].get<std::int32_t>();
  refine.speed = j["speed"].get<double>();
  refine.energy = j["energy"].get<double>();
  refine.after = j["after"].get<double>();
  refine.angle = j["angle_deg"].get<double>() * std::numbers::pi / 180.0;
  refine.join = j["join_deg"].get<double>() * std::numbers::pi / 180.0;
  return refine;
}

}  // namespace

void read_grid_options(const Json& geometry, ClothGrid& grid) {
  grid.plate = read_plate(geometry);
  if (geometry.contains("refine")) grid.refine = read_refine(geometry["refine"]);
}

void read_mesh_options(const Json& geometry, ClothFile& mesh) {
  mesh.plate = read_plate(geometry);
  if (geometry.contains("refine")) mesh.refine = read_refine(geometry["refine"]);
  if (!geometry.contains("support")) return;
  const Json& j = geometry["support"];
  mesh.support = SupportConstants{j["stiffness"].get<double>(), j["share"].get<double>()};
}

VirtualSpec read_virtual_springs(const Json& geometry) {
  if (!geometry.contains("virtual_springs")) return {};
  const Json& j = geometry["virtual_springs"];
  return {j["stiffness"].get<double>(), j["follow"].get<bool>()};
}

}  // namespace selvedge::detail
