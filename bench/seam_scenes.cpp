// SPDX-License-Identifier: MIT
#include "seam_scenes.h"

#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>

namespace selvedge::bench {
namespace {

using Random = std::mt19937_64;

// The floor that the cloth slides on, m.
constexpr double kX0 = -0.9, kX1 = 1.5, kWidth = 1.2;

double uniform(Random& random, double low, double high) {
  return low + (high - low) * std::ldexp(static_cast<double>(random() >> 11U), -53);
}

/// A level rectangle of nx by ny cells of two triangles each.
TriangleMesh sheet(const Vec3& low, double size_x, double size_y, int nx, int ny) {
  TriangleMesh mesh;
  for (int i = 0; i <= nx; ++i)
    for (int j = 0; j <= ny; ++j)
      mesh.vertices.push_back(low + Vec3(size_x * i / nx, size_y * j / ny, 0.0));
  for (std::int32_t i = 0; i < nx; ++i)
    for (std::int32_t j = 0; j < ny; ++j) {
      const std::int32_t a = i * (ny + 1) + j, b = a + ny + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return mesh;
}

TriangleMesh floor(int nx, int ny) {
  return sheet({kX0, -0.5 * kWidth, 0.0}, kX1 - kX0, kWidth, nx, ny);
}

/// A box whose top is z.
TriangleMesh box(double x0, double x1, double z) {
  TriangleMesh mesh = tessellate(Box{{x1 - x0, kWidth, 0.02}}, 3);
  for (Vec3& x : mesh.vertices) x += Vec3(0.5 * (x0 + x1), 0.0, z - 0.01);
  return mesh;
}

std::vector<TriangleMesh> two_boxes(double gap, double step) {
  return {box(kX0, 0.0, 0.0), box(gap, kX1, step)};
}

/// The mesh about the vertical axis.
TriangleMesh turned(TriangleMesh mesh, double angle) {
  const Eigen::AngleAxisd turn(angle, Vec3::UnitZ());
  for (Vec3& x : mesh.vertices) x = turn * x;
  return mesh;
}

/// The faces, each with vertices of its own, or groups of faces that share vertices. `group`: of
/// each face.
TriangleMesh apart(const TriangleMesh& mesh, const std::vector<int>& group,
                   const std::function<Vec3(const Vec3&, int)>& moved) {
  TriangleMesh out;
  std::map<std::pair<std::int32_t, int>, std::int32_t> known;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k) {
    Triangle t = mesh.triangles[k];
    for (std::int32_t& v : t) {
      const auto [it, is_new] =
          known.try_emplace({v, group[k]}, static_cast<std::int32_t>(out.vertices.size()));
      if (is_new) out.vertices.push_back(moved(mesh.vertices[v], group[k]));
      v = it->second;
    }
    out.triangles.push_back(t);
  }
  return out;
}

/// Each face for itself, its vertices moved at random by up to `noise`, m.
TriangleMesh noisy(const TriangleMesh& mesh, double noise, Random& random) {
  std::vector<int> group(mesh.triangles.size());
  for (std::size_t k = 0; k < group.size(); ++k) group[k] = static_cast<int>(k);
  return apart(mesh, group, [&](const Vec3& x, int) {
    return Vec3(x + Vec3(uniform(random, -noise, noise), uniform(random, -noise, noise),
                         uniform(random, -noise, noise)));
  });
}

/// Cells of two faces, shrunk towards their middles so that they are `gap` apart.
TriangleMesh tiles(const TriangleMesh& mesh, double gap) {
  std::vector<int> group(mesh.triangles.size());
  std::vector<Vec3> middle;
  for (std::size_t k = 0; k < group.size(); ++k) {
    group[k] = static_cast<int>(k / 2);
    const Triangle& t = mesh.triangles[k];
    if (k % 2 == 0) middle.push_back(0.5 * (mesh.vertices[t[0]] + mesh.vertices[t[2]]));
  }
  return apart(mesh, group, [&](const Vec3& x, int g) {
    const Vec3 inward = middle[g] - x;
    return Vec3(x + 0.5 * gap *
                        Vec3(inward.x() > 0.0 ? 1.0 : -1.0, inward.y() > 0.0 ? 1.0 : -1.0, 0.0));
  });
}

Seam flat(std::string name, std::vector<TriangleMesh> parts, std::vector<TriangleMesh> welded) {
  Seam seam;
  seam.name = std::move(name);
  seam.parts = std::move(parts);
  seam.welded = std::move(welded);
  return seam;
}

Seam boxes(std::string name, double gap, double step) {
  return flat(std::move(name), two_boxes(gap, step), {box(kX0, kX1, 0.0)});
}

Seam junction(Random& random) {
  const double cut = uniform(random, -0.05, 0.05);
  const int n = 2 + static_cast<int>(random() % 5);
  return flat("T-junction",
              {sheet({kX0, -0.5 * kWidth, 0.0}, cut - kX0, kWidth, 1, 1),
               sheet({cut, -0.5 * kWidth, 0.0}, kX1 - cut, kWidth, 4, n)},
              {floor(6, 4)});
}

Seam ball(Random& random) {
  const TriangleMesh whole = tessellate(Sphere{0.5}, 64);
  std::vector<int> group(whole.triangles.size());
  const double turn = uniform(random, 0.0, std::numbers::pi);
  for (std::size_t k = 0; k < group.size(); ++k) {
    const Triangle& t = whole.triangles[k];
    const Vec3 c = (whole.vertices[t[0]] + whole.vertices[t[1]] + whole.vertices[t[2]]) / 3.0;
    group[k] = static_cast<int>(std::floor(8.0 * (std::atan2(c.y(), c.x()) + turn))) * 16 +
               static_cast<int>(std::floor(8.0 * (c.z() + 1.0)));
  }
  Seam seam = flat(
      "ball in patches 1e-7 apart",
      {apart(whole, group,
             [&](const Vec3& x, int) {
               return Vec3(x + 1e-7 * Vec3(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5),
                                           uniform(random, -0.5, 0.5)));
             })},
      {whole});
  seam.start = {0.0, 0.0, 0.502};
  return seam;
}

Seam ramp(Random& random) {
  constexpr double kSlope = 20.0 * std::numbers::pi / 180.0;
  const TriangleMesh whole = turned(floor(20, 10), uniform(random, -0.3, 0.3));
  Seam seam = flat("tiles on a ramp", {tiles(whole, 1e-7)}, {whole});
  seam.gravity = 9.81 * Vec3(std::sin(kSlope), 0.0, -std::cos(kSlope));
  return seam;
}

/// Beside the same mesh with the vertices joined again.
Seam doubled(const TriangleMesh& whole, double noise, Random& random) {
  const TriangleMesh parts = noisy(whole, noise, random);
  TriangleMesh welded = parts;
  weld_vertices(welded, 4.0 * noise);
  return flat(fmt::format("doubled vertices, noise {:.0e}", noise), {parts}, {welded});
}

/// `share` of the faces is missing.
TriangleMesh with_holes(const TriangleMesh& whole, double share, Random& random) {
  TriangleMesh out;
  out.vertices = whole.vertices;
  for (const Triangle& t : whole.triangles)
    if (uniform(random, 0.0, 1.0) >= share) out.triangles.push_back(t);
  return out;
}

/// A level floor of nx by ny cells, each with a square hole in its middle, m.
TriangleMesh punched(int nx, int ny, double hole) {
  TriangleMesh mesh;
  const Vec3 size((kX1 - kX0) / nx, kWidth / ny, 0.0);
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j) {
      const Vec3 middle(kX0 + (i + 0.5) * size.x(), (j + 0.5) * size.y() - 0.5 * kWidth, 0.0);
      const auto first = static_cast<std::int32_t>(mesh.vertices.size());
      for (const double share : {0.0, 1.0})
        for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
          mesh.vertices.push_back(middle + 0.5 * Vec3(x * (share > 0.0 ? hole : size.x()),
                                                      y * (share > 0.0 ? hole : size.y()), 0.0));
      for (std::int32_t k = 0; k < 4; ++k) {
        const std::int32_t next = (k + 1) % 4;
        mesh.triangles.push_back({first + k, first + next, first + 4 + next});
        mesh.triangles.push_back({first + k, first + 4 + next, first + 4 + k});
      }
    }
  weld_vertices(mesh, 1e-9);
  return mesh;
}

/// A level polygon of n triangles round an apex; if solid, the top of a closed prism. The last
/// triangle meets the first at the apex alone: the vertex on its rim is `slit` away, m, or common.
TriangleMesh fan(const Vec3& apex, double angle, int n, bool is_solid,
                 const std::optional<Vec3>& slit) {
  constexpr double kRadius = 3.0;  // m
  TriangleMesh mesh;
  mesh.vertices.push_back(apex);
  std::vector<std::int32_t> rim;
  for (int k = 0; k < n; ++k) {
    const double a = angle + 2.0 * std::numbers::pi * k / n;
    rim.push_back(static_cast<std::int32_t>(mesh.vertices.size()));
    mesh.vertices.push_back(apex + kRadius * Vec3(std::cos(a), std::sin(a), 0.0));
  }
  rim.push_back(slit ? n + 1 : 1);
  if (slit) mesh.vertices.push_back(Vec3(mesh.vertices[1] + *slit));
  for (int k = 0; k < n; ++k) mesh.triangles.push_back({0, rim[k], rim[k + 1]});
  if (!is_solid) return mesh;
  const auto low = static_cast<std::int32_t>(mesh.vertices.size());
  for (int k = 0; k <= n; ++k)
    mesh.vertices.push_back(Vec3(mesh.vertices[k] - Vec3(0.0, 0.0, 0.02)));
  for (std::int32_t k = 0; k < n; ++k) {
    const std::int32_t below = low + 1 + k, next = low + 1 + (k + 1) % n;
    mesh.triangles.push_back({low, next, below});
    mesh.triangles.push_back({rim[k], below, next});
    mesh.triangles.push_back({rim[k], next, rim[k + 1]});
  }
  return mesh;
}

/// A slit that the cloth crosses, up to 1 m from the vertex in which it ends.
Seam slit_in_fan(Random& random) {
  constexpr double kWidths[] = {0.0, 1e-9, 1e-7, 1e-5, 1e-4};  // m, below a tenth of the rest gap
  const double width = kWidths[random() % std::size(kWidths)];
  const double angle = uniform(random, 0.2, 0.8) * std::numbers::pi;
  const Vec3 along(std::cos(angle), std::sin(angle), 0.0), across(along.y(), -along.x(), 0.0);
  const Vec3 apex = uniform(random, -0.1, 0.1) * Vec3::UnitX() - uniform(random, 0.0, 1.0) * along;
  const Vec3 slit =
      uniform(random, -width, width) * across + uniform(random, -width, width) * Vec3::UnitZ();
  const int n = 4 + static_cast<int>(random() % 29);
  const bool is_solid = random() % 2 == 0;
  return flat("slit that ends in a fan", {fan(apex, angle, n, is_solid, slit)},
              {fan(apex, angle, n, is_solid, {})});
}

/// Strips of nx by ny cells that have every second vertex in common; the others are `gap` apart.
TriangleMesh stitched(int nx, int ny, double gap) {
  TriangleMesh mesh = floor(nx, ny);
  std::map<std::int32_t, std::int32_t> doubled;
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    for (std::int32_t& v : mesh.triangles[k]) {
      const std::int32_t strip = v / (ny + 1), row = v % (ny + 1);
      if (strip == 0 || strip != static_cast<std::int32_t>(k) / (2 * ny) || row % 2 == 0) continue;
      const auto [it, is_new] =
          doubled.try_emplace(v, static_cast<std::int32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(Vec3(mesh.vertices[v] + gap * Vec3::UnitX()));
      v = it->second;
    }
  return mesh;
}

/// Strips of one mesh whose cells are three times as wide as those of the next.
TriangleMesh hanging(int strips, int ny) {
  TriangleMesh mesh;
  for (int k = 0; k < strips; ++k) {
    const double size = (kX1 - kX0) / strips;
    const TriangleMesh strip =
        sheet({kX0 + k * size, -0.5 * kWidth, 0.0}, size, kWidth, 1, k % 2 == 0 ? ny : 3 * ny);
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), strip.vertices.begin(), strip.vertices.end());
    for (const Triangle& t : strip.triangles)
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  weld_vertices(mesh, 1e-9);
  return mesh;
}

/// Between the cells of the floor.
Seam slits(double mm) {
  return flat(fmt::format("slits of {:g} mm", mm), {tiles(floor(60, 30), 1e-3 * mm)},
              {floor(60, 30)});
}

Seam holes(double mm) {
  Seam seam =
      flat(fmt::format("holes of {:g} mm", mm), {punched(60, 30, 1e-3 * mm)}, {floor(60, 30)});
  seam.start.y() = 0.01;  // particles come over them
  return seam;
}

void add_body(Scene& scene, const TriangleMesh& mesh, double friction) {
  BodySpec& body = scene.bodies.emplace_back();
  body.name = fmt::format("body {}", scene.bodies.size());
  BodyFile file;
  file.mesh = mesh;
  file.load.weld = false;
  body.shape = file;
  body.friction = friction;
}

/// Cloth all of whose vertices are held.
void add_held_cloth(Scene& scene, const TriangleMesh& mesh, double friction) {
  ClothSpec& piece = scene.cloths.emplace_back();
  piece.name = fmt::format("piece {}", scene.cloths.size());
  ClothFile file;
  file.mesh = mesh;
  piece.shape = file;
  HandleSpec& handle = scene.handles.emplace_back();
  handle.name = piece.name;
  handle.geometry = piece.name;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    handle.vertices.push_back(static_cast<std::int32_t>(i));
  scene.contact.pairs.push_back(
      {.a = "cloth", .b = piece.name, .friction = friction, .rest_gap = {}});
}

}  // namespace

std::vector<Seam> seams(std::uint64_t seed) {
  Random random(seed);
  const TriangleMesh fine = turned(floor(60, 30), uniform(random, -0.3, 0.3));
  std::vector<Seam> list;
  list.push_back(boxes("two flush boxes", 0.0, 0.0));
  for (const double e : {1e-9, 1e-7, 1e-5})
    list.push_back(boxes(fmt::format("boxes flush within {:.0e}", e), uniform(random, -e, e),
                         uniform(random, 0.0, 1.0) < 0.5 ? -e : e));
  list.push_back(boxes("boxes overlapping by 1 mm", -1e-3, 0.0));
  list.push_back(junction(random));
  list.push_back(flat("strips 1e-7 apart", {tiles(floor(24, 1), 1e-7)}, {floor(24, 1)}));
  list.push_back(ball(random));
  list.push_back(ramp(random));
  for (const double noise : {1e-6, 5e-5}) list.push_back(doubled(fine, noise, random));
  list.push_back(flat("cloth in strips 1e-7 apart", {tiles(floor(24, 12), 1e-7)}, {floor(24, 12)}));
  list.back().is_cloth = true;
  list.push_back(slits(0.19));
  list.push_back(holes(0.19));
  list.push_back(flat("8 % of the faces gone", {with_holes(fine, 0.08, random)}, {fine}));
  list.push_back(slit_in_fan(random));
  list.push_back(flat("T-junctions in one mesh", {hanging(12, 4)}, {floor(12, 12)}));
  list.push_back(
      flat("strips stitched at every second vertex", {stitched(12, 6, 1e-9)}, {floor(12, 6)}));
  list.push_back(
      flat("cloth stitched at every second vertex", {stitched(12, 6, 1e-9)}, {floor(12, 6)}));
  list.back().is_cloth = true;
  for (Seam& seam : list)
    seam.is_quick = seam.name == "boxes flush within 1e-05" || seam.name == "T-junction" ||
                    seam.name == "boxes overlapping by 1 mm" || seam.name == "tiles on a ramp" ||
                    seam.name == "T-junctions in one mesh" ||
                    seam.name == "strips stitched at every second vertex" || seam.is_cloth;
  return list;
}

std::vector<Seam> obstacles() {
  std::vector<Seam> list;
  list.push_back(boxes("step up 0.1 mm", 0.0, 1e-4));
  list.push_back(boxes("step up 1 mm", 0.0, 1e-3));
  list.push_back(boxes("step down 1 mm", 0.0, -1e-3));
  list.push_back(boxes("gap 5 mm", 5e-3, 0.0));
  for (const double mm : {0.5, 2.0}) list.push_back(slits(mm));
  for (const double mm : {0.5, 2.0, 5.0}) list.push_back(holes(mm));
  for (Seam& seam : list) seam.is_obstacle = true;
  return list;
}

Scene slide_scene(const Seam& seam, const std::vector<TriangleMesh>& bodies, const Slide& slide) {
  Scene scene;
  scene.name = "seam";
  scene.materials["default"] = Material{};
  scene.gravity = seam.gravity;
  scene.time.frames = std::min(slide.frames, seam.frames);
  scene.contact.response = slide.response;
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{"rectangular", {0.3, 0.3, 15, 15}};
  cloth.placement.translation = seam.start + slide.aside;
  cloth.velocity = {slide.speed, 0.0, 0.0};
  for (const TriangleMesh& mesh : bodies)
    if (seam.is_cloth)
      add_held_cloth(scene, mesh, slide.friction);
    else
      add_body(scene, mesh, slide.friction);
  return scene;
}

SlideEnd slide_over(const Seam& seam, const std::vector<TriangleMesh>& bodies, const Slide& slide) {
  const Scene scene = slide_scene(seam, bodies, slide);
  Simulation simulation(scene);
  const auto middle = [&] {
    constexpr std::size_t n = 16 * 16;  // the sheet is the first piece
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < n; ++i) sum += simulation.state().x[i];
    return Vec3(sum / static_cast<double>(n));
  };
  const Vec3 from = middle();
  SlideEnd end;
  try {
    simulation.advance_to_frame(scene.time.frames);
  } catch (const SimulationFailed& failed) {
    end.stopped = failed.what();
  }
  end.distance = (middle() - from).norm();
  if (!simulation.result().clean) end.stopped = "not clean";
  end.max_stretch = simulation.result().max_stretch;
  return end;
}

SlideEnd mean_slide(const Seam& seam, const std::vector<TriangleMesh>& bodies, Slide slide,
                    int starts) {
  constexpr double kAside = 0.003;  // m
  SlideEnd mean;
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (int k = 0; k < starts; ++k) {
    slide.aside.y() = starts > 1 ? kAside * k / (starts - 1) : 0.0;
    const SlideEnd end = slide_over(seam, bodies, slide);
    mean.distance += end.distance / starts;
    mean.max_stretch = std::max(mean.max_stretch, end.max_stretch);
    if (mean.stopped.empty()) mean.stopped = end.stopped;
    least = std::min(least, end.distance);
    most = std::max(most, end.distance);
  }
  mean.scatter = 0.5 * (most - least);
  return mean;
}

}  // namespace selvedge::bench
