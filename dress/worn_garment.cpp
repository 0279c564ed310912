// SPDX-License-Identifier: MIT
//
// Garments that were put on before, read from their folder to be worn below another one.
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/scene/fabric_file.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(const fs::path& folder, const char* fault) {
  throw std::invalid_argument(fmt::format(
      "{}: {}; give a folder of `selvedge dress` whose garment is good", folder.string(), fault));
}

Json read_result(const fs::path& folder) {
  std::ifstream in(folder / "result.json", std::ios::binary);
  Json json = Json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("dress")) refuse(folder, "holds no dressed garment");
  if (json["dress"] != "finished") refuse(folder, "its garment was not put on");
  if (!json.value("clean", false)) refuse(folder, "its garment is not clean");
  return json;
}

/// One garment; `of` has its fabric and frictions.
WornGarment read_garment(const fs::path& file, const Json& of, const LoadConfig& axes) {
  WornGarment worn;
  worn.surface = prepare_mesh(read_mesh(file), axes, file.string());
  worn.flat = read_pattern(file);
  worn.fabric_name = of.value("fabric", "");
  worn.fabric = worn.fabric_name.empty()
                    ? DressConfig{}.fabric
                    : find_fabric(worn.fabric_name, fs::current_path()).material;
  worn.fabric.strain_limit = of.at("strain_limit").get<double>();
  worn.body_friction = of.at("body_friction").get<double>();
  return worn;
}

}  // namespace

std::vector<WornGarment> read_worn(const fs::path& folder, const LoadConfig& body_file,
                                   double outer_friction) {
  const Json result = read_result(folder);
  LoadConfig axes = body_file;
  axes.weld = false;
  std::vector<WornGarment> list;
  try {
    for (const Json& under : result.value("under", Json::array())) {
      list.push_back(read_garment(folder / under.at("file").get<std::string>(), under, axes));
      list.back().name = under.at("name").get<std::string>();
      list.back().outer_friction = under.at("outer_friction").get<double>();
    }
    list.push_back(read_garment(folder / "garment.obj", result, axes));
    list.back().name = fs::path(result.at("pattern").get<std::string>()).stem().string();
    list.back().outer_friction = outer_friction;
  } catch (const Json::exception&) {
    refuse(folder, "result.json is of another version of the program or was changed");
  }
  return list;
}

}  // namespace selvedge
