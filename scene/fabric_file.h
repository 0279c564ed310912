// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/fabric.h>

#include <filesystem>
#include <string>
#include <vector>

namespace selvedge {

/// A measured fabric as cloth.
struct Fabric {
  std::string name;         ///< such as petrak_2025/M1
  std::string description;  ///< what it is
  std::string source;       ///< who measured it
  std::string kind;         ///< constants, kes, fast, cantilever or drape
  FabricConstants constants;
  Material material;
  std::vector<std::string> notes;  ///< what was taken for granted
};

/// Fabrics of a file (docs/fabrics.md has its keys): numbers with their units, or the sheet of a
/// laboratory. Throws std::invalid_argument with one sentence: file, place, fault, remedy - a unit
/// that is missing or no unit of the quantity, a negative modulus, a curve that falls.
std::vector<Fabric> read_fabrics(const std::filesystem::path& file);

/// One fabric that stands in a text of JSON, with the keys of a file of one; `place` names it in
/// messages. Throws as read_fabrics does.
Fabric parse_fabric(const std::string& json, const std::string& place);

/// Those of data/fabrics, which are compiled in, by name.
std::vector<Fabric> measured_fabrics();

/// One of measured_fabrics by its name, else a file relative to `folder`; FILE#NAME names one of
/// several. Throws std::invalid_argument naming the nearest one.
Fabric find_fabric(const std::string& name, const std::filesystem::path& folder);

/// The constants as the keys of a scene's material, JSON.
std::string material_json(const Material& material);

}  // namespace selvedge
