// SPDX-License-Identifier: MIT
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/body_surface.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/girth.h>
#include <selvedge/dress/detail/worn_measures.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace selvedge::detail {
namespace {

constexpr double kFoldGap = 0.005;     // m, between layers of a fold
constexpr double kOpposite = -0.3;     // cosine of the normals of layers with opposite faces
constexpr double kAlong = 0.5;         // cosine between the way to the other layer and the body's
constexpr double kNearBody = 0.06;     // m, up to which cloth lies on the body
constexpr double kMirrored = 0.002;    // m, of edges of panels that are mirror images
constexpr double kMirrorPlace = 0.03;  // m, by which a panel may stand off the image of its partner

Vec3 normal_of(const TriangleMesh& mesh, std::size_t i) {
  const Triangle& t = mesh.triangles[i];
  return (mesh.vertices[t[1]] - mesh.vertices[t[0]])
      .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
      .normalized();
}

Vec3 middle_of(const TriangleMesh& mesh, std::size_t i) {
  const Triangle& t = mesh.triangles[i];
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
}

/// Girths of cloth and body around a triangle, along the direction in which it is stretched: across
/// the skin or, where the cloth is no ring there, as beside an armpit, tilted until it is one and
/// too short.
Girth tight_girth(const TriangleMesh& body, const DressResult& r, std::size_t at,
                  const Vec3& along) {
  const Vec3 across = normal_of(r.garment, at).cross(along).normalized();
  for (const double degrees : {0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vec3 normal =
        elementary::cos(angle) * across + elementary::sin(angle) * along.cross(across);
    const Girth girth = girth_at(r.garment, r.flat, body, at, normal);
    if (girth.cloth > 0.0 && girth.body > girth.cloth) return girth;
  }
  return {};
}

/// The most stretched place, with its measures.
void measure_tight(const TriangleMesh& body, DressResult& r) {
  double most = -1.0, all = 0.0, over = 0.0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const Deformation d = deformation(r.garment, r.flat, i);
    const double strain = d.largest_strain();
    all += d.area;
    if (strain > r.wearable_stretch) over += d.area;
    if (strain <= most) continue;
    most = strain;
    at = i;
  }
  if (most < 0.0) return;
  const Vec3 along = deformation(r.garment, r.flat, at).direction();
  const Girth girth = tight_girth(body, r, at, along);
  r.tight = {.panel = r.panel_of_triangle[at],
             .at = middle_of(r.garment, at),
             .strain = most,
             .area_share = over / all,
             .cloth = girth.cloth,
             .body = girth.body};
}

/// The corners of the panels, in the order of their edges: as they stand in the pattern and as they
/// are worn.
struct Corners {
  std::vector<Vec3> placed, worn;
  std::vector<double> edge;  // m, straight from the corner to the next one of its panel
  std::vector<std::int32_t> panel;
  std::size_t size() const { return placed.size(); }
};

Corners corners_of(const Garment& start, const Garment& worn, const DressResult& r) {
  std::vector<Vec3> moved(r.panel_names.size(), Vec3::Zero());
  for (const MovedPanel& m : r.moved) moved[static_cast<std::size_t>(m.panel)] += m.by;
  Corners corners;
  for (std::size_t b = 0; b < start.borders.size(); ++b) {
    const std::vector<std::int32_t>& from = start.borders[b].vertices;
    const std::int32_t now = worn.borders[b].vertices.front();
    const std::vector<Vec3>& x = start.surface.vertices;
    const Vec3& first = x[start.corner[from.front()]];
    corners.placed.push_back(first - moved[static_cast<std::size_t>(start.borders[b].panel)]);
    corners.edge.push_back((x[start.corner[from.back()]] - first).norm());
    corners.worn.push_back(worn.surface.vertices[worn.corner[now]]);
    corners.panel.push_back(start.borders[b].panel);
  }
  return corners;
}

Vec3 mirrored(const Vec3& x, double middle) { return {2.0 * middle - x.x(), x.y(), x.z()}; }

/// The corners of a panel: from `first`, `count` of them, in the order of its loop.
struct Loop {
  std::size_t first = 0, count = 0;
  std::size_t at(std::size_t k) const { return first + k % count; }
};

std::vector<Loop> loops_of(const Corners& corners) {
  std::vector<Loop> loops;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == 0 || corners.panel[i] != corners.panel[i - 1]) loops.push_back({i, 0});
    ++loops.back().count;
  }
  return loops;
}

/// How far a loop stands from the mirror image of another one in the plane x = middle, m, if corner
/// k of it is that of corner `shift` ± k; infinity unless their edges have the same lengths.
double off_image(const Corners& corners, const Loop& a, const Loop& b, std::size_t shift,
                 bool is_reversed, double middle) {
  double farthest = 0.0;
  for (std::size_t k = 0; k < a.count; ++k) {
    const std::size_t image = is_reversed ? shift + b.count - k : shift + k;
    const std::size_t edge = is_reversed ? image + b.count - 1 : image;
    if (std::abs(corners.edge[a.at(k)] - corners.edge[b.at(edge)]) > kMirrored)
      return std::numeric_limits<double>::infinity();
    farthest = std::max(
        farthest, (mirrored(corners.placed[a.at(k)], middle) - corners.placed[b.at(image)]).norm());
  }
  return farthest;
}

/// For each corner the one of the panel that is the mirror image of its own; empty without one for
/// each. Panels may stand a little off the image of their partners.
std::vector<std::size_t> partners(const Corners& corners, double middle) {
  const std::vector<Loop> loops = loops_of(corners);
  std::vector<std::size_t> partner(corners.size());
  for (const Loop& a : loops) {
    double least = kMirrorPlace;
    bool is_found = false;
    for (const Loop& b : loops)
      for (std::size_t shift = 0; b.count == a.count && shift < a.count; ++shift)
        for (const bool is_reversed : {true, false}) {
          const double off = off_image(corners, a, b, shift, is_reversed, middle);
          if (off > least) continue;
          least = off;
          is_found = true;
          for (std::size_t k = 0; k < a.count; ++k)
            partner[a.at(k)] = b.at(is_reversed ? shift + b.count - k : shift + k);
        }
    if (!is_found) return {};
  }
  return partner;
}

/// The middle plane of a pattern that is its own mirror image: the median over its corners, because
/// a single panel may stand off.
double middle_of(const Corners& corners, const std::vector<std::size_t>& partner) {
  std::vector<double> x;
  for (std::size_t i = 0; i < partner.size(); ++i)
    x.push_back(0.5 * (corners.placed[i].x() + corners.placed[partner[i]].x()));
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

/// The mean over the corners of a panel of how far each is from the mirror image of its partner;
/// the largest of all panels. -1 for a pattern that is not its own mirror image.
void measure_asymmetry(const Garment& start, const Garment& worn, std::optional<double> body_middle,
                       DressResult& r) {
  const Corners corners = corners_of(start, worn, r);
  if (corners.placed.empty()) return;
  double low = corners.placed[0].x(), high = low;
  for (const Vec3& x : corners.placed) {
    low = std::min(low, x.x());
    high = std::max(high, x.x());
  }
  const std::vector<std::size_t> partner = partners(corners, 0.5 * (low + high));
  if (partner.empty()) return;
  const double middle = body_middle ? *body_middle : middle_of(corners, partner);
  std::vector<double> sum(r.panel_names.size(), 0.0), count(r.panel_names.size(), 0.0);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto p = static_cast<std::size_t>(corners.panel[i]);
    sum[p] += (mirrored(corners.worn[i], middle) - corners.worn[partner[i]]).norm();
    count[p] += 1.0;
  }
  r.asymmetry = 0.0;
  for (std::size_t p = 0; p < sum.size(); ++p) {
    if (count[p] == 0.0 || sum[p] / count[p] <= r.asymmetry) continue;
    r.asymmetry = sum[p] / count[p];
    r.asymmetric_panel = static_cast<std::int32_t>(p);
  }
}

}  // namespace

std::vector<double> folded_areas(const TriangleMesh& garment,
                                 std::span<const std::int32_t> panel_of_triangle,
                                 const TriangleMesh& body, std::size_t panels) {
  const std::vector<Vec3> normals = vertex_normals(garment.vertices, garment.triangles);
  std::vector<std::vector<std::int32_t>> panels_at(garment.vertices.size());
  for (std::size_t i = 0; i < garment.triangles.size(); ++i)
    for (const std::int32_t v : garment.triangles[i]) panels_at[v].push_back(panel_of_triangle[i]);
  const BodySurface skin(body);
  std::vector<char> is_folded(garment.vertices.size(), 0);
  for (const Proximity& near : find_contacts(garment.vertices, garment.triangles, kFoldGap)) {
    if (near.kind == ContactKind::edge_edge) continue;
    const std::int32_t v = near.vertex[0];
    const auto t = static_cast<std::size_t>(near.primitive_b);
    const std::vector<std::int32_t>& own = panels_at[v];
    if (std::find(own.begin(), own.end(), panel_of_triangle[t]) == own.end()) continue;
    if (normals[v].dot(normal_of(garment, t)) > kOpposite) continue;
    const BodySurface::Nearest on_body = skin.nearest_within(garment.vertices[v], kNearBody);
    if (on_body.triangle < 0 || std::abs(near.normal.dot(skin.normal(on_body.triangle))) < kAlong)
      continue;
    is_folded[v] = 1;  // the vertices of the other layer have pairs of their own
  }
  std::vector<double> folded(panels, 0.0), area(panels, 0.0);
  for (std::size_t i = 0; i < garment.triangles.size(); ++i) {
    const Triangle& t = garment.triangles[i];
    const double third = 0.5 / 3.0 *
                         (garment.vertices[t[1]] - garment.vertices[t[0]])
                             .cross(garment.vertices[t[2]] - garment.vertices[t[0]])
                             .norm();
    const auto p = static_cast<std::size_t>(panel_of_triangle[i]);
    area[p] += 3.0 * third;
    for (const std::int32_t v : t)
      if (is_folded[v]) folded[p] += third;
  }
  for (std::size_t p = 0; p < panels; ++p) folded[p] = area[p] > 0.0 ? folded[p] / area[p] : 0.0;
  return folded;
}

Girth girth_at(const TriangleMesh& garment, const TriangleMesh& flat, const TriangleMesh& body,
               std::size_t triangle, const Vec3& normal) {
  const CutPlane plane(middle_of(garment, triangle), normal);
  const Section section = section_of(garment, plane);
  for (const Section::Part& part : section.parts) {
    if (std::none_of(part.segments.begin(), part.segments.end(),
                     [&](const Section::Segment& s) { return s.triangle == triangle; }))
      continue;
    if (!part.is_ring) return {};
    return {.cloth = length_in(flat, garment, part.segments),
            .worn = part.length,
            .body = tape_inside(section_of(body, plane), part.hull)};
  }
  return {};
}

void measure_worn(const Garment& start, const Garment& worn, std::optional<double> middle,
                  DressResult& r) {
  r.panel_folded = folded_areas(r.garment, r.panel_of_triangle, r.body, r.panel_names.size());
  std::vector<double> area(r.panel_names.size(), 0.0);
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i)
    area[static_cast<std::size_t>(r.panel_of_triangle[i])] +=
        deformation(r.garment, r.flat, i).area;
  const double all = std::accumulate(area.begin(), area.end(), 0.0);
  for (std::size_t p = 0; p < area.size(); ++p) r.folded += r.panel_folded[p] * area[p] / all;
  measure_tight(r.body, r);
  measure_asymmetry(start, worn, middle, r);
}

}  // namespace selvedge::detail
