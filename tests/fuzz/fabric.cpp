// SPDX-License-Identifier: MIT
// Fabric files: a fabric that is read has a material whose JSON text a scene can read.
#include <selvedge/scene/fabric_file.h>

#include <cmath>
#include <cstdlib>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  using namespace selvedge;
  static const fuzz::InputFile input(".json");
  try {
    for (const Fabric& fabric : read_fabrics(input.holding(bytes, n))) {
      if (!(fabric.material.density > 0.0) || !std::isfinite(fabric.material.density)) std::abort();
      if (material_json(fabric.material).find("nan") != std::string::npos) std::abort();
    }
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
