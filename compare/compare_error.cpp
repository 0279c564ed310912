// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/compare/detail/compare_error.h>
#include <selvedge/compare/internal/ablation.h>
#include <selvedge/core/base/registry.h>
#include <selvedge/narrowphase/distance.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/build.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace selvedge::detail {
namespace {

namespace fs = std::filesystem;

/// Smaller differences are rounding of positions of about a metre.
constexpr double kRounding = 1e-12;

/// Each refinement must reduce the difference at least by this factor to count as convergence.
constexpr double kLeastGain = 0.8;

/// Cell size of the triangle table, over the mean edge length, and how many rings of cells around a
/// point are searched before all triangles are.
constexpr double kCell = 2.0;
constexpr int kRings = 8;

using CellKey = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

/// The nearest point of a surface to any point.
class NearestPoint {
 public:
  struct Found {
    std::size_t triangle = 0;
    std::array<double, 3> weight{};                           // of the corners
    double square = std::numeric_limits<double>::infinity();  // m², of the distance
  };

  NearestPoint(std::span<const Vec3> x, std::span<const Triangle> triangles)
      : x_(x), triangles_(triangles) {
    double sum = 0.0;
    for (const Triangle& t : triangles) sum += (x[t[1]] - x[t[0]]).norm();
    size_ = kCell * sum / static_cast<double>(std::max<std::size_t>(triangles.size(), 1));
    for (std::size_t t = 0; t < triangles.size(); ++t) insert(t);
  }

  Found to(const Vec3& p) const {
    Found best;
    // A triangle lies in every cell that its box touches. One that lies in no cell within `ring` of
    // that of p is farther than ring * size_ from p.
    for (int ring = 0; ring <= kRings; ++ring) {
      look_at_ring(p, ring, best);
      if (best.square <= size_ * size_ * ring * ring) return best;
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t) look_at(p, t, best);
    return best;
  }

 private:
  CellKey key(const Vec3& p) const {
    const auto at = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size_)); };
    return {at(p.x()), at(p.y()), at(p.z())};
  }

  void insert(std::size_t t) {
    Vec3 low = x_[triangles_[t][0]], high = low;
    for (const std::int32_t v : triangles_[t]) {
      low = low.cwiseMin(x_[v]);
      high = high.cwiseMax(x_[v]);
    }
    // Slightly larger than the bounding box, so that rounding excludes no point.
    const auto [x0, y0, z0] = key(low - Vec3::Constant(kRounding + 0.01 * size_));
    const auto [x1, y1, z1] = key(high + Vec3::Constant(kRounding + 0.01 * size_));
    for (auto x = x0; x <= x1; ++x)
      for (auto y = y0; y <= y1; ++y)
        for (auto z = z0; z <= z1; ++z) cells_[{x, y, z}].push_back(t);
  }

  void look_at_ring(const Vec3& p, int ring, Found& best) const {
    const auto [x, y, z] = key(p);
    for (int i = -ring; i <= ring; ++i)
      for (int j = -ring; j <= ring; ++j) {
        const bool on_side = std::abs(i) == ring || std::abs(j) == ring;
        for (int k = -ring; k <= ring; k += on_side ? 1 : 2 * ring) {
          const auto found = cells_.find({x + i, y + j, z + k});
          if (found == cells_.end()) continue;
          for (const std::size_t t : found->second) look_at(p, t, best);
        }
      }
  }

  void look_at(const Vec3& p, std::size_t t, Found& best) const {
    const Triangle& corner = triangles_[t];
    const auto closest = point_triangle_closest(p, x_[corner[0]], x_[corner[1]], x_[corner[2]]);
    const double square = closest.separation.squaredNorm();
    if (square >= best.square) return;
    best.triangle = t;
    best.square = square;
    // 1 for the point, minus the barycentric coordinates for the corners
    for (std::size_t k = 0; k < 3; ++k) best.weight[k] = -closest.weight[k + 1];
  }

  std::span<const Vec3> x_;
  std::span<const Triangle> triangles_;
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

std::optional<double> measure(const RunResult& r, const char* name) {
  const auto found = r.measures.find(name);
  return found == r.measures.end() ? std::nullopt : std::optional(found->second);
}

std::optional<double> total_energy(const RunResult& r) {
  double sum = 0.0;
  bool any = false;
  for (const auto& [name, value] : r.measures)
    if (name.starts_with("energy_")) {
      sum += value;
      any = true;
    }
  return any ? std::optional(sum) : std::nullopt;
}

bool is_position(const ErrorQuantity& quantity) { return quantity.distance == &distance; }

/// Half the 90 % interval of a mean, from the sum of the squared deviations of n values.
double half_interval(double squares, std::size_t n) {
  if (n < 2) return 0.0;
  const auto count = static_cast<double>(n);
  return student_95(n - 1) * std::sqrt(squares / (count - 1.0) / count);
}

/// Mean of a quantity over the members, with its interval. Empty if a member does not have it.
std::optional<Difference> mean_value(const ErrorQuantity& quantity, const CellEnd& end) {
  std::vector<double> values;
  for (const RunResult& result : end.results) {
    const auto value = quantity.value(result);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    values.push_back(*value);
  }
  double mean = 0.0, squares = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return Difference{mean, half_interval(squares, values.size())};
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
  const BodySpec& body = scene.bodies.at(0);
  const Vec3 normal = body.placement.rotation * Vec3::UnitZ();
  const Vec3 downhill = scene.gravity - normal.dot(scene.gravity) * normal;
  const double g = scene.gravity.norm();
  const double slope = std::atan2(downhill.norm(), std::abs(normal.dot(scene.gravity)));
  const double exact = slide(g, slope, body.friction, end_time(scene));
  const double moved = downhill.normalized().dot(mean(ends.end) - mean(ends.start));
  return std::abs(moved - exact) / ends.extent();
}

}  // namespace

double slide(double gravity, double slope, double friction, double t) {
  const double acceleration = gravity * (std::sin(slope) - friction * std::cos(slope));
  return 0.5 * std::max(0.0, acceleration) * t * t;
}

double distance(const ClothEnds& a, const ClothEnds& b) {
  if (a.triangles == b.triangles && a.end.size() == b.end.size())
    return root_mean_square(a.end, b.end) / b.extent();
  const NearestPoint surface(b.start, b.triangles);
  std::vector<Vec3> there;
  there.reserve(a.start.size());
  for (const Vec3& p : a.start) {
    const NearestPoint::Found found = surface.to(p);
    Vec3 end = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      end += found.weight[k] * b.end[b.triangles[found.triangle][k]];
    there.push_back(end);
  }
  return root_mean_square(a.end, there) / b.extent();
}

double hausdorff_distance(const ClothEnds& a, const ClothEnds& b) {
  double square = 0.0;
  const auto add = [&](const ClothEnds& from, const ClothEnds& to) {
    const NearestPoint surface(to.end, to.triangles);
    for (const Vec3& p : from.end) square = std::max(square, surface.to(p).square);
  };
  add(a, b);
  add(b, a);
  return std::sqrt(square) / b.extent();
}

std::span<const ErrorQuantity> error_quantities() {
  static const std::array<ErrorQuantity, 6> all = {{
      {"position", "of the cloth's extent", "root mean square distance of the particles", distance,
       nullptr},
      {"hausdorff", "of the cloth's extent", "Hausdorff distance of the surfaces",
       hausdorff_distance, nullptr},
      {"drape", "percentage points", "drape coefficient", nullptr,
       [](const RunResult& r) { return measure(r, "drape_coefficient"); }},
      {"strain", "of 1", "root mean square of the principal strains", nullptr,
       [](const RunResult& r) { return measure(r, "strain_rms"); }},
      {"energy", "J", "kinetic, elastic and potential energy", nullptr, total_energy},
      {"penetration", "m", "deepest penetration in any frame", nullptr,
       [](const RunResult& r) { return std::optional(r.max_penetration_m); }},
  }};
  return all;
}

const ErrorQuantity& error_quantity(const std::string& name) {
  for (const ErrorQuantity& quantity : error_quantities())
    if (quantity.name == name) return quantity;
  throw std::invalid_argument(
      fmt::format("--error {}: there is no such quantity; nearest is \"{}\"", name,
                  nearest_word(name, error_names())));
}

std::optional<CellEnd> read_cell_end(const fs::path& cell, int members) {
  CellEnd end;
  std::vector<ClothEnds> shapes;
  for (int member = 0; member < members; ++member) {
    auto run = read_cell_run(cell, member);
    auto shape = read_ends(cell, member);
    if (!run || run->status != RunStatus::ok || !shape) return std::nullopt;
    if (!shapes.empty() && shape->end.size() != shapes.front().end.size()) return std::nullopt;
    shapes.push_back(std::move(*shape));
    end.results.push_back(std::move(run->result));
  }
  end.mean = shapes.front();
  const double n = static_cast<double>(members);
  for (std::size_t i = 0; i < end.mean.end.size(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (const ClothEnds& shape : shapes) sum += shape.end[i];
    end.mean.end[i] = sum / n;
  }
  if (members < 2) return end;
  double squares = 0.0;
  for (const ClothEnds& shape : shapes) {
    const double d = distance(shape, end.mean);
    squares += d * d;
  }
  end.half = half_interval(squares, shapes.size());
  return end;
}

std::optional<Difference> difference(const ErrorQuantity& quantity, const CellEnd& a,
                                     const CellEnd& b) {
  if (quantity.distance != nullptr)
    return Difference{quantity.distance(a.mean, b.mean), std::hypot(a.half, b.half)};
  const auto of_a = mean_value(quantity, a), of_b = mean_value(quantity, b);
  if (!of_a || !of_b) return std::nullopt;
  return Difference{std::abs(of_a->value - of_b->value), std::hypot(of_a->half, of_b->half)};
}

Convergence judge_convergence(const Difference& coarse, const Difference& fine,
                              std::string_view unit) {
  Convergence c;
  if (fine.value <= kRounding) {
    c.converges = true;
    c.uncertainty = kRounding;
    c.sentence = "three refinements give the same but for rounding";
    return c;
  }
  if (fine.value <= fine.half) {
    c.converges = true;
    c.uncertainty = fine.half;
    c.sentence = fmt::format(
        "the last two refinements differ by less than their scatter, {:.2g} {}", fine.half, unit);
    return c;
  }
  c.order = std::log2(coarse.value / fine.value);
  c.converges = fine.value < kLeastGain * coarse.value;
  c.uncertainty =
      c.converges ? fine.value / (std::exp2(c.order) - 1.0) : std::max(coarse.value, fine.value);
  c.sentence = c.converges
                   ? fmt::format(
                         "three refinements converge with order {:.2f}; the finest is off "
                         "by about {:.2g} {}",
                         c.order, c.uncertainty, unit)
                   : fmt::format(
                         "the reference does NOT converge: refinements differ by {:.2g} and "
                         "then by {:.2g} {}; smaller errors mean nothing",
                         coarse.value, fine.value, unit);
  return c;
}

Reference::Reference(fs::path out, const ComparePlan& plan, const Methods& methods)
    : out_(std::move(out)), methods_(methods), kind_(plan.reference) {
  for (const std::string& level : plan.levels) {
    auto end = read_cell_end(cell_folder(out_, level), level_runs(plan));
    if (!end) {
      const auto run = read_cell_run(cell_folder(out_, level), 0);
      fault_ = "no reference: its run did not come to an end" +
               (run && !run->why.empty() ? ", " + run->why : std::string());
      levels_.clear();
      return;
    }
    levels_.push_back(std::move(*end));
  }
}

Convergence Reference::convergence(const ErrorQuantity& quantity) const {
  if (kind_ == ReferenceKind::closed_form && is_position(quantity))
    return {true, 0.0, 0.0, "the closed form that the scene names"};
  if (!fault_.empty()) return {.sentence = fault_};
  if (levels_.empty()) return {.sentence = "nothing but the first cell to compare with"};
  const auto coarse = difference(quantity, levels_[0], levels_[1]);
  const auto fine = difference(quantity, levels_[1], levels_[2]);
  if (!coarse || !fine)
    return {.sentence = fmt::format("no reference: the scene has no {}", quantity.meaning)};
  return judge_convergence(*coarse, *fine, quantity.unit);
}

std::optional<Difference> Reference::error(const ErrorQuantity& quantity, const std::string& cell,
                                           const CellEnd& end) const {
  if (kind_ == ReferenceKind::closed_form && is_position(quantity))
    return Difference{closed_form_error(cell, end.mean), end.half};
  if (levels_.empty()) return std::nullopt;
  return difference(quantity, end, levels_.back());
}

double Reference::closed_form_error(const std::string& cell, const ClothEnds& ends) const {
  const Scene scene = read_scene(cell_folder(out_, cell) / "scene.json", {}, methods_);
  if (scene.closed_form == ClosedForm::incline) return incline_error(scene, ends);
  return free_fall_error(scene, build_scene(scene), ends);
}

}  // namespace selvedge::detail

namespace selvedge {

namespace fs = std::filesystem;

double ClothEnds::extent() const {
  Vec3 low = start.front(), high = low;
  for (const Vec3& x : start) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

std::optional<ClothEnds> read_ends(const fs::path& cell, int repeat) {
  const auto file = [&](int frame) {
    return numbered(cell / "frames", "cloth", frame, kFrameFileDigits, ".ply");
  };
  const int last = kEndFrame + repeat;
  if (!fs::exists(file(0)) || !fs::exists(file(last))) return std::nullopt;
  const TriangleMesh start = read_mesh(file(0)), end = read_mesh(file(last));
  if (start.vertices.empty() || start.vertices.size() != end.vertices.size()) return std::nullopt;
  return ClothEnds{start.vertices, end.vertices, start.triangles};
}

std::vector<std::string> error_names() {
  std::vector<std::string> names;
  for (const detail::ErrorQuantity& quantity : detail::error_quantities())
    names.emplace_back(quantity.name);
  return names;
}

}  // namespace selvedge
