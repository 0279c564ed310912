// SPDX-License-Identifier: MIT
//
// Garments that were put on before, read from their folder to be worn below another one.
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/json_value.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/scene/fabric_file.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Value = JsonValue<Json>;

[[noreturn]] void refuse(const fs::path& folder, const std::string& fault) {
  throw std::invalid_argument(fmt::format(
      "{}: {}; give a folder of `selvedge dress` whose garment is good", folder.string(), fault));
}

Json read_result(const fs::path& folder) {
  const Json json = Json::parse(read_if_there(folder / "result.json"), nullptr, false);
  if (!json.is_object() || !json.contains("dress")) refuse(folder, "holds no dressed garment");
  if (json["dress"] != "finished") refuse(folder, "its garment was not put on");
  if (!json.contains("clean") || json["clean"] != true) refuse(folder, "its garment is not clean");
  return json;
}

/// One garment; `of` has its fabric and frictions.
WornGarment read_garment(const fs::path& file, const Value& of, const LoadConfig& axes) {
  WornGarment worn;
  worn.surface = prepare_mesh(read_mesh(file), axes, file.string());
  worn.flat = read_pattern(file);
  worn.fabric_name = of.text_or("fabric", "");
  worn.fabric = worn.fabric_name.empty()
                    ? DressConfig{}.fabric
                    : find_fabric(worn.fabric_name, fs::current_path()).material;
  worn.fabric.strain_limit = of["strain_limit"].number();
  worn.body_friction = of["body_friction"].number();
  return worn;
}

}  // namespace

std::vector<WornGarment> read_worn(const fs::path& folder, const LoadConfig& body_file,
                                   double outer_friction) {
  const Json json = read_result(folder);
  const Value result(json);
  LoadConfig axes = body_file;
  axes.weld = false;
  std::vector<WornGarment> list;
  try {
    if (result.has("under"))
      for (const Value& under : result["under"].list()) {
        list.push_back(read_garment(folder / under["file"].text(), under, axes));
        list.back().name = under["name"].text();
        list.back().outer_friction = under["outer_friction"].number();
      }
    list.push_back(read_garment(folder / "garment.obj", result, axes));
    list.back().name = fs::path(result["pattern"].text()).stem().string();
    list.back().outer_friction = outer_friction;
  } catch (const JsonFault& fault) {
    refuse(folder,
           std::string("result.json is of another version of the program or was changed (") +
               fault.what() + ")");
  }
  return list;
}

}  // namespace selvedge
