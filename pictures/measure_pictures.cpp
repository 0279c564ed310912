// SPDX-License-Identifier: MIT
#include <selvedge/pictures/internal/measure_pictures.h>

#include <selvedge/bodies/mesh_file.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

using Colour = std::array<std::uint8_t, 3>;

constexpr Colour paper = {255, 255, 255}, cloth_grey = {96, 100, 110},
                 support_grey = {176, 184, 196}, red = {200, 40, 40}, blue = {60, 90, 170},
                 line = {210, 210, 210};

Image blank(int width, int height) {
  Image image{width, height, {}};
  image.rgb.assign(std::size_t{3} * width * height, paper[0]);
  return image;
}

void put(Image& image, int x, int y, const Colour& colour) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::copy(colour.begin(), colour.end(),
            image.rgb.begin() + 3 * (std::ptrdiff_t{y} * image.width + x));
}

void dot(Image& image, double x, double y, const Colour& colour) {
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      put(image, static_cast<int>(x) + i, static_cast<int>(y) + j, colour);
}

/// Maps positions seen from above, in metres, to pixels.
struct PlanView {
  Vec3 centre;
  double scale;  ///< pixels per metre
  int size;

  double column(double x) const { return 0.5 * size + scale * (x - centre.x()); }
  double row(double y) const { return 0.5 * size - scale * (y - centre.y()); }
};

double edge_side(double ax, double ay, double bx, double by, double px, double py) {
  return (bx - ax) * (py - ay) - (by - ay) * (px - ax);
}

void fill_triangle(Image& image, const std::array<std::array<double, 2>, 3>& p,
                   const Colour& colour) {
  const auto [x0, x1] = std::minmax({p[0][0], p[1][0], p[2][0]});
  const auto [y0, y1] = std::minmax({p[0][1], p[1][1], p[2][1]});
  for (int y = std::max(0, static_cast<int>(y0)); y <= std::min(image.height - 1.0, y1); ++y)
    for (int x = std::max(0, static_cast<int>(x0)); x <= std::min(image.width - 1.0, x1); ++x) {
      const double cx = x + 0.5, cy = y + 0.5;
      const double a = edge_side(p[0][0], p[0][1], p[1][0], p[1][1], cx, cy),
                   b = edge_side(p[1][0], p[1][1], p[2][0], p[2][1], cx, cy),
                   c = edge_side(p[2][0], p[2][1], p[0][0], p[0][1], cx, cy);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0)) put(image, x, y, colour);
    }
}

void draw_circle(Image& image, const PlanView& view, double radius, const Colour& colour) {
  constexpr int points = 2000;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / points;
    dot(image, view.column(view.centre.x() + radius * std::cos(angle)),
        view.row(view.centre.y() + radius * std::sin(angle)), colour);
  }
}

/// Linear RGB from blue at -1 through white at 0 to red at 1.
Vec3 diverging(double t) {
  const Vec3 white(0.85, 0.85, 0.85), cold(0.02, 0.08, 0.5), hot(0.6, 0.02, 0.02);
  return white + std::min(1.0, std::abs(t)) * ((t < 0.0 ? cold : hot) - white);
}

}  // namespace

Image draw_strain(const Camera& camera, const StrainView& view) {
  constexpr int bins = 31;  // odd, so that strain 0 has its own bin
  std::array<std::vector<Triangle>, bins> triangles;
  for (std::size_t i = 0; i < view.triangles.size(); ++i) {
    const TriangleStrain& s = view.strains[i];
    const double strain = std::abs(s.larger) > std::abs(s.smaller) ? s.larger : s.smaller;
    const double t = std::clamp(strain / view.range, -1.0, 1.0);
    triangles[static_cast<int>(std::lround(0.5 * (t + 1.0) * (bins - 1)))].push_back(
        view.triangles[i]);
  }
  std::vector<RenderSurface> surfaces(view.others.begin(), view.others.end());
  for (int bin = 0; bin < bins; ++bin) {
    if (triangles[bin].empty()) continue;
    RenderSurface surface{view.x, triangles[bin]};
    surface.front = surface.back = diverging(2.0 * bin / (bins - 1.0) - 1.0);
    surfaces.push_back(surface);
  }
  return render(camera, surfaces);
}

Image draw_shadow(std::span<const Vec3> x, std::span<const Triangle> triangles,
                  const DrapeMeasures& drape, const DrapeSupport& support) {
  constexpr int size = 800;
  constexpr double share = 0.46;  // radius of the flat specimen as a fraction of the picture
  const double specimen = std::sqrt(drape.specimen / std::numbers::pi);
  const PlanView view{support.centre, share * size / specimen, size};
  Image image = blank(size, size);
  for (const Triangle& t : triangles) {
    std::array<std::array<double, 2>, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = {view.column(x[t[k]].x()), view.row(x[t[k]].y())};
    fill_triangle(image, p, cloth_grey);
  }
  for (int row = 0; row < size; ++row)
    for (int column = 0; column < size; ++column)
      if (std::hypot(column + 0.5 - 0.5 * size, row + 0.5 - 0.5 * size) <
          view.scale * support.radius)
        put(image, column, row, support_grey);
  draw_circle(image, view, specimen, line);
  const auto n = drape.rim.radius.size();
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / n, r = drape.rim.radius[k];
    dot(image, view.column(support.centre.x() + r * std::cos(angle)),
        view.row(support.centre.y() + r * std::sin(angle)), red);
  }
  return image;
}

Image draw_spectrum(const RimProfile& rim) {
  constexpr int width = 800, height = 400, margin = 20, orders = 24;
  Image image = blank(width, height);
  double largest = 0.0;
  const int last = std::min<int>(orders, static_cast<int>(rim.amplitude.size()) - 1);
  for (int n = 1; n <= last; ++n) largest = std::max(largest, rim.amplitude[n]);
  const double slot = (width - 2.0 * margin) / orders;
  for (int n = 1; n <= last && largest > 0.0; ++n) {
    const int bar = static_cast<int>((height - 2.0 * margin) * rim.amplitude[n] / largest);
    for (int i = 2; i < static_cast<int>(slot) - 2; ++i)
      for (int j = 0; j < bar; ++j)
        put(image, margin + static_cast<int>((n - 1) * slot) + i, height - margin - j,
            n == rim.folds ? red : blue);
  }
  for (int i = margin; i < width - margin; ++i) put(image, i, height - margin + 1, line);
  return image;
}

void draw_measures(const ResultMeasures& m, const fs::path& result, const fs::path& folder) {
  const std::vector<int> shown = {m.frame};
  const Camera camera = ResultPictures(result).camera({}, shown);
  std::vector<RenderSurface> bodies;
  TriangleMesh body;
  for (const int frame : {m.frame, 0}) {
    const fs::path file = numbered(result / "frames", "bodies", frame, kFrameFileDigits, ".ply");
    if (!fs::exists(file)) continue;
    body = read_mesh(file);
    RenderSurface surface{body.vertices, body.triangles};
    surface.front = surface.back = Vec3(0.35, 0.36, 0.38);
    surface.crease = 40.0;
    bodies.push_back(surface);
    break;
  }
  write_png(folder / "strain.png",
            draw_strain(camera, {m.x, m.triangles, m.triangle_strains, bodies, m.picture_range}));
  if (!m.drape) return;
  write_png(folder / "shadow.png", draw_shadow(m.x, m.triangles, *m.drape, *m.support));
  write_png(folder / "spectrum.png", draw_spectrum(m.drape->rim));
}

}  // namespace selvedge
