// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/scene/detail/read_extras.h>
#include <selvedge/scene/detail/read_values.h>
#include <selvedge/scene/fabric_file.h>

#include <algorithm>
#include <stdexcept>

namespace selvedge::detail {
const ClothSpec& piece_of(LocatedJson& document, Json& j, const std::string& path,
                          const Scene& scene) {
  if (!j.contains("geometry")) {
    const auto is_cloth = [](const ClothSpec& piece) { return solid_of(piece) == nullptr; };
    if (std::ranges::count_if(scene.cloths, is_cloth) > 1)
      fail(document, path, "needs the key \"geometry\", because there are several pieces");
    j["geometry"] = scene.cloths.front().name;
  }
  const auto name = j["geometry"].get<std::string>();
  std::vector<std::string> known;
  for (const ClothSpec& cloth : scene.cloths) known.push_back(cloth.name);
  require_known(document, name, known, join(path, "geometry"), "geometry");
  return scene.cloths[static_cast<std::size_t>(std::find(known.begin(), known.end(), name) -
                                               known.begin())];
}

namespace {

/// The selected vertices: a list of numbers keeps its order, other selections ascend.
std::vector<std::int32_t> row_of(const LocatedJson& document, VertexSelector& selector,
                                 const Json& select, const ClothSpec& cloth,
                                 const std::string& path) {
  std::vector<std::int32_t> row = selector.select(select, cloth, path);
  if (!select.is_array() ||
      !std::all_of(select.begin(), select.end(), [](const Json& one) { return one.is_number(); }))
    return row;
  const auto listed = select.get<std::vector<std::int32_t>>();
  if (listed.size() != row.size())
    fail(document, path, "names a vertex twice, but a vertex can be sewn only once");
  return listed;
}

void refuse_bad_pairs(const LocatedJson& document, const SeamSpec& seam, const std::string& path) {
  const auto& [a, b] = seam.vertices;
  if (a.size() != b.size())
    fail(document, path,
         fmt::format("one side has {} and the other {}; they are sewn pair by pair",
                     counted(a.size(), "particle"), b.size()));
  if (seam.geometry[0] != seam.geometry[1]) return;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] == b[i])
      fail(document, path,
           fmt::format("vertex {} would be sewn to itself; leave it out of both sides", a[i]));
}

}  // namespace

void read_seams(LocatedJson& document, VertexSelector& selector, Scene& scene) {
  Json& list = document.root["seams"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = join("seams", i);
    Json& j = list[i];
    SeamSpec& seam = scene.seams[i];
    seam.name = fmt::format("seams_{}", i);
    for (std::size_t k = 0; k < 2; ++k) {
      const std::string place = join(join(path, "sides"), k);
      Json& side = j["sides"][k];
      const ClothSpec& cloth = piece_of(document, side, place, scene);
      seam.geometry[k] = cloth.name;
      seam.vertices[k] = row_of(document, selector, side["select"], cloth, join(place, "select"));
    }
    if (j["reverse"].get<bool>()) std::reverse(seam.vertices[1].begin(), seam.vertices[1].end());
    refuse_bad_pairs(document, seam, path);
  }
}

void read_water(LocatedJson& document, VertexSelector& selector, Scene& scene) {
  if (!scene.water) return;
  Json& list = document.root["water"]["sources"];
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string path = join("water.sources", i);
    const ClothSpec& cloth = piece_of(document, list[i], path, scene);
    WaterSource& source = scene.water->sources[i];
    source.geometry = cloth.name;
    source.vertices = selector.select(list[i]["select"], cloth, join(path, "select"));
  }
}

namespace {

/// Adds where the numbers of fabrics come from to the description of the scene.
void describe(Json& root, const std::string& sources) {
  if (sources.empty()) return;
  Json& description = root["description"];
  if (description.is_null()) description = "";
  if (!description.is_string()) return;  // is refused later
  const auto text = description.get<std::string>();
  description = text.empty() ? sources : text + " " + sources;
}

}  // namespace

void expand_fabrics(LocatedJson& document) {
  Json& root = document.root;
  if (!root.is_object() || !root.contains("materials") || !root["materials"].is_object()) return;
  const auto folder = std::filesystem::absolute(document.file).parent_path();
  std::string sources;
  for (auto& item : root["materials"].items()) {
    const std::string& name = item.key();
    Json& material = item.value();
    if (!material.is_object() || !material.contains("fabric")) continue;
    const std::string path = join(join("materials", name), "fabric");
    const Json& named = material["fabric"];
    if (!named.is_string() && !named.is_object())
      fail(document, path, "must be the name of a fabric or of a fabric file, or a fabric");
    try {
      const Fabric fabric = named.is_object() ? parse_fabric(named.dump(), path, folder)
                                              : find_fabric(named.get<std::string>(), folder);
      const Json constants = Json::parse(material_json(fabric.material));
      // A constant beside the fabric counts for both yarns, unless the weft has one of its own.
      const auto given = [&](const std::string& key) {
        return (key == "stretch_weft" && material.contains("stretch_stiffness")) ||
               (key == "bending_weft" && material.contains("bending_stiffness")) ||
               material.contains(key);
      };
      Json added = Json::object();
      for (const auto& [key, value] : constants.items())
        if (!given(key)) added[key] = value;
      material.update(added);
      sources += fmt::format("{}Material \"{}\" is {}: {}", sources.empty() ? "" : "; ", name,
                             fabric.name, fabric.source);
    } catch (const std::invalid_argument& error) {
      fail(document, path, error.what());
    }
    material.erase("fabric");
  }
  describe(root, sources);
}

}  // namespace selvedge::detail
