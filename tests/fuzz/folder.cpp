// SPDX-License-Identifier: MIT
// Result folders with frames and steps that are missing, spoilt or of other meshes, as `selvedge
// check` reads them.
#include <selvedge/run/check_result.h>

#include <cstdlib>

#include "folder.h"

namespace {

using namespace selvedge;

/// A name in frames/ or steps/, now and then an odd one.
std::string file_name(int digits, fuzz::Bytes& bytes) {
  const char* const stems[] = {"cloth", "bodies", "cloth", "bodies",
                               "Cloth", "cloth_", "",      "../cloth"};
  const char* const ends[] = {".ply", ".ply", ".ply", ".ply", ".ply", ".obj", "", ".ply.new"};
  std::string number = std::to_string(bytes.below(6));
  const int odd = bytes.below(32);
  if (odd == 1) number = "18446744073709551617";
  if (odd == 2) number = "-1";
  const std::size_t width = odd == 3 ? 3 : static_cast<std::size_t>(digits);
  if (number.size() < width) number.insert(0, width - number.size(), '0');
  return std::string(stems[bytes.below(8)]) + "_" + number + ends[bytes.below(8)];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t n) {
  static const fuzz::InputFolder folder;
  folder.clear();
  fuzz::Bytes bytes(data, n);
  try {
    for (int k = bytes.below(10); k-- > 0;) {
      const bool step = bytes.below(2) == 1;
      folder.write_mesh((step ? "steps/" : "frames/") + file_name(step ? 6 : 5, bytes), bytes);
    }
  } catch (const std::runtime_error&) {  // of two names, one is a folder
  }
  try {
    const ResultCheck check = check_result(folder.path().string());
    if (check.states == 0 || check.paths >= check.states) std::abort();
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
