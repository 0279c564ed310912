// SPDX-License-Identifier: MIT
// Scene files, with every key that the schema has. A scene that is read is valid: what it says is
// read again as the same scene.
#include <selvedge/scene/scene.h>

#include <cstdlib>

#include "fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t n) {
  using namespace selvedge;
  static const fuzz::InputFile input(".json");
  static const Methods methods;
  try {
    const Scene scene = read_scene(input.holding(bytes, n), {}, methods);
    const std::string& text = scene.json;
    const Scene again =
        read_scene(input.holding(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()),
                   {}, methods);
    if (again.json != text) std::abort();
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
