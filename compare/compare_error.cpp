// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;

/// Smaller differences are rounding of positions of about a metre.
constexpr double kRounding = 1e-12;

/// Each refinement must reduce the difference at least by this factor to count as convergence.
constexpr double kLeastGain = 0.8;

/// Cell size of the triangle table, over the mean edge length.
constexpr double kCell = 2.0;

using CellKey = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

/// Locates points on a surface at its start.
class SurfaceLookup {
 public:
  explicit SurfaceLookup(const ClothEnds& cloth) : cloth_(cloth) {
    double sum = 0.0;
    for (const Triangle& t : cloth.triangles) sum += (cloth.start[t[1]] - cloth.start[t[0]]).norm();
    size_ = kCell * sum / static_cast<double>(std::max<std::size_t>(cloth.triangles.size(), 1));
    for (std::size_t t = 0; t < cloth.triangles.size(); ++t) insert(t);
  }

  /// End position of the surface point that starts nearest to p.
  Vec3 end_of(const Vec3& p) const {
    double best = std::numeric_limits<double>::infinity();
    Vec3 end = Vec3::Zero();
    const auto try_triangle = [&](std::size_t t) { look_at(p, t, best, end); };
    if (const auto found = cells_.find(key(p)); found != cells_.end())
      for (const std::size_t t : found->second) try_triangle(t);
    if (best > size_ * size_)
      for (std::size_t t = 0; t < cloth_.triangles.size(); ++t) try_triangle(t);
    return end;
  }

 private:
  CellKey key(const Vec3& p) const {
    const auto at = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size_)); };
    return {at(p.x()), at(p.y()), at(p.z())};
  }

  void insert(std::size_t t) {
    Vec3 low = cloth_.start[cloth_.triangles[t][0]], high = low;
    for (const std::int32_t v : cloth_.triangles[t]) {
      low = low.cwiseMin(cloth_.start[v]);
      high = high.cwiseMax(cloth_.start[v]);
    }
    // Slightly larger than the bounding box, so that rounding excludes no point.
    const auto [x0, y0, z0] = key(low - Vec3::Constant(kRounding + 0.01 * size_));
    const auto [x1, y1, z1] = key(high + Vec3::Constant(kRounding + 0.01 * size_));
    for (auto x = x0; x <= x1; ++x)
      for (auto y = y0; y <= y1; ++y)
        for (auto z = z0; z <= z1; ++z) cells_[{x, y, z}].push_back(t);
  }

  void look_at(const Vec3& p, std::size_t t, double& best, Vec3& end) const {
    const Triangle& corner = cloth_.triangles[t];
    const auto at = [&](const std::vector<Vec3>& x, int k) { return x[corner[k]]; };
    const auto& s = cloth_.start;
    const auto closest = point_triangle_closest(p, at(s, 0), at(s, 1), at(s, 2));
    // weight: 1 for the point, minus the barycentric coordinates for the corners
    Vec3 near = Vec3::Zero(), there = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      near -= closest.weight[k + 1] * at(s, k);
      there -= closest.weight[k + 1] * at(cloth_.end, k);
    }
    const double square = (p - near).squaredNorm();
    if (square >= best) return;
    best = square;
    end = there;
  }

  const ClothEnds& cloth_;
  double size_;
  std::map<CellKey, std::vector<std::size_t>> cells_;
};

double root_mean_square(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(a.size(), 1)));
}

Vec3 mean(const std::vector<Vec3>& x) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : x) sum += p;
  return sum / static_cast<double>(x.size());
}

double end_time(const Scene& scene) { return scene.time.frames / scene.time.fps; }

double free_fall_error(const Scene& scene, const BuiltScene& built, const ClothEnds& ends) {
  const double t = end_time(scene);
  std::vector<Vec3> exact;
  for (std::size_t i = 0; i < ends.start.size(); ++i)
    exact.push_back(ends.start[i] + t * built.velocity[i] + 0.5 * t * t * scene.gravity);
  return root_mean_square(ends.end, exact) / ends.extent();
}

double incline_error(const Scene& scene, const ClothEnds& ends) {
  const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& b) {
    return b.name == scene.closed_form.body;
  });
  const Vec3 normal = body->placement.rotation * Vec3::UnitZ();
  const Vec3 downhill = scene.gravity - normal.dot(scene.gravity) * normal;
  const double g = scene.gravity.norm();
  const double slope = std::atan2(downhill.norm(), std::abs(normal.dot(scene.gravity)));
  const double exact = slide(g, slope, body->friction, end_time(scene));
  const double moved = downhill.normalized().dot(mean(ends.end) - mean(ends.start));
  return std::abs(moved - exact) / ends.extent();
}

}  // namespace

double slide(double gravity, double slope, double friction, double t) {
  const double acceleration = gravity * (std::sin(slope) - friction * std::cos(slope));
  return 0.5 * std::max(0.0, acceleration) * t * t;
}

double ClothEnds::extent() const {
  Vec3 low = start.front(), high = low;
  for (const Vec3& x : start) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

std::optional<ClothEnds> read_ends(const fs::path& cell) {
  const auto file = [&](int frame) {
    return numbered(cell / "frames", "cloth", frame, kFrameFileDigits, ".ply");
  };
  if (!fs::exists(file(0)) || !fs::exists(file(kEndFrame))) return std::nullopt;
  const TriangleMesh start = read_mesh(file(0)), end = read_mesh(file(kEndFrame));
  if (start.vertices.empty() || start.vertices.size() != end.vertices.size()) return std::nullopt;
  return ClothEnds{start.vertices, end.vertices, start.triangles};
}

double distance(const ClothEnds& a, const ClothEnds& b) {
  if (a.triangles == b.triangles && a.end.size() == b.end.size())
    return root_mean_square(a.end, b.end) / b.extent();
  const SurfaceLookup surface(b);
  std::vector<Vec3> there;
  there.reserve(a.start.size());
  for (const Vec3& p : a.start) there.push_back(surface.end_of(p));
  return root_mean_square(a.end, there) / b.extent();
}

Convergence judge_convergence(double coarse, double fine) {
  Convergence c;
  if (fine <= kRounding) {
    c.converges = true;
    c.uncertainty = kRounding;
    c.sentence = "three refinements give the same but for rounding";
    return c;
  }
  c.order = std::log2(coarse / fine);
  c.converges = fine < kLeastGain * coarse;
  c.uncertainty = c.converges ? fine / (std::exp2(c.order) - 1.0) : std::max(coarse, fine);
  c.sentence = c.converges
                   ? fmt::format(
                         "three refinements converge with order {:.2f}; the finest is off "
                         "by about {:.2g} of the cloth's extent",
                         c.order, c.uncertainty)
                   : fmt::format(
                         "the reference does NOT converge: refinements differ by {:.2g} and "
                         "then by {:.2g} of the cloth's extent; smaller errors mean nothing",
                         coarse, fine);
  return c;
}

ErrorMeasure::ErrorMeasure(fs::path out, const ComparePlan& plan, const Methods& methods)
    : out_(std::move(out)), methods_(methods), kind_(plan.reference) {
  convergence_.sentence = "nothing but the first cell to compare with";
  if (kind_ == ReferenceKind::closed_form) {
    convergence_ = {true, 0.0, 0.0, "the closed form that the scene names"};
    return;
  }
  if (kind_ != ReferenceKind::converged) return;
  std::vector<ClothEnds> levels;
  for (const std::string& level : plan.levels) {
    const auto run = read_cell_run(cell_folder(out_, level), 0);
    auto ends = read_ends(cell_folder(out_, level));
    if (!run || run->status != RunStatus::ok || !ends) {
      convergence_.sentence = "no reference: its run did not come to an end" +
                              (run && !run->why.empty() ? ", " + run->why : std::string());
      return;
    }
    levels.push_back(std::move(*ends));
  }
  convergence_ = judge_convergence(distance(levels[0], levels[1]), distance(levels[1], levels[2]));
  finest_ = std::move(levels[2]);
}

std::optional<double> ErrorMeasure::error(const std::string& cell) const {
  if (kind_ == ReferenceKind::closed_form) return closed_form_error(cell);
  if (!finest_) return std::nullopt;
  const auto ends = read_ends(cell_folder(out_, cell));
  return ends ? std::optional(distance(*ends, *finest_)) : std::nullopt;
}

std::optional<double> ErrorMeasure::closed_form_error(const std::string& cell) const {
  const auto ends = read_ends(cell_folder(out_, cell));
  if (!ends) return std::nullopt;
  const Scene scene = read_scene(cell_folder(out_, cell) / "scene.json", {}, methods_);
  if (scene.closed_form.motion == ClosedForm::incline) return incline_error(scene, *ends);
  return free_fall_error(scene, build_scene(scene), *ends);
}

}  // namespace selvedge
