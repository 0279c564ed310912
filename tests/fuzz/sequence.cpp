// SPDX-License-Identifier: MIT
// Bodies that are sequences of meshes: a folder of files with odd names, numbers and contents, and
// a scene that names them. A sequence that is read gives finite positions at every time.
#include <selvedge/scene/build.h>
#include <selvedge/scene/scene.h>

#include <cstdlib>

#include "folder.h"

namespace {

using namespace selvedge;

const char* const kBefore[] = {"w_", "",    "walk",  "sub/w_",    "w_0",
                               "9",  "w_-", "../w_", "w_\xc3\xa9"};
const char* const kAfter[] = {".obj", ".ply", ".OBJ", "", "x.obj", "0.ply", "/w.obj", ".off"};
const char* const kNumbers[] = {"0",
                                "1",
                                "2",
                                "3",
                                "4",
                                "00",
                                "01",
                                "02",
                                "03",
                                "0003",
                                "-1",
                                "+1",
                                "10",
                                "99",
                                "100",
                                "9223372036854775807",
                                "9223372036854775808",
                                "1e3",
                                " 1",
                                "x"};
const char* const kFirst[] = {"0", "1", "-1", "9223372036854775807", "1e30", "2.5", "99", "\"0\""};

template <std::size_t n>
std::string one_of(const char* const (&words)[n], fuzz::Bytes& bytes) {
  return words[bytes.below(static_cast<int>(n))];
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string scene_of(const std::string& before, const std::string& after, fuzz::Bytes& bytes) {
  std::string files = "\"" + before + std::string(bytes.below(22), '#') + after + "\"";
  if (bytes.below(4) == 0) files = "[" + files + ", \"" + before + "1" + after + "\"]";
  std::string sequence = "{\"files\": " + files;
  if (bytes.below(2) == 1) sequence += ", \"first\": " + one_of(kFirst, bytes);
  if (bytes.below(2) == 1) sequence += ", \"fps\": " + number(bytes.coordinate());
  if (bytes.below(2) == 1) sequence += ", \"start\": " + number(bytes.coordinate());
  return "{\"geometry\": [{\"cells\": [1, 1]}], \"obstacles\": [{\"sequence\": " + sequence +
         "}}]}";
}

void check(const Body& body, fuzz::Bytes& bytes) {
  std::vector<Vec3> x(body.vertex_count());
  for (int k = 0; k < 4; ++k) {
    body.positions(bytes.coordinate(), x);
    for (const Vec3& p : x)
      if (!p.allFinite()) std::abort();
  }
  for (const Triangle& t : body.triangles())
    for (const std::int32_t v : t)
      if (v < 0 || static_cast<std::size_t>(v) >= x.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t n) {
  static const fuzz::InputFolder folder;
  static const Methods methods;
  folder.clear();
  fuzz::Bytes bytes(data, n);
  const std::string before = one_of(kBefore, bytes), after = one_of(kAfter, bytes);
  try {
    for (int k = bytes.below(7); k-- > 0;) {
      const bool other = bytes.below(8) == 7;
      const std::string name = (other ? one_of(kBefore, bytes) : before) + one_of(kNumbers, bytes);
      folder.write_mesh("scene/" + name + after, bytes);
    }
  } catch (const std::runtime_error&) {  // of two names, one is a folder
  }
  folder.write("scene/scene.json", scene_of(before, after, bytes));
  try {
    const BuiltScene built =
        build_scene(read_scene(folder.path() / "scene" / "scene.json", {}, methods));
    for (const auto& body : built.bodies) check(*body, bytes);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
