// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/cloth/fabric.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace selvedge {

/// A measured fabric as cloth.
struct Fabric {
  std::string name;         ///< such as petrak_2025/M1
  std::string description;  ///< fibre, weave and use
  std::string source;       ///< publication of the measurement
  std::string kind;         ///< constants, kes, fast, cantilever or drape
  FabricConstants constants;
  Material material;
  std::vector<std::string> notes;  ///< assumptions that were made
};

/// Reads the fabrics of a file (keys: docs/fabrics.md): constants with units, or a sheet of
/// laboratory readings. Throws std::invalid_argument with file, place, fault and remedy, e.g. for a
/// missing or wrong unit, a negative modulus or a falling curve.
std::vector<Fabric> read_fabrics(const std::filesystem::path& file);

/// Reads one fabric from a JSON text with the keys of a file; `place` names it in messages, and
/// CSV files that it names are relative to `folder`. Errors as in read_fabrics.
Fabric parse_fabric(const std::string& json, const std::string& place,
                    const std::filesystem::path& folder = {});

/// The fabrics of data/fabrics, which are compiled in, sorted by name.
std::vector<Fabric> measured_fabrics();

/// Names in everyday use, such as denim, and the measured fabric that each stands for.
std::map<std::string, std::string> everyday_fabrics();

/// Finds a fabric of measured_fabrics or everyday_fabrics by name, or reads a file relative to
/// `folder`; FILE#NAME selects one of several. Throws std::invalid_argument with the nearest name.
Fabric find_fabric(const std::string& name, const std::filesystem::path& folder);

/// The constants as JSON with the keys of a scene's material.
std::string material_json(const Material& material);

}  // namespace selvedge
