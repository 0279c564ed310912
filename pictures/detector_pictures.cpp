// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/pictures/detector_pictures.h>
#include <selvedge/pictures/picture_files.h>
#if SELVEDGE_HAS_BROADPHASE_OSMESA
#include <selvedge/broadphase/image_space/image_space.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace {

// ---- maps ------------------------------------------------------------------------------------

using Rgb = std::array<std::uint8_t, 3>;

constexpr Rgb kNothing = {20, 22, 26};
constexpr int kMapResolution = 1024;

#if SELVEDGE_HAS_BROADPHASE_OSMESA

std::uint8_t byte_of(double unit) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(unit, 0.0, 1.0)));
}

/// A picture whose texel i, in rows from the bottom, has the colour of(i). Seen from behind, left
/// and right are exchanged.
Image picture_of(const DepthNormalMaps& maps, bool from_behind,
                 const std::function<Rgb(std::size_t)>& of) {
  Image image{maps.width(), maps.height(), {}};
  for (int y = maps.height() - 1; y >= 0; --y)
    for (int x = 0; x < maps.width(); ++x) {
      const int column = from_behind ? maps.width() - 1 - x : x;
      const Rgb colour = of(static_cast<std::size_t>(y) * static_cast<std::size_t>(maps.width()) +
                            static_cast<std::size_t>(column));
      image.rgb.insert(image.rgb.end(), colour.begin(), colour.end());
    }
  return image;
}

/// Grey values from the darkest visible grey (far) to white (near), as seen from that side.
std::function<Rgb(std::size_t)> depth_colours(const DepthNormalLayer& layer, bool from_behind) {
  float lo = 0.0F, hi = 0.0F;
  bool first = true;
  for (std::size_t i = 0; i < layer.depth.size(); ++i) {
    if (layer.triangle[i] < 0) continue;
    lo = first ? layer.depth[i] : std::min(lo, layer.depth[i]);
    hi = first ? layer.depth[i] : std::max(hi, layer.depth[i]);
    first = false;
  }
  const float far = from_behind ? hi : lo, near = from_behind ? lo : hi;
  return [&layer, far, near](std::size_t i) -> Rgb {
    if (layer.triangle[i] < 0) return kNothing;
    constexpr double darkest = 0.2;
    const double nearness = near == far ? 1.0 : (layer.depth[i] - far) / (near - far);
    const std::uint8_t grey = byte_of(darkest + (1.0 - darkest) * nearness);
    return {grey, grey, grey};
  };
}

std::function<Rgb(std::size_t)> normal_colours(const DepthNormalLayer& layer) {
  return [&layer](std::size_t i) -> Rgb {
    if (layer.triangle[i] < 0) return kNothing;
    const Eigen::Vector3f c = 0.5F * (layer.normal[i].normalized() + Eigen::Vector3f::Ones());
    return {byte_of(c[0]), byte_of(c[1]), byte_of(c[2])};
  };
}

/// Neighbouring indices get different colours, all bright enough to be visible.
std::function<Rgb(std::size_t)> index_colours(const DepthNormalLayer& layer) {
  return [&layer](std::size_t i) -> Rgb {
    if (layer.triangle[i] < 0) return kNothing;
    // The fractional part of 2^32/golden ratio (D. Knuth, The Art of Computer Programming 6.4).
    const std::uint32_t mixed = 2654435769U * static_cast<std::uint32_t>(layer.triangle[i] + 1);
    const auto part = [mixed](unsigned shift) {
      return static_cast<std::uint8_t>(70U + (mixed >> shift) % 186U);
    };
    return {part(24), part(14), part(4)};
  };
}

#endif

// ---- levels ----------------------------------------------------------------------------------

constexpr std::size_t kMostBoxes = 8192;
/// Bar width over the diagonal of the surface's box: about a pixel and a half.
constexpr double kBar = 0.0012;
/// Bar width over the median side of the level's boxes, so that bars do not fill small boxes.
constexpr double kBarOfBox = 0.05;

const std::array<Vec3, 6>& level_colours() {
  static const std::array<Vec3, 6> list = {{{0.50, 0.085, 0.065},
                                            {0.045, 0.21, 0.27},
                                            {0.62, 0.34, 0.050},
                                            {0.11, 0.14, 0.36},
                                            {0.17, 0.26, 0.090},
                                            {0.28, 0.060, 0.17}}};
  return list;
}

void add_block(const Vec3& lo, const Vec3& hi, TriangleMesh& mesh) {
  const auto base = static_cast<std::int32_t>(mesh.vertices.size());
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.push_back({(corner & 1) != 0 ? hi[0] : lo[0], (corner & 2) != 0 ? hi[1] : lo[1],
                             (corner & 4) != 0 ? hi[2] : lo[2]});
  static constexpr std::array<Triangle, 12> faces = {{{0, 2, 3},
                                                      {0, 3, 1},
                                                      {4, 5, 7},
                                                      {4, 7, 6},
                                                      {0, 1, 5},
                                                      {0, 5, 4},
                                                      {2, 6, 7},
                                                      {2, 7, 3},
                                                      {0, 4, 6},
                                                      {0, 6, 2},
                                                      {1, 3, 7},
                                                      {1, 7, 5}}};
  for (const Triangle& f : faces) mesh.triangles.push_back({base + f[0], base + f[1], base + f[2]});
}

/// Draws the twelve edges of a box as bars.
void add_frame(const LevelBox& box, double bar, TriangleMesh& mesh) {
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 lo = box.lo, hi = box.hi;
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      lo[u] = hi[u] = (corner & 1) != 0 ? box.hi[u] : box.lo[u];
      lo[v] = hi[v] = (corner & 2) != 0 ? box.hi[v] : box.lo[v];
      add_block(lo - Vec3::Constant(bar), hi + Vec3::Constant(bar), mesh);
    }
}

double bar_of(const std::vector<LevelBox>& boxes, double diagonal) {
  std::vector<double> sides;
  for (const LevelBox& box : boxes) sides.push_back((box.hi - box.lo).maxCoeff());
  const auto median = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 2);
  std::nth_element(sides.begin(), median, sides.end());
  return std::min(kBar * diagonal, kBarOfBox * *median);
}

Image level_picture(const SurfaceView& surface, const std::vector<LevelBox>& boxes,
                    std::size_t level, double diagonal, const Camera& camera) {
  TriangleMesh frames;
  const double bar = bar_of(boxes, diagonal);
  for (const LevelBox& box : boxes) add_frame(box, bar, frames);
  RenderSurface shape;
  shape.x = surface.x_t1;
  shape.triangles = surface.triangles;
  shape.front = shape.back = Vec3(0.47, 0.475, 0.485);
  shape.crease = 40.0;
  RenderSurface bars;
  bars.x = frames.vertices;
  bars.triangles = frames.triangles;
  bars.front = bars.back = level_colours()[level % level_colours().size()];
  bars.crease = 0.0;
  const std::array<RenderSurface, 2> surfaces = {shape, bars};
  return render(camera, surfaces, {.ground = false});
}

}  // namespace

#if SELVEDGE_HAS_BROADPHASE_OSMESA
std::vector<DetectorPicture> map_pictures(const SurfaceView& surface, int resolution) {
  DepthNormalMaps maps({.resolution = resolution, .allow_open = true});
  maps.update(surface);
  std::vector<DetectorPicture> pictures;
  for (const bool behind : {false, true}) {
    const DepthNormalLayer& layer = behind ? maps.back() : maps.front();
    const std::string side = behind ? "back" : "front";
    pictures.push_back({side + "_depth", picture_of(maps, behind, depth_colours(layer, behind))});
    pictures.push_back({side + "_normal", picture_of(maps, behind, normal_colours(layer))});
    pictures.push_back({side + "_index", picture_of(maps, behind, index_colours(layer))});
  }
  return pictures;
}
#else
std::vector<DetectorPicture> map_pictures(const SurfaceView&, int) {
  throw std::invalid_argument("maps of image space need OSMesa, which this build does not have");
}
#endif

std::vector<DetectorPicture> level_pictures(const SurfaceView& surface, const Camera& camera) {
  const auto levels = hierarchy_levels(surface);
  std::vector<DetectorPicture> pictures;
  for (std::size_t level = 0; level < levels.size() && levels[level].size() <= kMostBoxes;
       ++level) {
    const LevelBox& root = levels[0][0];
    const double diagonal = (root.hi - root.lo).norm();
    const Camera fitting = framed(camera, root.lo, root.hi);
    pictures.push_back({"level_" + std::to_string(level),
                        level_picture(surface, levels[level], level, diagonal, fitting)});
  }
  return pictures;
}

std::string write_detector_pictures(const SurfaceView& surface, const std::filesystem::path& folder,
                                    const std::string& name) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw std::invalid_argument(folder.string() + ": cannot be made: " + error.message());
  const auto write = [&](const std::vector<DetectorPicture>& pictures) {
    for (const DetectorPicture& p : pictures)
      write_png(folder / (name + "_" + p.name + ".png"), p.image);
  };
  write(level_pictures(surface, Camera{}));
  try {
    write(map_pictures(surface, kMapResolution));
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return {};
}

}  // namespace selvedge
