// SPDX-License-Identifier: MIT
#include <selvedge/response/detail/reference_motion.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <limits>

namespace selvedge::detail {
namespace {

// Moments of inertia below this share of the largest indicate collinear points, whose spin about
// their line is undetermined.
constexpr double kInertiaCut = 1e-10;

// Share of their extent by which anchors may lie beside a line and still count as on it: their spin
// about it is undetermined.
constexpr double kOnLine = 1e-6;

// Maximum number of particles that a message lists.
constexpr std::size_t kNamed = 4;

Mat3 cross_matrix(const Vec3& w) {
  Mat3 m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}

// The rotation of least angle that takes the direction of a to that of b, which is not opposite.
Mat3 least_rotation(const Vec3& a, const Vec3& b) {
  const Vec3 from = a.stableNormalized(), to = b.stableNormalized();
  const Mat3 cross = cross_matrix(from.cross(to));
  return Mat3::Identity() + cross + cross * cross / (1.0 + from.dot(to));
}

// The direction of the line on which the points lie, as long as the farthest is from the centre;
// zero if they lie on none.
Vec3 line_of(std::span<const std::int32_t> points, std::span<const Vec3> x, const Vec3& centre) {
  Vec3 line = Vec3::Zero();
  for (const std::int32_t i : points)
    if (const Vec3 r = x[i] - centre; r.norm() > line.norm()) line = r;
  const Vec3 unit = line.stableNormalized();
  for (const std::int32_t i : points) {
    const Vec3 r = x[i] - centre;
    if ((r - unit.dot(r) * unit).norm() > kOnLine * line.norm()) return Vec3::Zero();
  }
  return line;
}

std::string anchor_name(std::int32_t i, std::size_t particles) {
  const auto n = static_cast<std::int32_t>(particles);
  return i < n ? "held particle " + std::to_string(i) : "body vertex " + std::to_string(i - n);
}

}  // namespace

ReferenceMotion momentum_motion(std::span<const std::int32_t> particles,
                                std::span<const double> mass, std::span<const Vec3> x_t0,
                                std::span<const Vec3> x_t1) {
  double total = 0.0;
  ReferenceMotion motion;
  for (const std::int32_t i : particles) {
    total += mass[i];
    motion.centre += mass[i] * x_t0[i];
    motion.shift += mass[i] * (x_t1[i] - x_t0[i]);
  }
  motion.centre /= total;
  motion.shift /= total;
  Mat3 inertia = Mat3::Zero();
  Vec3 momentum = Vec3::Zero();
  for (const std::int32_t i : particles) {
    const Vec3 r = x_t0[i] - motion.centre;
    inertia += mass[i] * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
    momentum += mass[i] * r.cross(x_t1[i] - x_t0[i] - motion.shift);
  }
  motion.turn = cross_matrix(pseudo_inverse(inertia, kInertiaCut) * momentum);
  return motion;
}

ReferenceMotion anchor_motion(std::span<const std::int32_t> anchors, std::span<const Vec3> x_t0,
                              std::span<const Vec3> x_t1) {
  ReferenceMotion motion;
  motion.shift = x_t1[anchors[0]] - x_t0[anchors[0]];
  motion.centre = x_t0[anchors[0]];
  if (std::all_of(anchors.begin(), anchors.end(),
                  [&](auto i) { return Vec3(x_t1[i] - x_t0[i]) == motion.shift; }))
    return motion;
  motion.centre = Vec3::Zero();
  Vec3 end = Vec3::Zero();
  for (const std::int32_t i : anchors) {
    motion.centre += x_t0[i];
    end += x_t1[i];
  }
  motion.centre /= static_cast<double>(anchors.size());
  end /= static_cast<double>(anchors.size());
  motion.shift = end - motion.centre;
  Mat3 covariance = Mat3::Zero();
  for (const std::int32_t i : anchors)
    covariance += (x_t1[i] - end) * (x_t0[i] - motion.centre).transpose();
  // Cloth beside anchors on a line must not spin about it, as the best fit may.
  const Vec3 line = line_of(anchors, x_t0, motion.centre), end_line = covariance * line;
  const bool is_line = !line.isZero(0.0) && end_line.dot(line) > 0.0;
  motion.turn =
      (is_line ? least_rotation(line, end_line) : nearest_rotation(covariance)) - Mat3::Identity();
  double error = 0.0, extent = 0.0;
  for (const std::int32_t i : anchors) {
    error = std::max(error, (x_t0[i] + motion.displacement(x_t0[i]) - x_t1[i]).norm());
    extent = std::max(extent, (x_t0[i] - motion.centre).norm());
  }
  motion.residual = error / extent;
  return motion;
}

Vec3 shared_shift(std::span<const ContactPoint> hits, const ResponseStep& step,
                  std::span<const Vec3> x_t1) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const ContactPoint& c : hits)
    for (const std::int32_t i : c.vertex) {
      if (step.motion.inv_mass[i] > 0.0) continue;
      const Vec3 move = x_t1[i] - step.motion.x_t0[i];
      low = low.cwiseMin(move);
      high = high.cwiseMax(move);
    }
  if (low.x() <= high.x()) return low == high ? low : Vec3(0.5 * (low + high));
  Vec3 sum = Vec3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < step.motion.particles; ++i) {
    sum += step.mass[i] * (x_t1[i] - step.motion.x_t0[i]);
    total += step.mass[i];
  }
  return sum / total;
}

std::string jam_sentence(const ContactGroup& group, const ContactMotion& motion,
                         std::span<const Vec3> x_t1) {
  std::int32_t a = group.anchors[0], b = a;
  const auto move = [&](std::int32_t i) { return Vec3(x_t1[i] - motion.x_t0[i]); };
  // The anchor farthest from the first, then the one farthest from that: at least half of the
  // largest difference.
  for (const auto pass : {0, 1}) {
    static_cast<void>(pass);
    std::int32_t far = b;
    for (const std::int32_t i : group.anchors)
      if ((move(i) - move(a)).norm() > (move(far) - move(a)).norm()) far = i;
    b = a;
    a = far;
  }
  const std::size_t count = group.particles.size();
  std::string text =
      "jammed: " + std::to_string(count) + (count == 1 ? " particle (" : " particles (");
  for (std::size_t k = 0; k < std::min(kNamed, group.particles.size()); ++k)
    text += (k ? ", " : "") + std::to_string(group.particles[k]);
  if (group.particles.size() > kNamed) text += ", ...";
  char length[32];
  std::snprintf(length, sizeof(length), "%.3g", (move(a) - move(b)).norm());
  return text + ") between " + anchor_name(std::min(a, b), motion.particles) + " and " +
         anchor_name(std::max(a, b), motion.particles) + ", whose motions differ by " + length +
         " m in this step";
}

}  // namespace selvedge::detail
