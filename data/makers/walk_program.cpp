// SPDX-License-Identifier: MIT
// selvedge-walk FOLDER [--faces N] [--seconds S] [--arms DEGREES] writes walk_0000.ply ..., the
// frames of a mannequin that stands for half a second and then walks, and poncho.ply, a cloth for
// it. --arms: it begins with straight arms at this angle from hanging down, as selvedge-mannequin
// makes it, and lowers them while it stands. Used by scripts/make_walk.sh.
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/data/makers/mannequin.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

namespace {

using selvedge::Triangle;
using selvedge::TriangleMesh;
using selvedge::Vec3;

constexpr double kFps = 30.0;
constexpr double kStanding = 0.5;  // s, time for the cloth to settle on the shoulders

struct Arguments {
  std::filesystem::path folder;
  int faces = 10000;
  double seconds = 3.0;
  std::optional<double> arms;  // degrees
};

template <class Number>
void read_number(const char* text, Number& number) {
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, number);
  if (error != std::errc() || stop != end)
    throw std::invalid_argument(std::string(text) + " is not a number");
}

bool parse_arguments(int argc, char** argv, Arguments& arguments) {
  if (argc < 2 || argv[1][0] == '-' || argc % 2 != 0) return false;
  arguments.folder = argv[1];
  for (int i = 2; i < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--faces")
      read_number(argv[i + 1], arguments.faces);
    else if (key == "--seconds")
      read_number(argv[i + 1], arguments.seconds);
    else if (key == "--arms")
      read_number(argv[i + 1], arguments.arms.emplace());
    else
      return false;
  }
  if (!(arguments.seconds > 0.0 && arguments.seconds <= 600.0))
    throw std::invalid_argument("--seconds must lie between 0 and 600");
  return true;
}

/// `share` of the way from `from` to `to`.
void lower_arm(const selvedge::LimbPose& from, double share, selvedge::LimbPose& to) {
  to.shoulder_out += (1.0 - share) * (from.shoulder_out - to.shoulder_out);
  to.elbow += (1.0 - share) * (from.elbow - to.elbow);
}

/// From 0 to 1 without a jerk.
double eased(double t) {
  const double s = std::clamp(t, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

void write_walk(const Arguments& arguments) {
  selvedge::MannequinConfig config;
  config.faces = arguments.faces;
  if (arguments.arms)
    for (selvedge::LimbPose* side : {&config.left, &config.right}) {
      side->shoulder_out = *arguments.arms * std::numbers::pi / 180.0;
      side->elbow = 0.0;
    }
  const selvedge::BendingMannequin figure(config);
  const int frames = static_cast<int>(std::lround(arguments.seconds * kFps));
  for (int k = 0; k <= frames; ++k) {
    selvedge::WalkPose walk = selvedge::walk_at(k / kFps - kStanding);
    lower_arm(config.left, eased(k / kFps / kStanding), walk.left);
    lower_arm(config.right, eased(k / kFps / kStanding), walk.right);
    std::vector<Vec3> x = figure.bent(walk.left, walk.right);
    for (Vec3& p : x) p.y() -= walk.way;
    char name[32];
    std::snprintf(name, sizeof name, "walk_%04d.ply", k);
    selvedge::write_ply(arguments.folder / name, x, figure.triangles());
  }
  std::printf("%d frames of %zu faces\n", frames + 1, figure.triangles().size());
}

/// A square with a round hole in the middle.
TriangleMesh make_poncho(double side, int cells, double hole) {
  TriangleMesh grid;
  const double cell = side / cells;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i)
      grid.vertices.emplace_back(i * cell - side / 2.0, j * cell - side / 2.0, 0.0);
  const auto radius = [&](std::int32_t v) { return grid.vertices[v].norm(); };
  const auto stays = [&](const Triangle& t) {
    return radius(t[0]) > hole - 0.5 * cell && radius(t[1]) > hole - 0.5 * cell &&
           radius(t[2]) > hole - 0.5 * cell;
  };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const std::int32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      // Alternating diagonals, so that no direction is preferred.
      const bool flip = (i + j) % 2 == 1;
      for (const Triangle& t : {flip ? Triangle{a, b, c} : Triangle{a, b, d},
                                flip ? Triangle{b, d, c} : Triangle{a, d, c}})
        if (stays(t)) grid.triangles.push_back(t);
    }
  for (Vec3& p : grid.vertices)  // a round rim
    if (p.norm() > 0.0 && p.norm() < hole + 0.5 * cell) p *= (hole + 0.5 * cell) / p.norm();
  TriangleMesh used;
  std::vector<std::int32_t> place(grid.vertices.size(), -1);
  for (Triangle& t : grid.triangles)
    for (std::int32_t& v : t) {
      if (place[v] < 0) {
        place[v] = static_cast<std::int32_t>(used.vertices.size());
        used.vertices.push_back(grid.vertices[v]);
      }
      v = place[v];
    }
  used.triangles = grid.triangles;
  return used;
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments arguments;
  if (!parse_arguments(argc, argv, arguments)) {
    std::fprintf(stderr,
                 "usage: selvedge-walk FOLDER [--faces N] [--seconds S] [--arms DEGREES]\n");
    return 2;
  }
  std::filesystem::create_directories(arguments.folder);
  write_walk(arguments);
  const TriangleMesh poncho = make_poncho(1.1, 64, 0.135);
  selvedge::write_ply(arguments.folder / "poncho.ply", poncho.vertices, poncho.triangles);
  return 0;
} catch (const std::invalid_argument& fault) {
  std::fprintf(stderr, "selvedge-walk: %s\n", fault.what());
  return 2;
} catch (const std::exception& fault) {
  std::fprintf(stderr, "selvedge-walk: %s\n", fault.what());
  return 1;
}
