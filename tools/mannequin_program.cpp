// SPDX-License-Identifier: MIT
// selvedge-mannequin OUT.ply [--faces N] writes the mannequin of data/bodies.
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/tools/mannequin.h>

#include <charconv>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string_view>

namespace {

bool parse_arguments(int argc, char** argv, selvedge::MannequinConfig& config) {
  if (argc == 2) return argv[1][0] != '-';
  if (argc != 4 || std::string_view(argv[2]) != "--faces") return false;
  const std::string_view number = argv[3];
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), config.faces);
  return error == std::errc() && end == number.data() + number.size();
}

}  // namespace

int main(int argc, char** argv) {
  selvedge::MannequinConfig config;
  if (!parse_arguments(argc, argv, config)) {
    std::fprintf(stderr, "usage: selvedge-mannequin OUT.ply [--faces N]\n");
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
