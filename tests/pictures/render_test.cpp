// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <png.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/detail/raster.h>
#include <selvedge/pictures/renderer/render.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/result_folder.h>

#include <Eigen/Geometry>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <tuple>

namespace selvedge::render_test {
namespace {

namespace fs = std::filesystem;
using detail::Band;
using detail::Vec3f;

using Colour = std::array<int, 3>;

Colour pixel(const Image& image, int x, int y) {
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(x));
  return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}

bool is_red(const Colour& c) { return c[0] > c[1] + 40 && c[0] > c[2] + 40; }
bool is_blue(const Colour& c) { return c[2] > c[0] + 40 && c[2] > c[1] + 40; }
int brightness(const Colour& c) { return c[0] + c[1] + c[2]; }

const Vec3 red(0.6, 0.02, 0.02), blue(0.02, 0.02, 0.6), grey(0.5, 0.5, 0.5);

/// Looks along +y from the origin, z up, a right angle of view: at depth d the picture is 2d high.
Camera straight_camera(int width, int height) {
  Camera camera;
  camera.eye = Vec3::Zero();
  camera.target = Vec3(0, 1, 0);
  camera.field_of_view = 90.0;
  camera.width = width;
  camera.height = height;
  return camera;
}

RenderSurface surface(const std::vector<Vec3>& x, const std::vector<Triangle>& triangles,
                      const Vec3& front = red, const Vec3& back = blue) {
  RenderSurface result;
  result.x = x;
  result.triangles = triangles;
  result.front = front;
  result.back = back;
  return result;
}

RenderConfig without_ground() {
  RenderConfig config;
  config.ground = false;
  config.shadow_resolution = 256;
  config.sky_directions = 8;
  return config;
}

/// How often each sample of the picture is inside one of the triangles, drawn one by one.
std::vector<int> coverage(const Camera& camera, const std::vector<Vec3f>& x,
                          const std::vector<Triangle>& triangles) {
  const auto view = detail::make_view(camera, Vec3::Zero());
  Band band(camera.width, 0, camera.height);
  std::vector<int> count(band.triangle.size(), 0);
  for (const Triangle& t : triangles) {
    Band alone(camera.width, 0, camera.height);
    for (const auto& part : detail::project(view, x, std::span(&t, 1))) detail::draw(part, alone);
    for (std::size_t i = 0; i < count.size(); ++i) count[i] += alone.triangle[i] >= 0 ? 1 : 0;
  }
  return count;
}

TEST(Raster, ATriangleCoversItsAreaInClosedForm) {
  const Camera camera = straight_camera(320, 240);
  // Depth 2, so that a metre is 60 pixels.
  const std::vector<Vec3f> x = {{-1.3F, 2.0F, -1.1F}, {1.7F, 2.0F, -0.4F}, {0.2F, 2.0F, 1.6F}};
  const double area = 0.5 * Vec3f(x[1] - x[0]).cross(Vec3f(x[2] - x[0])).norm() * 60.0 * 60.0;
  double covered = 0.0;
  for (const int n : coverage(camera, x, {{0, 1, 2}})) covered += n;
  covered /= detail::samples;
  // Eight samples a pixel err by a fraction of a pixel along each edge, of either sign.
  EXPECT_NEAR(covered, area, 0.001 * area);
}

TEST(Raster, ATriangleCoversThePixelsItShould) {
  const Camera camera = straight_camera(8, 8);
  // A square of pixels 2 to 5 in x and 1 to 3 in y, in units of a quarter metre at depth 1.
  const auto at = [](float px, float py) { return Vec3f(px / 4 - 1, 1.0F, 1 - py / 4); };
  const std::vector<Vec3f> x = {at(2, 1), at(6, 1), at(6, 4), at(2, 4)};
  const auto count = coverage(camera, x, {{0, 1, 2}, {0, 2, 3}});
  const Band layout(8, 0, 8);
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column)
      for (std::size_t s = 0; s < detail::samples; ++s)
        EXPECT_EQ(count[layout.pixel(column, row) + s],
                  column >= 2 && column < 6 && row >= 1 && row < 4 ? 1 : 0)
            << column << ' ' << row;
}

/// A fan of triangles around a vertex, whose rim encloses the whole view.
void expect_fan_covers_once(const Camera& camera, std::mt19937& random, float reach) {
  std::uniform_real_distribution<float> side(-0.8F, 0.8F), depth(1.0F, 5.0F), far(1.0F, reach);
  std::vector<Vec3f> x = {Vec3f(side(random), 1.0F, side(random)) * depth(random)};
  std::vector<Triangle> triangles;
  constexpr int n = 9;
  for (int i = 0; i < n; ++i) {
    const float angle = 2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / n;
    const float r = 3.0F * far(random), y = depth(random);
    x.push_back(Vec3f(r * std::cos(angle), 1.0F, r * std::sin(angle)) * y);
    triangles.push_back({0, i + 1, (i + 1) % n + 1});
  }
  for (const int count : coverage(camera, x, triangles)) ASSERT_EQ(count, 1);
}

TEST(Raster, TrianglesThatShareEdgesLeaveNoGapAndDrawNoSampleTwice) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE("seed 7, trial " + std::to_string(trial));
    expect_fan_covers_once(straight_camera(96, 64), random, trial % 2 == 0 ? 1.5F : 1000.0F);
  }
}

TEST(Raster, LongAndShortTrianglesAreDrawnByTheSameRule) {
  // Seen through a short picture the 32-bit edges serve, through a long one the 64-bit ones.
  constexpr unsigned seed = 11;
  std::mt19937 random(seed);
  for (int trial = 0; trial < 6; ++trial) {
    SCOPED_TRACE("seed 11, trial " + std::to_string(trial));
    expect_fan_covers_once(straight_camera(24, 16), random, 3.0F);
    expect_fan_covers_once(straight_camera(300, 200), random, 3.0F);
  }
}

TEST(Render, TheNearerTriangleIsSeenWhateverTheOrder) {
  const std::vector<Vec3> near = {{-1, 2, -1}, {1, 2, -1}, {0, 2, 1}};
  const std::vector<Vec3> far = {{-9, 4, -9}, {9, 4, -9}, {0, 4, 9}};
  const std::vector<Triangle> one = {{0, 1, 2}};
  const auto a = surface(near, one, red, red), b = surface(far, one, blue, blue);
  const Camera camera = straight_camera(64, 64);
  for (const auto& order : {std::array{a, b}, std::array{b, a}}) {
    const Image image = render(camera, order, without_ground());
    EXPECT_TRUE(is_red(pixel(image, 32, 32)));
    EXPECT_TRUE(is_blue(pixel(image, 32, 60)));
  }
}

TEST(Render, TrianglesThatCrossAreSeparatedAlongTheirCommonLine) {
  // Both pass through the line x = 0 at depth 3; left of it the red one is nearer, right the blue.
  const std::vector<Vec3> a = {{-2, 2, -9}, {2, 4, -9}, {2, 4, 9}, {-2, 2, 9}};
  const std::vector<Vec3> b = {{-2, 4, -9}, {2, 2, -9}, {2, 2, 9}, {-2, 4, 9}};
  const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
  const Image image =
      render(straight_camera(64, 64),
             std::array{surface(a, two, red, red), surface(b, two, blue, blue)}, without_ground());
  for (int row = 8; row < 56; ++row) {
    EXPECT_TRUE(is_red(pixel(image, 30, row)));
    EXPECT_TRUE(is_blue(pixel(image, 33, row)));
  }
}

TEST(Render, FrontAndBackHaveTheirOwnColours) {
  // Counter-clockwise seen from -y, where the camera is.
  const std::vector<Vec3> x = {{-5, 2, -5}, {5, 2, -5}, {0, 2, 5}};
  const Camera camera = straight_camera(32, 32);
  const std::vector<Triangle> to_camera = {{0, 1, 2}}, away = {{0, 2, 1}};
  EXPECT_TRUE(
      is_red(pixel(render(camera, std::array{surface(x, to_camera)}, without_ground()), 16, 16)));
  EXPECT_TRUE(
      is_blue(pixel(render(camera, std::array{surface(x, away)}, without_ground()), 16, 16)));
}

TEST(Render, BothSidesAreLitAlikeWhenTheirColoursAre) {
  const std::vector<Vec3> x = {{-5, 2, -5}, {5, 2.5, -5}, {0, 3, 5}};
  const Camera camera = straight_camera(32, 32);
  const std::vector<Triangle> to_camera = {{0, 1, 2}}, away = {{0, 2, 1}};
  const Image a = render(camera, std::array{surface(x, to_camera, grey, grey)}, without_ground());
  const Image b = render(camera, std::array{surface(x, away, grey, grey)}, without_ground());
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(pixel(a, 16, 16)[static_cast<std::size_t>(i)],
                pixel(b, 16, 16)[static_cast<std::size_t>(i)], 1);
}

TEST(Render, AFloorBehindTheEyeIsCutAtTheNearPlane) {
  // z = -1 from far behind the eye to far ahead: it fills the picture below the horizon, and 1000 m
  // ahead the horizon is a twentieth of a pixel lower.
  const std::vector<Vec3> x = {
      {-5000, -1000, -1}, {5000, -1000, -1}, {5000, 1000, -1}, {-5000, 1000, -1}};
  const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
  const Image image =
      render(straight_camera(100, 100), std::array{surface(x, two)}, without_ground());
  for (int column = 0; column < 100; column += 9) {
    EXPECT_FALSE(is_red(pixel(image, column, 49)));
    for (int row = 51; row < 100; ++row) EXPECT_TRUE(is_red(pixel(image, column, row))) << row;
  }
}

TEST(Render, WhatIsBehindTheEyeIsNotSeen) {
  const std::vector<Vec3> x = {{-1, -2, -1}, {1, -2, -1}, {0, -2, 1}};
  const std::vector<Triangle> one = {{0, 1, 2}};
  const Image with = render(straight_camera(32, 32), std::array{surface(x, one)}, without_ground());
  const Image empty = render(straight_camera(32, 32), {}, without_ground());
  EXPECT_EQ(with.rgb, empty.rgb);
}

/// A wavy sheet over a box: folds, shadows and silhouettes.
struct TestScene {
  std::vector<Vec3> sheet, box;
  std::vector<Triangle> sheet_triangles, box_triangles;
  std::vector<Eigen::Vector2d> material;
};

TestScene test_scene() {
  TestScene scene;
  constexpr int n = 40;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double u = i / double(n) - 0.5, v = j / double(n) - 0.5;
      scene.sheet.emplace_back(u, v, 0.4 + 0.08 * std::sin(14 * u) * std::cos(9 * v));
      scene.material.emplace_back(u, v);
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int k = j * (n + 1) + i;
      scene.sheet_triangles.push_back({k, k + 1, k + n + 2});
      scene.sheet_triangles.push_back({k, k + n + 2, k + n + 1});
    }
  for (int k = 0; k < 8; ++k)
    scene.box.emplace_back((k & 1) != 0 ? 0.2 : -0.2, (k & 2) != 0 ? 0.2 : -0.2,
                           (k & 4) != 0 ? 0.25 : 0.0);
  constexpr int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                               {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : faces) {
    scene.box_triangles.push_back({f[0], f[1], f[2]});
    scene.box_triangles.push_back({f[0], f[2], f[3]});
  }
  return scene;
}

TEST(Render, ThePictureIsTheSameForAnyNumberOfThreads) {
  const TestScene scene = test_scene();
  RenderSurface sheet = surface(scene.sheet, scene.sheet_triangles);
  sheet.sheen = 0.5;
  sheet.material = scene.material;
  RenderSurface box = surface(scene.box, scene.box_triangles, grey, grey);
  box.crease = 40.0;
  Camera camera;
  camera.width = 200;
  camera.height = 150;
  std::vector<Image> images;
  for (const int threads : {1, 2, 8}) {
    const ThreadLimit limit(threads);
    images.push_back(render(camera, std::array{sheet, box}));
  }
  EXPECT_EQ(images[0].rgb, images[1].rgb);
  EXPECT_EQ(images[0].rgb, images[2].rgb);
}

TEST(Render, ThingsCastShadowsOnEachOtherAndOnTheGround) {
  const std::vector<Vec3> roof = {
      {-0.5, -0.5, 0.6}, {0.5, -0.5, 0.6}, {0.5, 0.5, 0.6}, {-0.5, 0.5, 0.6}};
  const std::vector<Vec3> floor = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
  Camera camera;
  camera.eye = Vec3(0.0, -4.0, 0.3);
  camera.target = Vec3(0.0, 0.0, 0.1);
  camera.width = camera.height = 100;
  RenderConfig config;
  config.ground_z = 0.0;
  const auto sheet = surface(floor, two, grey, grey);
  const Image open = render(camera, std::array{sheet}, config);
  const Image covered = render(camera, std::array{sheet, surface(roof, two)}, config);
  const Image empty = render(camera, {}, config);
  const Image on_ground = render(camera, std::array{surface(roof, two)}, config);
  // The floor's middle lies 0.1 m below the target, 4 m away: 5 pixels below the middle.
  const int row =
      50 + static_cast<int>(0.1 / 4.0 * 50.0 / std::tan(35.0 / 360.0 * std::numbers::pi));
  EXPECT_LT(brightness(pixel(covered, 50, row)), 0.8 * brightness(pixel(open, 50, row)));
  EXPECT_LT(brightness(pixel(on_ground, 50, row)), 0.9 * brightness(pixel(empty, 50, row)));
}

TEST(Render, ASurfaceInTheOpenDoesNotShadeItself) {
  // A flat sheet tilted towards the light has one brightness all over but for the rounding.
  const std::vector<Vec3> x = {{-1, -1, 0}, {1, -1, 0.2}, {1, 1, 0.5}, {-1, 1, 0.3}};
  const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
  Camera camera;
  camera.eye = Vec3(0.3, -2.0, 1.5);
  camera.target = Vec3(0, 0, 0.25);
  camera.width = 160;
  camera.height = 120;
  const Image image = render(camera, std::array{surface(x, two, grey, grey)}, without_ground());
  int darkest = 1000, brightest = 0;
  for (int row = 50; row < 70; ++row)
    for (int column = 60; column < 100; ++column) {
      darkest = std::min(darkest, brightness(pixel(image, column, row)));
      brightest = std::max(brightest, brightness(pixel(image, column, row)));
    }
  EXPECT_LE(brightest - darkest, 12);
}

TEST(Render, VerticesWithoutATriangleChangeNothing) {
  const TestScene scene = test_scene();
  std::vector<Vec3> more = {Vec3(100, 100, 100)};
  more.insert(more.end(), scene.sheet.begin(), scene.sheet.end());
  more.emplace_back(-500, 0, -3);
  std::vector<Triangle> shifted = scene.sheet_triangles;
  for (Triangle& t : shifted)
    for (std::int32_t& v : t) ++v;
  Camera camera;
  camera.width = 100;
  camera.height = 75;
  EXPECT_EQ(render(camera, std::array{surface(scene.sheet, scene.sheet_triangles)}).rgb,
            render(camera, std::array{surface(more, shifted)}).rgb);
}

TEST(Render, RefusesWhatCannotBeDrawnAndNamesIt) {
  const std::vector<Vec3> x = {{0, 2, 0}, {1, 2, 0}, {0, 2, 1}};
  const std::vector<Triangle> good = {{0, 1, 2}}, bad = {{0, 1, 3}};
  std::vector<Vec3> broken = x;
  broken[1].z() = std::numeric_limits<double>::quiet_NaN();
  const Camera camera = straight_camera(8, 8);
  EXPECT_THROW(render(camera, std::array{surface(x, bad)}), std::invalid_argument);
  EXPECT_THROW(render(camera, std::array{surface(broken, good)}), std::invalid_argument);
  Camera blind = camera;
  blind.target = blind.eye;
  EXPECT_THROW(render(blind, {}), std::invalid_argument);
  Camera wide = camera;
  wide.field_of_view = 180.0;
  EXPECT_THROW(render(wide, {}), std::invalid_argument);
  EXPECT_THROW(render(straight_camera(0, 8), {}), std::invalid_argument);
  EXPECT_THROW(render(straight_camera(8, 1 << 20), {}), std::invalid_argument);
}

TEST(Render, LooksAlongUpWithoutLosingItsWay) {
  const std::vector<Vec3> x = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  const std::vector<Triangle> one = {{0, 1, 2}};
  Camera camera = straight_camera(32, 32);
  camera.eye = Vec3(0, 0, 2);
  camera.target = Vec3::Zero();
  EXPECT_TRUE(is_red(pixel(render(camera, std::array{surface(x, one)}), 16, 16)));
}

TEST(Render, AFramedBoxJustFits) {
  const Vec3 low(-1.0, 2.0, 0.5), high(3.0, 2.5, 1.0);
  for (const auto& [width, height] : {std::pair(400, 300), std::pair(100, 300)}) {
    Camera camera;
    camera.width = width;
    camera.height = height;
    camera = framed(camera, low, high);
    const auto view = detail::make_view(camera, Vec3::Zero());
    double widest = 0.0;
    for (int k = 0; k < 8; ++k) {
      const Vec3 corner((k & 1) != 0 ? high.x() : low.x(), (k & 2) != 0 ? high.y() : low.y(),
                        (k & 4) != 0 ? high.z() : low.z());
      const Vec3f d = (corner - camera.eye).cast<float>();
      const float scale = view.focal / d.dot(view.forward);
      widest = std::max({widest, std::abs(d.dot(view.right)) * scale / (0.5 * width),
                         std::abs(d.dot(view.up)) * scale / (0.5 * height)});
    }
    EXPECT_LE(widest, 1.0);
    EXPECT_GE(widest, 0.9);
  }
}

TEST(Framing, PointsReachTwoOppositeEdgesOfThePicture) {
  // A box would be seen from too far away: the points are on one of its diagonals.
  const std::vector<Vec3> points = {
      {2.0, 1.0, 0.0}, {2.4, 1.4, 0.3}, {2.5, 1.5, 0.9}, {2.1, 1.2, 0.5}};
  for (const auto& [width, height] : {std::pair{960, 720}, {400, 900}}) {
    Camera camera;
    camera.width = width;
    camera.height = height;
    const Vec3 direction = (camera.target - camera.eye).normalized();
    camera = framed(camera, points);
    EXPECT_NEAR((camera.target - camera.eye).normalized().dot(direction), 1.0, 1e-12);
    const auto view = detail::make_view(camera, Vec3::Zero());
    std::array<double, 2> low{1e9, 1e9}, high{-1e9, -1e9};
    for (const Vec3& p : points) {
      const Vec3f d = (p - camera.eye).cast<float>();
      const double scale = view.focal / d.dot(view.forward);
      const std::array<double, 2> at = {d.dot(view.right) * scale / (0.5 * width),
                                        d.dot(view.up) * scale / (0.5 * height)};
      for (std::size_t k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], at[k]);
        high[k] = std::max(high[k], at[k]);
      }
    }
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_GE(low[k], -1.0);
      EXPECT_LE(high[k], 1.0);
      EXPECT_NEAR(low[k] + high[k], 0.0, 0.2) << "in the middle";
    }
    EXPECT_GT(std::max(high[0] - low[0], high[1] - low[1]), 1.9);
  }
}

// ---- files ---------------------------------------------------------------------------------

class Pictures : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("selvedge_render_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A result of three frames: a flat square that falls, over a plane of 20 m and a small box.
  void make_result() const {
    const std::vector<Vec3> square = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const std::vector<Triangle> two = {{0, 1, 2}, {0, 2, 3}};
    fs::create_directories(folder_ / "frames");
    for (int frame = 0; frame < 3; ++frame) {
      std::vector<Vec3> x = square;
      for (Vec3& p : x) p.z() -= 0.3 * frame;
      x[2].z() -= 0.05 * frame;
      write_ply(numbered(folder_ / "frames", "cloth", frame, 5, ".ply"), x, two);
    }
    TestScene scene = test_scene();
    std::vector<Vec3> x = scene.box;
    std::vector<Triangle> triangles = scene.box_triangles;
    const auto first = static_cast<std::int32_t>(x.size());
    for (const Vec3& p : {Vec3(-10, -10, 0), Vec3(10, -10, 0), Vec3(10, 10, 0), Vec3(-10, 10, 0)})
      x.push_back(p);
    triangles.push_back({first, first + 1, first + 2});
    triangles.push_back({first, first + 2, first + 3});
    write_ply(folder_ / "frames" / "bodies_00000.ply", x, triangles);
    std::ofstream(folder_ / "scene.json")
        << R"({"time":{"fps":25},"output":{"camera":{"eye":[2,-3,1.5],"target":[0,0,0.5],)"
        << R"("field_of_view":40}}})";
  }

  fs::path folder_;
};

Image noise_image(int width, int height) {
  Image image{width, height, {}};
  std::mt19937 random(3);
  for (int i = 0; i < 3 * width * height; ++i)
    image.rgb.push_back(static_cast<std::uint8_t>(random()));
  return image;
}

Image read_png(const fs::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&png, file.c_str()) == 0)
    throw std::runtime_error(png.message);
  png.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  if (png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) == 0)
    throw std::runtime_error(png.message);
  return image;
}

template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST_F(Pictures, APngReadBackEqualsTheImage) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(37, 23)}) {
    const Image image = noise_image(width, height);
    write_png(folder_ / "a.png", image);
    const Image back = read_png(folder_ / "a.png");
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_EQ(back.rgb, image.rgb);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Pictures, APngThatCannotBeWrittenIsSaidAndNamesTheFile) {
  const Image image = noise_image(8, 8);
  const fs::path missing = folder_ / "missing" / "a.png";
  EXPECT_NE(message_of([&] { write_png(missing, image); }).find(missing.string()),
            std::string::npos);
  if (fs::exists("/dev/full")) {
    const std::string full = message_of([&] { write_png("/dev/full", image); });
    EXPECT_NE(full.find(std::strerror(ENOSPC)), std::string::npos) << full;
  }
  Image wrong = image;
  wrong.height = 9;
  EXPECT_THROW(write_png(folder_ / "a.png", wrong), std::invalid_argument);
}

TEST_F(Pictures, AResultIsDrawnWithTheCameraOfItsScene) {
  make_result();
  ResultPictures pictures(folder_);
  EXPECT_EQ(pictures.frames(), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(pictures.fps(), 25.0);
  CameraChoice choice;
  choice.width = 64;
  choice.height = 48;
  const Camera camera = pictures.camera(choice, pictures.frames());
  EXPECT_EQ(camera.eye, Vec3(2, -3, 1.5));
  EXPECT_EQ(camera.target, Vec3(0, 0, 0.5));
  EXPECT_EQ(camera.field_of_view, 40.0);
  EXPECT_EQ(std::pair(camera.width, camera.height), std::pair(64, 48));
  choice.eye = Vec3(0, -5, 1);
  choice.width = 32;
  const Camera chosen = pictures.camera(choice, pictures.frames());
  EXPECT_EQ(chosen.eye, Vec3(0, -5, 1));
  EXPECT_EQ(chosen.target, camera.target);
  EXPECT_EQ(std::pair(chosen.width, chosen.height), std::pair(32, 48));
  EXPECT_NE(pictures.picture(0, camera).rgb, pictures.picture(2, camera).rgb);
}

TEST_F(Pictures, WithoutASceneTheCameraShowsTheWholeCloth) {
  make_result();
  fs::remove(folder_ / "scene.json");
  ResultPictures pictures(folder_);
  const Camera camera = pictures.camera({}, pictures.frames());
  EXPECT_LT((camera.eye - camera.target).norm(), 6.0);
  const Image image = pictures.picture(0, camera);
  int cloth = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) cloth += is_red(pixel(image, x, y)) ? 1 : 0;
  EXPECT_GT(cloth, image.width * image.height / 50);
}

TEST_F(Pictures, AResultThatIsDamagedIsRefusedInASentence) {
  const auto refused = [&](const std::string& word) {
    const std::string message = message_of([&] { ResultPictures pictures(folder_); });
    EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  refused("frames/cloth_");
  make_result();
  std::ofstream(folder_ / "scene.json") << "{\"time\": ";
  refused("scene.json");
  fs::remove(folder_ / "scene.json");
  std::ofstream(folder_ / "frames" / "cloth_00002.ply") << "ply\nformat asc";
  refused("cloth_00002.ply");
  EXPECT_THROW(ResultPictures(folder_ / "nothing"), std::invalid_argument);
}

TEST_F(Pictures, AFrameThatIsNotThereIsRefusedWithThoseThatAre) {
  make_result();
  ResultPictures pictures(folder_);
  const std::string message =
      message_of([&] { pictures.picture(7, pictures.camera({}, std::array{0})); });
  EXPECT_NE(message.find("no frame 7"), std::string::npos) << message;
  EXPECT_NE(message.find("0 to 2"), std::string::npos) << message;
}

TEST_F(Pictures, AFrameIsWrittenWhereItShouldBeAndItsFolderMade) {
  make_result();
  CameraChoice choice;
  choice.width = 64;
  choice.height = 48;
  render_result_frame(folder_, 1, choice, folder_ / "pictures" / "frame_00001.png");
  const Image image = read_png(folder_ / "pictures" / "frame_00001.png");
  EXPECT_EQ(std::pair(image.width, image.height), std::pair(64, 48));
}

TEST_F(Pictures, AMeshFileIsDrawnAlone) {
  const TestScene scene = test_scene();
  write_ply(folder_ / "box.ply", scene.box, scene.box_triangles);
  ResultPictures pictures(folder_ / "box.ply");
  EXPECT_FALSE(pictures.is_folder());
  CameraChoice choice;
  choice.width = choice.height = 50;
  const Image image = pictures.picture(0, pictures.camera(choice, pictures.frames()));
  // Closed, so it is a body: grey.
  const Colour middle = pixel(image, 25, 25);
  EXPECT_LT(std::abs(middle[0] - middle[2]), 25);
}

TEST(ConnectedParts, AreOrderedByTheirLowestVertexAndKeepEveryTriangle) {
  const std::vector<Triangle> triangles = {{5, 6, 7}, {0, 1, 2}, {7, 8, 5}, {2, 3, 0}};
  const auto parts = connected_parts(10, triangles);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0], (std::vector<Triangle>{{0, 1, 2}, {2, 3, 0}}));
  EXPECT_EQ(parts[1], (std::vector<Triangle>{{5, 6, 7}, {7, 8, 5}}));
}

TEST_F(Pictures, AnAnimationOfAnOddSizeIsWritten) {
  if (!ffmpeg_is_there()) GTEST_SKIP() << "ffmpeg is not on PATH";
  for (const char* name : {"a.mp4", "a.gif"}) {
    AnimationWriter animation(folder_ / name, 25.0);
    for (int i = 0; i < 3; ++i) animation.add(noise_image(33, 21));
    EXPECT_FALSE(fs::exists(folder_ / name));
    animation.finish();
    EXPECT_GT(fs::file_size(folder_ / name), 100U);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 2);
}

TEST_F(Pictures, AnAnimationThatIsGivenUpLeavesNothing) {
  if (!ffmpeg_is_there()) GTEST_SKIP() << "ffmpeg is not on PATH";
  {
    AnimationWriter animation(folder_ / "a.gif", 25.0);
    animation.add(noise_image(32, 20));
    EXPECT_THROW(animation.add(noise_image(20, 32)), std::invalid_argument);
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  AnimationWriter nowhere(folder_ / "missing" / "a.gif", 25.0);
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) nowhere.add(noise_image(320, 200));
        nowhere.finish();
      },
      std::runtime_error);
}

TEST_F(Pictures, WithoutFfmpegAnAnimationIsRefusedWithARemedy) {
  const char* path = std::getenv("PATH");
  const std::string before = path != nullptr ? path : "";
  ::setenv("PATH", folder_.c_str(), 1);
  const bool there = ffmpeg_is_there();
  const std::string message =
      message_of([&] { AnimationWriter animation(folder_ / "a.mp4", 25.0); });
  ::setenv("PATH", before.c_str(), 1);
  EXPECT_FALSE(there);
  EXPECT_NE(message.find("install"), std::string::npos) << message;
  EXPECT_THROW(AnimationWriter(folder_ / "a.avi", 25.0), std::invalid_argument);
  EXPECT_THROW(AnimationWriter(folder_ / "a.mp4", 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace selvedge::render_test
