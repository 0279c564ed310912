// SPDX-License-Identifier: MIT
//
// Rasterisation by edge functions: J. Pineda, "A parallel algorithm for polygon rasterization",
// SIGGRAPH 1988. Vertices are snapped to a grid of 1/256 pixel, so that the edge functions are
// integers and every decision about a sample is exact.
#include <selvedge/core/base/parallel.h>
#include <selvedge/pictures/renderer/detail/raster.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace selvedge::detail {

const std::array<std::int32_t, samples> sample_x = {144, 112, 208, 80, 48, 16, 176, 240};
const std::array<std::int32_t, samples> sample_y = {80, 176, 144, 48, 208, 112, 240, 16};

Vec3f View::ray(float x, float y) const {
  const float dx = (x - 0.5F * static_cast<float>(width)) / focal;
  const float dy = (y - 0.5F * static_cast<float>(height)) / focal;
  return forward + dx * right - dy * up;
}

View make_view(const Camera& camera, const Vec3& origin) {
  const Vec3 forward = (camera.target - camera.eye).normalized();
  Vec3 right = forward.cross(camera.up);
  if (right.norm() < 1e-6 * camera.up.norm()) right = forward.unitOrthogonal();  // view along up
  right.normalize();
  constexpr double nearest_over_distance = 1e-3;
  View view;
  view.eye = (camera.eye - origin).cast<float>();
  view.forward = forward.cast<float>();
  view.right = right.cast<float>();
  view.up = right.cross(forward).cast<float>();
  const double half_angle = camera.field_of_view * std::numbers::pi / 360.0;
  view.focal = static_cast<float>(0.5 * camera.height / std::tan(half_angle));
  view.nearest = static_cast<float>(nearest_over_distance * (camera.target - camera.eye).norm());
  view.width = camera.width;
  view.height = camera.height;
  return view;
}

namespace {

// The five planes of the view frustum: near, left, right, top, bottom. Signed distances to them are
// positive inside. Points are in camera space: x right, y up, z forward, in metres.
constexpr int plane_count = 5;

struct Frustum {
  float nearest, focal, half_width, half_height;
  float distance(const Vec3f& p, int plane) const {
    switch (plane) {
      case 0:
        return p.z() - nearest;
      case 1:
        return half_width * p.z() + focal * p.x();
      case 2:
        return half_width * p.z() - focal * p.x();
      case 3:
        return half_height * p.z() - focal * p.y();
      default:
        return half_height * p.z() + focal * p.y();
    }
  }
  unsigned outside(const Vec3f& p) const {
    unsigned bits = 0;
    for (int plane = 0; plane < plane_count; ++plane)
      if (!(distance(p, plane) >= 0.0F)) bits |= 1U << static_cast<unsigned>(plane);
    return bits;
  }
};

/// A triangle cut by five planes has at most eight corners.
struct Polygon {
  std::array<Vec3f, 3 + plane_count> corner;
  int count = 0;
  void add(const Vec3f& p) { corner[static_cast<std::size_t>(count++)] = p; }
};

// Sutherland and Hodgman, "Reentrant polygon clipping", CACM 1974. An intersection is computed from
// the inner to the outer end, so that two triangles get the same point on their common edge.
Polygon clipped(const Polygon& polygon, const Frustum& frustum, int plane) {
  Polygon result;
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3f& p = polygon.corner[static_cast<std::size_t>(i)];
    const Vec3f& q = polygon.corner[static_cast<std::size_t>((i + 1) % polygon.count)];
    const float dp = frustum.distance(p, plane), dq = frustum.distance(q, plane);
    if (dp >= 0.0F) result.add(p);
    if ((dp >= 0.0F) == (dq >= 0.0F)) continue;
    result.add(dp >= 0.0F ? Vec3f(p + (dp / (dp - dq)) * (q - p))
                          : Vec3f(q + (dq / (dq - dp)) * (p - q)));
  }
  return result;
}

class Projector {
 public:
  Projector(const View& view, std::vector<ScreenTriangle>& out)
      : frustum_{view.nearest, view.focal, 0.5F * static_cast<float>(view.width),
                 0.5F * static_cast<float>(view.height)},
        width_(view.width),
        height_(view.height),
        out_(out) {}

  void add(const Vec3f& a, const Vec3f& b, const Vec3f& c, std::int32_t triangle) {
    const unsigned oa = frustum_.outside(a), ob = frustum_.outside(b), oc = frustum_.outside(c);
    if ((oa & ob & oc) != 0) return;
    if ((oa | ob | oc) == 0) return emit(a, b, c, triangle);
    Polygon polygon;
    for (const Vec3f* p : {&a, &b, &c}) polygon.add(*p);
    for (int plane = 0; plane < plane_count && polygon.count > 0; ++plane)
      polygon = clipped(polygon, frustum_, plane);
    for (std::size_t i = 2; i < static_cast<std::size_t>(polygon.count); ++i)
      emit(polygon.corner[0], polygon.corner[i - 1], polygon.corner[i], triangle);
  }

 private:
  struct Corner {
    std::int32_t x, y;
    double inverse_depth;
  };

  Corner on_screen(const Vec3f& p) const {
    const float scale = frustum_.focal * sub_pixels / p.z();
    const auto snap = [](float value, int limit) {
      return std::clamp(static_cast<std::int32_t>(std::lrint(value)), 0, limit * sub_pixels);
    };
    return {snap(frustum_.half_width * sub_pixels + p.x() * scale, width_),
            snap(frustum_.half_height * sub_pixels - p.y() * scale, height_), 1.0 / p.z()};
  }

  void emit(const Vec3f& pa, const Vec3f& pb, const Vec3f& pc, std::int32_t triangle) {
    Corner a = on_screen(pa), b = on_screen(pb), c = on_screen(pc);
    const double ux = b.x - a.x, uy = b.y - a.y, vx = c.x - a.x, vy = c.y - a.y;
    const double area = ux * vy - uy * vx;
    if (area == 0.0) return;
    const double du = b.inverse_depth - a.inverse_depth, dv = c.inverse_depth - a.inverse_depth;
    const double dx = (du * vy - dv * uy) / area * sub_pixels;
    const double dy = (dv * ux - du * vx) / area * sub_pixels;
    const auto depth_a = static_cast<float>(a.inverse_depth);
    if (area < 0.0) std::swap(b, c);
    out_.push_back({{a.x, b.x, c.x},
                    {a.y, b.y, c.y},
                    static_cast<float>(dx),
                    static_cast<float>(dy),
                    depth_a,
                    triangle});
  }

  Frustum frustum_;
  int width_, height_;
  std::vector<ScreenTriangle>& out_;
};

}  // namespace

std::vector<ScreenTriangle> project(const View& view, std::span<const Vec3f> x,
                                    std::span<const Triangle> triangles) {
  constexpr std::size_t vertex_grain = 8192, triangle_grain = 8192;
  std::vector<Vec3f> in_camera(x.size());
  parallel_for(x.size(), vertex_grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3f d = x[i] - view.eye;
      in_camera[i] = Vec3f(d.dot(view.right), d.dot(view.up), d.dot(view.forward));
    }
  });
  std::vector<std::vector<ScreenTriangle>> parts(triangles.size() / triangle_grain + 1);
  parallel_for(triangles.size(), triangle_grain, [&](std::size_t begin, std::size_t end) {
    auto& part = parts[begin / triangle_grain];
    part.reserve(end - begin);
    Projector projector(view, part);
    for (std::size_t k = begin; k < end; ++k) {
      const Triangle& t = triangles[k];
      projector.add(in_camera[static_cast<std::size_t>(t[0])],
                    in_camera[static_cast<std::size_t>(t[1])],
                    in_camera[static_cast<std::size_t>(t[2])], static_cast<std::int32_t>(k));
    }
  });
  std::vector<ScreenTriangle> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

Band::Band(int picture_width, int begin, int end)
    : width(picture_width), row_begin(begin), row_end(end) {
  const std::size_t n = pixel(0, end);
  inverse_depth.assign(n, 0.0F);
  triangle.assign(n, -1);
}

namespace {

/// Range of the pixels of a band that a triangle may touch; x_end and row_end are one past the
/// last.
struct PixelBox {
  int x_begin, x_end, row_begin, row_end;
};

PixelBox pixel_box(const ScreenTriangle& t, const Band& band) {
  const auto [x0, x1] = std::minmax({t.x[0], t.x[1], t.x[2]});
  const auto [y0, y1] = std::minmax({t.y[0], t.y[1], t.y[2]});
  return {x0 / sub_pixels, std::min(x1 / sub_pixels + 1, band.width),
          std::max(y0 / sub_pixels, band.row_begin), std::min(y1 / sub_pixels + 1, band.row_end)};
}

/// E(p) = a p_x + b p_y + c with p in sub-pixels from the box's corner. E ≥ 0 inside.
template <class Int>
struct EdgeFunction {
  Int a, b, c;
  Int largest_in_pixel;
  alignas(32) std::array<Int, samples> at_sample;

  EdgeFunction() = default;
  EdgeFunction(Int x0, Int y0, Int x1, Int y1) : a(y0 - y1), b(x1 - x0) {
    // With y downwards and area > 0, the inside lies below a top edge and right of a left one.
    const bool top_or_left = (a == 0 && b > 0) || a > 0;
    c = -(a * x0 + b * y0) - (top_or_left ? 0 : 1);
    largest_in_pixel = std::numeric_limits<Int>::min();
    for (std::size_t s = 0; s < samples; ++s) {
      at_sample[s] = a * static_cast<Int>(sample_x[s]) + b * static_cast<Int>(sample_y[s]);
      largest_in_pixel = std::max(largest_in_pixel, at_sample[s]);
    }
  }
  Int at(int pixels_x, int pixels_y) const {
    return a * static_cast<Int>(pixels_x * sub_pixels) +
           b * static_cast<Int>(pixels_y * sub_pixels) + c;
  }
};

template <class Int>
void draw_box(const ScreenTriangle& t, const PixelBox& box, Band& band) {
  const std::int32_t left = box.x_begin * sub_pixels, top = box.row_begin * sub_pixels;
  std::array<EdgeFunction<Int>, 3> edge;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    edge[i] = {static_cast<Int>(t.x[i] - left), static_cast<Int>(t.y[i] - top),
               static_cast<Int>(t.x[j] - left), static_cast<Int>(t.y[j] - top)};
  }
  alignas(32) std::array<float, samples> depth_at_sample;
  for (std::size_t s = 0; s < samples; ++s)
    depth_at_sample[s] = (t.depth_dx * static_cast<float>(sample_x[s]) +
                          t.depth_dy * static_cast<float>(sample_y[s])) /
                         sub_pixels;
  for (int row = box.row_begin; row < box.row_end; ++row) {
    std::array<Int, 3> e;
    for (std::size_t i = 0; i < 3; ++i) e[i] = edge[i].at(0, row - box.row_begin);
    const float depth_row =
        t.depth_a + t.depth_dy * static_cast<float>(row * sub_pixels - t.y[0]) / sub_pixels;
    for (int x = box.x_begin; x < box.x_end; ++x) {
      const std::array<Int, 3> here = e;
      for (std::size_t i = 0; i < 3; ++i) e[i] += edge[i].a * sub_pixels;
      if (((here[0] + edge[0].largest_in_pixel) | (here[1] + edge[1].largest_in_pixel) |
           (here[2] + edge[2].largest_in_pixel)) < 0)
        continue;
      const float depth =
          depth_row + t.depth_dx * static_cast<float>(x * sub_pixels - t.x[0]) / sub_pixels;
      float* nearest = band.inverse_depth.data() + band.pixel(x, row);
      std::int32_t* seen = band.triangle.data() + band.pixel(x, row);
      for (std::size_t s = 0; s < samples; ++s) {
        const Int sign = (here[0] + edge[0].at_sample[s]) | (here[1] + edge[1].at_sample[s]) |
                         (here[2] + edge[2].at_sample[s]);
        const float z = depth + depth_at_sample[s];
        const bool visible = (sign >= 0) & (z > nearest[s]);
        nearest[s] = visible ? z : nearest[s];
        seen[s] = visible ? t.triangle : seen[s];
      }
    }
  }
}

}  // namespace

void draw(const ScreenTriangle& triangle, Band& band) {
  const PixelBox box = pixel_box(triangle, band);
  if (box.row_begin >= box.row_end || box.x_begin >= box.x_end) return;
  // Edge functions are products of two lengths. They fit into 32 bits if the lengths are below 2^14
  // sub-pixels. The height is that of the whole triangle, which may extend above and below the
  // band.
  constexpr std::int32_t short_length = 1 << 14;
  const auto [y0, y1] = std::minmax({triangle.y[0], triangle.y[1], triangle.y[2]});
  const std::int32_t width = (box.x_end - box.x_begin) * sub_pixels;
  if (width < short_length && y1 - y0 + 2 * sub_pixels < short_length)
    draw_box<std::int32_t>(triangle, box, band);
  else
    draw_box<std::int64_t>(triangle, box, band);
}

}  // namespace selvedge::detail
