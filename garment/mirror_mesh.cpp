// SPDX-License-Identifier: MIT
//
// Meshes that are mirror images. A garment on a symmetric body hangs to one side if the triangles
// of its left differ from those of its right, because they buckle elsewhere.
#include <selvedge/garment/detail/mirror_mesh.h>
#include <selvedge/garment/detail/panel_quality.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace selvedge::detail {
namespace {

constexpr double kSame = 0.02;   // of the edge length, by which a point may be off its image
constexpr double kAcross = 0.9;  // cosine between a mirror line's normal and where it should be
constexpr double kImagePlace = 0.05;  // m, by which a panel may stand off the image of another
constexpr double kNarrow = 0.6;       // edge lengths, of the mirror line within a narrow panel
constexpr double kLineGrowth = 0.35;  // of edges, per distance from the loop

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A line about which a loop of n points is its own mirror image: point i is that of shift - i.
struct MirrorLine {
  Vec2 at = Vec2::Zero(), normal = Vec2::Zero();
  std::int32_t shift = 0;

  Vec2 image(const Vec2& p) const { return p - 2.0 * (p - at).dot(normal) * normal; }
};

std::int32_t around(std::int32_t i, std::int32_t n) { return (i % n + n) % n; }

/// The line for which point i is the image of shift - i, as the points say on average.
MirrorLine line_for(std::span<const Vec2> loop, std::int32_t shift, const Vec2& across) {
  const auto n = static_cast<std::int32_t>(loop.size());
  MirrorLine line{.shift = shift};
  for (std::int32_t i = 0; i < n; ++i) {
    const Vec2 way = loop[i] - loop[around(shift - i, n)];
    line.normal += way.dot(across) < 0.0 ? Vec2(-way) : way;
    line.at += loop[i] / static_cast<double>(n);
  }
  if (!line.normal.isZero(0.0)) line.normal.normalize();
  return line;
}

std::optional<MirrorLine> mirror_line(std::span<const Vec2> loop, const Vec2& across,
                                      double tolerance) {
  const auto n = static_cast<std::int32_t>(loop.size());
  for (std::int32_t shift = 0; shift < n; ++shift) {
    // One pair tells most shifts apart.
    const double chord = (loop[0] - loop[1]).norm(),
                 image = (loop[around(shift, n)] - loop[around(shift - 1, n)]).norm();
    if (std::abs(chord - image) > 2.0 * tolerance) continue;
    const MirrorLine line = line_for(loop, shift, across);
    if (line.normal.dot(across) < kAcross) continue;
    bool is_image = true;
    for (std::int32_t i = 0; is_image && i < n; ++i)
      is_image = (line.image(loop[i]) - loop[around(shift - i, n)]).norm() <= tolerance;
    if (is_image) return line;
  }
  return std::nullopt;
}

/// One half of a symmetric loop, with the mirror line as its last sides.
class Half {
 public:
  Half(std::span<const Vec2> loop, const MirrorLine& line, double edge_length)
      : loop_(loop),
        line_(line),
        edge_length_(edge_length),
        n_(static_cast<std::int32_t>(loop.size())),
        first_((line.shift + 1) / 2),
        last_((line.shift + n_) / 2) {}

  /// False if the panel is too narrow along the line.
  bool build() {
    const Vec2 from = crossing(last_), to = crossing(around(line_.shift - first_, n_));
    const Vec2 along = (to - from).normalized();
    const Vec2 low = from + inward(last_) * along, high = to - inward(first_) * along;
    if (!((high - low).dot(along) > kNarrow * edge_length_)) return false;
    for (std::int32_t i = first_; i <= last_; ++i) points_.push_back(loop_[around(i, n_)]);
    on_loop_ = static_cast<std::int32_t>(points_.size());
    if (ends_in_a_side(last_)) points_.push_back(low);
    add_line(low, high, chord(last_), chord(first_));
    if (ends_in_a_side(first_)) points_.push_back(high);
    return true;
  }

  const std::vector<Vec2>& points() const { return points_; }

  /// The whole mesh of that of the half.
  MirrorMesh unfolded(const PolygonMesh& half) const {
    MirrorMesh whole;
    std::vector<Vec2>& x = whole.mesh.vertices;
    x.assign(loop_.begin(), loop_.end());
    for (std::int32_t i = 0; i < n_; ++i) whole.image.push_back(around(line_.shift - i, n_));
    std::vector<std::int32_t> here(half.vertices.size()), there(half.vertices.size());
    const auto sides = static_cast<std::int32_t>(points_.size());
    for (std::int32_t v = 0; v < static_cast<std::int32_t>(half.vertices.size()); ++v) {
      if (v < on_loop_) {
        here[v] = around(first_ + v, n_);
        there[v] = whole.image[here[v]];
        continue;
      }
      here[v] = there[v] = static_cast<std::int32_t>(x.size());
      x.push_back(half.vertices[v]);
      if (v >= sides) {  // beside the line
        ++there[v];
        x.push_back(line_.image(half.vertices[v]));
        whole.image.push_back(there[v]);
      }
      whole.image.push_back(here[v]);
    }
    for (const Triangle& t : half.triangles) {
      whole.mesh.triangles.push_back({here[t[0]], here[t[1]], here[t[2]]});
      whole.mesh.triangles.push_back({there[t[0]], there[t[2]], there[t[1]]});
    }
    // The triangles on the sides that the line crosses.
    for (const auto& [end, apex] : {std::pair(last_, on_loop_), {first_, sides - 1}})
      if (ends_in_a_side(end))
        whole.mesh.triangles.push_back(
            {around(end, n_), around(line_.shift - end, n_), here[static_cast<std::size_t>(apex)]});
    return whole;
  }

 private:
  /// Whether the line crosses a side of the loop at one end of the half, rather than a point.
  bool ends_in_a_side(std::int32_t end) const {
    return around(end, n_) != around(line_.shift - end, n_);
  }
  double chord(std::int32_t end) const {
    return ends_in_a_side(end)
               ? 2.0 * std::abs((loop_[around(end, n_)] - line_.at).dot(line_.normal))
               : (loop_[around(end + 1, n_)] - loop_[around(end, n_)]).norm();
  }
  /// Where the line crosses the loop.
  Vec2 crossing(std::int32_t end) const {
    return 0.5 * (loop_[around(end, n_)] + loop_[around(line_.shift - end, n_)]);
  }
  /// From the crossing to the top of the equilateral triangle on a crossed side, m.
  double inward(std::int32_t end) const {
    return ends_in_a_side(end) ? std::sqrt(0.75) * chord(end) : 0.0;
  }

  /// Points between both ends of the line, whose distances grow from those of the loop.
  void add_line(const Vec2& low, const Vec2& high, double at_low, double at_high) {
    const double length = (high - low).norm();
    std::vector<double> at = {0.0};
    while (at.back() < length) {
      const double step = std::min({edge_length_, at_low + kLineGrowth * at.back(),
                                    at_high + kLineGrowth * (length - at.back())});
      at.push_back(at.back() + std::max(step, 0.1 * edge_length_));
    }
    if (at.size() > 2 && at.back() - length > length - at[at.size() - 2]) at.pop_back();
    for (std::size_t i = 1; i + 1 < at.size(); ++i)
      points_.push_back(low + at[i] / at.back() * (high - low));
  }

  std::span<const Vec2> loop_;
  MirrorLine line_;
  double edge_length_;
  std::int32_t n_, first_, last_;  // points of the loop, the first and last one of the half
  std::int32_t on_loop_ = 0;       // points of the half that are points of the loop
  std::vector<Vec2> points_;
};

/// Counter-clockwise triangles that begin with their least vertex, in order; false if one has no
/// area or turns the other way.
bool put_in_order(PolygonMesh& mesh, std::span<const Vec2> loop) {
  for (Triangle& t : mesh.triangles) {
    const Vec2 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const double twice = cross(b - a, c - a);
    if (!(std::abs(twice) > 0.0)) return false;
    if (twice < 0.0) std::swap(t[1], t[2]);
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  }
  std::sort(mesh.triangles.begin(), mesh.triangles.end());
  mesh.quality = quality_of(loop, mesh.vertices, mesh.triangles);
  double twice = 0.0;
  for (std::size_t i = 0; i < loop.size(); ++i)
    twice += cross(loop[i], loop[(i + 1) % loop.size()]);
  // Triangles that overlap cover more than the loop encloses.
  return std::abs(mesh.quality.area - 0.5 * std::abs(twice)) <= 1e-6 * mesh.quality.area;
}

/// Point k of one loop is that of shift + k or shift - k of the other.
struct LoopImage {
  std::int32_t shift = 0;
  bool is_reversed = false;
  std::int32_t of(std::int32_t k, std::int32_t n) const {
    return around(is_reversed ? shift - k : shift + k, n);
  }
};

/// The loop of a panel, and how it is passed to be the image of another one.
struct PanelImage {
  std::int32_t panel = -1;
  LoopImage image;
};

/// The panel whose mirror image stands nearest to a loop.
PanelImage nearest_image(std::span<const Vec3> placed, std::span<const MeshedPanel> panels,
                         double middle) {
  const auto n = static_cast<std::int32_t>(placed.size());
  double least = kImagePlace;
  PanelImage best;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    if (panels[p].placed.size() != placed.size() || !panels[p].outline.lines.empty()) continue;
    for (std::int32_t shift = 0; shift < n; ++shift)
      for (const bool is_reversed : {true, false}) {
        const LoopImage image{shift, is_reversed};
        double farthest = 0.0;
        for (std::int32_t k = 0; farthest < least && k < n; ++k) {
          const Vec3& x = panels[p].placed[image.of(k, n)];
          farthest =
              std::max(farthest, (placed[k] - Vec3(2.0 * middle - x.x(), x.y(), x.z())).norm());
        }
        if (farthest >= least) continue;
        least = farthest;
        best = {static_cast<std::int32_t>(p), image};
      }
  }
  return best;
}

/// Moves points of the plane, and mirrors it or not.
struct Congruence {
  Vec2 from = Vec2::Zero(), to = Vec2::Zero(), turn = Vec2(1.0, 0.0);
  double sign = 1.0;  // of y before the turn

  Vec2 operator()(const Vec2& p) const {
    const Vec2 q(p.x() - from.x(), sign * (p.y() - from.y()));
    return to + Vec2(turn.x() * q.x() - turn.y() * q.y(), turn.y() * q.x() + turn.x() * q.y());
  }
};

/// The one that moves the points `b` to the points `a`, at best.
Congruence congruence(std::span<const Vec2> a, std::span<const Vec2> b, double sign) {
  Congruence c{.sign = sign};
  const auto n = static_cast<double>(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    c.to += a[k] / n;
    c.from += b[k] / n;
  }
  Vec2 sum = Vec2::Zero();
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Vec2 p = a[k] - c.to, q(b[k].x() - c.from.x(), sign * (b[k].y() - c.from.y()));
    sum += Vec2(q.dot(p), cross(q, p));
  }
  if (!sum.isZero(0.0)) c.turn = sum.normalized();
  return c;
}

/// The mesh of a panel, moved to an outline whose point k is point image.of(k) of the panel.
MirrorMesh moved_mesh(const PanelOutline& outline, const PolygonMesh& mesh, const LoopImage& image,
                      const Congruence& moved) {
  const auto n = static_cast<std::int32_t>(outline.sides);
  MirrorMesh made;
  made.mesh.vertices = outline.points;
  std::vector<std::int32_t> own(outline.sides);
  for (std::int32_t k = 0; k < n; ++k) {
    made.image.push_back(image.of(k, n));
    own[image.of(k, n)] = k;
  }
  for (std::size_t v = outline.sides; v < mesh.vertices.size(); ++v) {
    made.mesh.vertices.push_back(moved(mesh.vertices[v]));
    made.image.push_back(static_cast<std::int32_t>(v));
  }
  for (Triangle t : mesh.triangles) {
    for (std::int32_t& v : t)
      if (v < n) v = own[v];
    made.mesh.triangles.push_back(t);
  }
  return made;
}

}  // namespace

std::optional<MirrorMesh> mesh_of_halves(const PanelOutline& outline, const Vec2& across,
                                         const PanelMeshConfig& config) {
  if (!outline.lines.empty() || across.norm() < kAcross) return std::nullopt;
  const std::optional<MirrorLine> line =
      mirror_line(outline.loop(), across.normalized(), kSame * config.edge_length);
  if (!line) return std::nullopt;
  Half half(outline.loop(), *line, config.edge_length);
  if (!half.build()) return std::nullopt;
  try {
    MirrorMesh made = half.unfolded(mesh_polygon(half.points(), config));
    if (!put_in_order(made.mesh, outline.loop())) return std::nullopt;
    return made;
  } catch (const std::invalid_argument&) {  // a half whose line meets its loop
    return std::nullopt;
  }
}

std::optional<MirrorMesh> mesh_of_image(const PanelOutline& outline, std::span<const Vec3> placed,
                                        std::span<const MeshedPanel> panels, double middle,
                                        const PanelMeshConfig& config) {
  if (!outline.lines.empty()) return std::nullopt;
  const auto n = static_cast<std::int32_t>(outline.sides);
  const PanelImage nearest = nearest_image(placed, panels, middle);
  if (nearest.panel < 0) return std::nullopt;
  const MeshedPanel& panel = panels[static_cast<std::size_t>(nearest.panel)];
  std::vector<Vec2> points;  // of its loop
  for (std::int32_t k = 0; k < n; ++k)
    points.push_back(panel.outline.points[nearest.image.of(k, n)]);
  for (const double sign : {-1.0, 1.0}) {
    const Congruence moved = congruence(outline.loop(), points, sign);
    bool is_same = true;
    for (std::int32_t k = 0; is_same && k < n; ++k)
      is_same = (moved(points[k]) - outline.points[k]).norm() <= kSame * config.edge_length;
    if (!is_same) continue;
    MirrorMesh made = moved_mesh(outline, panel.mesh, nearest.image, moved);
    made.panel = nearest.panel;
    if (put_in_order(made.mesh, outline.loop())) return made;
  }
  return std::nullopt;
}

}  // namespace selvedge::detail
