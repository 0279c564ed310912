// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/detail/drawn_copy.h>
#include <selvedge/broadphase/detail/surface_check.h>
#include <selvedge/broadphase/image_space/detail/offscreen.h>
#include <selvedge/broadphase/image_space/image_space.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/types.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

constexpr std::size_t kGrain = 2048;  // particles per range: about 100 µs of work
/// If the depths of four texels differ by more than this number of texel sides, they do not show
/// one piece of the surface (or show one steeper than 83 degrees); the nearest texel is used
/// instead of interpolation.
constexpr double kSteepest = 8.0;
/// Squares of coordinates must not overflow a float; no drawn surface is nearly that large.
constexpr double kFar = 1e15;

std::string text(const Edge& e) { return std::to_string(e[0]) + " to " + std::to_string(e[1]); }

/// The first edge, by its vertices, that is not used equally often in both directions.
std::optional<Edge> open_edge(std::span<const Triangle> triangles) {
  std::vector<Edge> forward, backward;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = t[k], w = t[(k + 1) % 3];
      (v < w ? forward : backward).push_back({std::min(v, w), std::max(v, w)});
    }
  std::sort(forward.begin(), forward.end());
  std::sort(backward.begin(), backward.end());
  const auto [f, b] =
      std::mismatch(forward.begin(), forward.end(), backward.begin(), backward.end());
  if (f == forward.end() && b == backward.end()) return std::nullopt;
  return f == forward.end() || (b != backward.end() && *b < *f) ? *b : *f;
}

Vec3 shortest_axis(std::span<const Vec3> x) {
  Vec3 lo = x[0], hi = x[0];
  for (const Vec3& p : x) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  int shortest = 0;
  (hi - lo).minCoeff(&shortest);
  return Vec3::Unit(shortest);
}

/// Upright pictures: up is as close to z as the axis allows.
detail::MapAxes axes_along(const Vec3& axis) {
  detail::MapAxes axes;
  axes.toward = axis.stableNormalized();
  const bool looks_along_z = std::abs(axes.toward[2]) > 0.5 * std::numbers::sqrt3;
  const Vec3 near_up = looks_along_z ? Vec3::UnitY() : Vec3::UnitZ();
  axes.right = near_up.cross(axes.toward).normalized();
  axes.up = axes.toward.cross(axes.right);
  return axes;
}

void take(const detail::Layer& layer, double half_depth, DepthNormalLayer& out) {
  const std::size_t n = layer.triangle.size();
  out.triangle = layer.triangle;
  out.depth.resize(n);
  out.normal.resize(n);
  out.displacement.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const float* c = layer.normal_depth.data() + 4 * i;
    const float* m = layer.motion.data() + 4 * i;
    out.normal[i] = {c[0], c[1], c[2]};
    out.depth[i] = static_cast<float>(c[3] * half_depth);
    out.displacement[i] = {m[0], m[1], m[2]};
  }
}

/// A texel and its weight in an interpolated value.
struct Sample {
  std::size_t texel;
  double weight;
};

/// The surface of one side at one place.
struct Seen {
  double depth = 0.0;
  Vec3 normal = Vec3::Zero(), displacement = Vec3::Zero();
  std::int32_t triangle = -1;
};

}  // namespace

struct DepthNormalMaps::State {
  DepthNormalConfig config;
  std::optional<detail::OffscreenRenderer> renderer;  // created when there is something to draw
  detail::DrawnCopy drawn;
  detail::MapFrame frame;
  DepthNormalLayer front, back;
  detail::Layer scratch_front, scratch_back;
  std::size_t renders = 0;

  void check(const SurfaceView& body) const;
  void draw(const SurfaceView& body);
  ParticleAnswer answer(const Vec3& point) const;
  std::int32_t triangle_at(const DepthNormalLayer& side, double u, double v) const;
  int samples(const DepthNormalLayer& side, double u, double v, std::array<Sample, 4>& out) const;
  std::optional<Seen> look(const DepthNormalLayer& side, double u, double v) const;
};

void DepthNormalMaps::State::check(const SurfaceView& body) const {
  detail::check_shape(body, "depth maps: body");
  detail::check_indices(body, "depth maps: body");
  detail::check_finite(body, "depth maps: body");
  if (body.triangles.empty())
    throw std::invalid_argument("depth maps: the body has no triangles; there is nothing to draw");
  for (std::size_t i = 0; i < body.x_t1.size(); ++i)
    if (!(body.x_t1[i].cwiseAbs().maxCoeff() <= kFar))
      throw std::invalid_argument("depth maps: vertex " + std::to_string(i) +
                                  " of the body lies more than 1e15 m from the origin");
  if (config.allow_open || drawn.same_triangles(body)) return;
  if (const auto edge = open_edge(body.triangles))
    throw std::invalid_argument("depth maps: the edge from vertex " + text(*edge) +
                                " of the body has no triangle on its other side, so the body has "
                                "no inside; close it");
}

void DepthNormalMaps::State::draw(const SurfaceView& body) {
  const Vec3 axis = config.axis.isZero(0.0) ? shortest_axis(body.x_t1) : config.axis;
  frame = detail::frame_around(body.x_t1, body.triangles, axes_along(axis), config.resolution,
                               "depth maps: body");
  const std::vector<Vec3> normals = vertex_normals(body.x_t1, body.triangles);
  std::vector<Vec3> motion(body.x_t1.size());
  for (std::size_t i = 0; i < motion.size(); ++i) motion[i] = body.x_t1[i] - body.x_t0[i];
  if (!renderer) renderer.emplace();
  renderer->draw(frame, body.x_t1, body.triangles, {normals, motion}, scratch_front, scratch_back);
  const double half_depth = frame.half[2] / detail::kDepthRange;
  take(scratch_front, half_depth, front);
  take(scratch_back, half_depth, back);
  ++renders;
}

/// The triangle at the nearest texel; -1: none.
std::int32_t DepthNormalMaps::State::triangle_at(const DepthNormalLayer& side, double u,
                                                 double v) const {
  if (!(u >= 0.0 && v >= 0.0 && u < frame.width && v < frame.height)) return -1;
  const auto row = static_cast<std::size_t>(frame.width);
  return side.triangle[static_cast<std::size_t>(v) * row + static_cast<std::size_t>(u)];
}

/// Writes the covered texels around a place and their weights; returns their number, 0, 1 or 4.
int DepthNormalMaps::State::samples(const DepthNormalLayer& side, double u, double v,
                                    std::array<Sample, 4>& out) const {
  if (!(u >= 0.0 && v >= 0.0 && u < frame.width && v < frame.height)) return 0;
  const auto row = static_cast<std::size_t>(frame.width);
  const std::size_t nearest = static_cast<std::size_t>(v) * row + static_cast<std::size_t>(u);
  const double x = std::max(u - 0.5, 0.0), y = std::max(v - 0.5, 0.0);
  const double fx = x - std::floor(x), fy = y - std::floor(y);
  const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
  if (i + 1 < row && j + 1 < static_cast<std::size_t>(frame.height)) {
    const std::size_t at = j * row + i;
    out = {{{at, (1 - fx) * (1 - fy)},
            {at + 1, fx * (1 - fy)},
            {at + row, (1 - fx) * fy},
            {at + row + 1, fx * fy}}};
    const auto covered = [&](const Sample& s) { return side.triangle[s.texel] >= 0; };
    const auto shallower = [&](const Sample& s, const Sample& t) {
      return side.depth[s.texel] < side.depth[t.texel];
    };
    const auto [lo, hi] = std::minmax_element(out.begin(), out.end(), shallower);
    if (std::all_of(out.begin(), out.end(), covered) &&
        side.depth[hi->texel] - side.depth[lo->texel] <= kSteepest * frame.texel)
      return 4;
  }
  out[0] = {nearest, 1.0};
  return side.triangle[nearest] >= 0 ? 1 : 0;
}

std::optional<Seen> DepthNormalMaps::State::look(const DepthNormalLayer& side, double u,
                                                 double v) const {
  std::array<Sample, 4> sample;
  const int count = samples(side, u, v, sample);
  if (count == 0) return std::nullopt;
  Seen seen;
  seen.triangle = triangle_at(side, u, v);
  for (int k = 0; k < count; ++k) {
    const auto [texel, weight] = sample[static_cast<std::size_t>(k)];
    seen.depth += weight * side.depth[texel];
    seen.normal += weight * side.normal[texel].cast<double>();
    seen.displacement += weight * side.displacement[texel].cast<double>();
  }
  return seen;
}

ParticleAnswer DepthNormalMaps::State::answer(const Vec3& point) const {
  const Vec3 place = frame.place(point);
  const auto seen_front = look(front, place[0], place[1]);
  const auto seen_back = look(back, place[0], place[1]);
  ParticleAnswer a;
  if (!seen_front || !seen_back) return a;
  const double beneath_front = seen_front->depth - place[2];
  const double beneath_back = place[2] - seen_back->depth;
  a.covered = true;
  a.inside = beneath_front >= 0.0 && beneath_back >= 0.0;
  a.front = beneath_front <= beneath_back;
  a.depth = std::min(beneath_front, beneath_back);
  const Seen& nearer = a.front ? *seen_front : *seen_back;
  const double length = nearer.normal.norm();
  a.normal = length > 0.0 ? Vec3(nearer.normal / length)
                          : Vec3(a.front ? frame.axes.toward : -frame.axes.toward);
  a.displacement = nearer.displacement;
  a.triangle = nearer.triangle;
  return a;
}

DepthNormalMaps::DepthNormalMaps(const DepthNormalConfig& config)
    : state_(std::make_unique<State>()) {
  detail::checked_resolution(config.resolution, "depth maps");
  if (!config.axis.allFinite())
    throw std::invalid_argument("depth maps: the axis is not finite; give a direction");
  state_->config = config;
}
DepthNormalMaps::~DepthNormalMaps() = default;
DepthNormalMaps::DepthNormalMaps(DepthNormalMaps&&) noexcept = default;
DepthNormalMaps& DepthNormalMaps::operator=(DepthNormalMaps&&) noexcept = default;

bool DepthNormalMaps::update(const SurfaceView& body) {
  if (state_->drawn.is(body)) return false;
  state_->check(body);
  state_->drawn.forget();
  state_->draw(body);
  state_->drawn.set(body);
  return true;
}

void DepthNormalMaps::answer(std::span<const Vec3> points,
                             std::span<ParticleAnswer> answers) const {
  if (points.size() != answers.size())
    throw std::invalid_argument("depth maps: room for " + std::to_string(answers.size()) +
                                " answers to " + std::to_string(points.size()) + " points");
  if (state_->renders == 0)
    throw std::invalid_argument("depth maps: no body has been drawn yet; call update first");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw std::invalid_argument("depth maps: point " + std::to_string(i) + " is not finite");
  parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) answers[i] = state_->answer(points[i]);
  });
}

std::array<std::int32_t, 2> DepthNormalMaps::triangles_at(const Vec3& point) const {
  const Vec3 place = state_->frame.place(point);
  return {state_->triangle_at(state_->front, place[0], place[1]),
          state_->triangle_at(state_->back, place[0], place[1])};
}

const DepthNormalLayer& DepthNormalMaps::front() const { return state_->front; }
const DepthNormalLayer& DepthNormalMaps::back() const { return state_->back; }
int DepthNormalMaps::width() const { return state_->frame.width; }
int DepthNormalMaps::height() const { return state_->frame.height; }
double DepthNormalMaps::texel() const { return state_->frame.texel; }
double DepthNormalMaps::sideways_error() const {
  return 0.5 * std::numbers::sqrt2 * state_->frame.texel;
}
Vec3 DepthNormalMaps::axis() const { return state_->frame.axes.toward; }
Vec3 DepthNormalMaps::center() const { return state_->frame.center; }
std::size_t DepthNormalMaps::renders() const { return state_->renders; }

}  // namespace selvedge
