// SPDX-License-Identifier: MIT
// selvedge-mannequin OUT.ply [--faces N] [--arms DEGREES] writes the mannequins of data/bodies.
// --arms: straight arms at this angle from hanging down.
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/data/makers/mannequin.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <numbers>
#include <stdexcept>
#include <string_view>

namespace {

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

bool parse_arguments(int argc, char** argv, selvedge::MannequinConfig& config) {
  if (argc < 2 || argc % 2 != 0 || argv[1][0] == '-') return false;
  for (int i = 2; i < argc; i += 2) {
    const std::string_view key = argv[i];
    double degrees = 0.0;
    if (key == "--faces") {
      if (!read_number(argv[i + 1], config.faces)) return false;
    } else if (key == "--arms" && read_number(argv[i + 1], degrees)) {
      for (selvedge::LimbPose* side : {&config.left, &config.right}) {
        side->shoulder_out = degrees * std::numbers::pi / 180.0;
        side->elbow = 0.0;
      }
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  selvedge::MannequinConfig config;
  if (!parse_arguments(argc, argv, config)) {
    std::fprintf(stderr, "usage: selvedge-mannequin OUT.ply [--faces N] [--arms DEGREES]\n");
    return 2;
  }
  try {
    const selvedge::TriangleMesh mesh = selvedge::make_mannequin(config);
    selvedge::write_ply(argv[1], mesh.vertices, mesh.triangles);
    std::printf("%s: %zu vertices, %zu faces\n", argv[1], mesh.vertices.size(),
                mesh.triangles.size());
  } catch (const std::invalid_argument& fault) {
    std::fprintf(stderr, "selvedge-mannequin: %s\n", fault.what());
    return 2;
  } catch (const std::exception& fault) {
    std::fprintf(stderr, "selvedge-mannequin: %s\n", fault.what());
    return 1;
  }
  return 0;
}
