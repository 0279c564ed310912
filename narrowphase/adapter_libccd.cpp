// SPDX-License-Identifier: MIT
// E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex
// objects in three-dimensional space", 1988 [Gilbert1988]; G. Snethen, "XenoCollide: Complex
// collision made simple", 2008 [Snethen2008]; both as implemented in libccd.
#include <selvedge/narrowphase/adapters.h>
#include <selvedge/narrowphase/detail/contact_geometry.h>
#include <selvedge/narrowphase/detail/method_config.h>
#include <selvedge/narrowphase/detail/per_query.h>
#include <selvedge/narrowphase/detail/unit_size.h>

#include <ccd/ccd.h>

#include <algorithm>
#include <limits>

namespace selvedge {
namespace {

using detail::UnitSizePaths;

/// At a thousandth of a primitive's size, few pairs are false alarms, and a step as long as the
/// primitive needs ten halvings.
constexpr double kDefaultTolerance = 0x1p-10;
/// The library tests hulls that are at most this many times longer than the primitives. On longer
/// hulls the primitives would be too small for the library's absolute tolerances.
constexpr double kLongestHull = 16.0;
/// Maximum number of intervals per query; a query that exceeds it counts as a collision: a false
/// alarm rather than a miss. Only a query that grazes along its whole path needs more.
constexpr int kMostIntervals = 4096;
/// A search normally ends after a few dozen iterations; one that does not is cycling, and its hulls
/// count as overlapping.
constexpr unsigned long kMostIterations = 200;
/// Portals are refined to this fraction of the primitives' size, well below the thickness of the
/// hulls at the default tolerance.
constexpr double kPortalTolerance = 1e-8;

/// The hull that the vertices of one primitive sweep: at most three vertices at two times.
struct Hull {
  std::array<Vec3, 6> points;
  int count = 0;
  mutable unsigned long asked = 0;  ///< number of support points requested
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* out) {
  const Hull& hull = *static_cast<const Hull*>(object);
  // The portal search has no iteration limit of its own; its loops end when they see a NaN.
  if (++hull.asked > kMostIterations) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    ccdVec3Set(out, nan, nan, nan);
    return;
  }
  const Vec3 along(direction->v[0], direction->v[1], direction->v[2]);
  int best = 0;
  double most = hull.points[0].dot(along);
  for (int i = 1; i < hull.count; ++i)
    if (const double value = hull.points[i].dot(along); value > most) {
      most = value;
      best = i;
    }
  const Vec3& p = hull.points[best];
  ccdVec3Set(out, p.x(), p.y(), p.z());
}

void center(const void* object, ccd_vec3_t* out) {
  const Hull& hull = *static_cast<const Hull*>(object);
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < hull.count; ++i) sum += hull.points[i];
  sum /= hull.count;
  ccdVec3Set(out, sum.x(), sum.y(), sum.z());
}

Hull swept_hull(const UnitSizePaths& paths, int begin, int end, double from, double to) {
  Hull hull;
  for (const double t : {from, to})
    for (int k = begin; k < end; ++k)
      hull.points[hull.count++] = (1.0 - t) * paths.y_t0[k] + t * paths.y_t1[k];
  return hull;
}

bool boxes_overlap(const Hull& a, const Hull& b) {
  const auto corner = [](const Hull& h, auto pick) {
    Vec3 x = h.points[0];
    for (int i = 1; i < h.count; ++i) x = pick(x, h.points[i]);
    return x;
  };
  const auto low = [](const Vec3& x, const Vec3& y) -> Vec3 { return x.cwiseMin(y); };
  const auto high = [](const Vec3& x, const Vec3& y) -> Vec3 { return x.cwiseMax(y); };
  return (corner(a, low).array() <= corner(b, high).array()).all() &&
         (corner(b, low).array() <= corner(a, high).array()).all();
}

enum class Search { gjk, mpr };

class LibccdRule {
 public:
  LibccdRule(Search search, double tolerance) : search_(search), tolerance_(tolerance) {
    CCD_INIT(&ccd_);
    ccd_.support1 = ccd_.support2 = support;
    ccd_.center1 = ccd_.center2 = center;
    ccd_.max_iterations = 2 * kMostIterations;  // The hulls end the search earlier.
    ccd_.mpr_tolerance = kPortalTolerance;
  }

  double time(const Query& query) const {
    const UnitSizePaths paths = detail::to_unit_size(query);
    const int first = detail::first_count(query.kind);
    int intervals = 0;
    return first_overlap(paths, first, 0.0, 1.0, intervals);
  }

  NarrowPhaseTraits traits() const {
    return {.source = search_ == Search::gjk
                          ? "swept hulls by libccd (D. Fiser); E. Gilbert, D. Johnson, S. Keerthi, "
                            "A fast procedure for computing the distance between complex objects "
                            "in three-dimensional space, 1988"
                          : "swept hulls by libccd (D. Fiser); G. Snethen, XenoCollide: Complex "
                            "collision made simple, 2008",
            .limits =
                "pairs that come nearer than about the tolerance (a part of their size) are false "
                "alarms; touching and degenerate primitives may be missed"};
  }

 private:
  /// The start of the first interval that is short enough and whose hulls overlap.
  double first_overlap(const UnitSizePaths& paths, int first, double from, double to,
                       int& intervals) const {
    if (++intervals > kMostIntervals) return from;
    const Hull a = swept_hull(paths, 0, first, from, to);
    const Hull b = swept_hull(paths, first, 4, from, to);
    if (!boxes_overlap(a, b)) return kNoCollision;
    const double motion = (to - from) * paths.motion, middle = 0.5 * (from + to);
    if (motion <= kLongestHull && !overlap(a, b)) return kNoCollision;
    if (motion <= tolerance_ || middle == from || middle == to) return from;
    const double earlier = first_overlap(paths, first, from, middle, intervals);
    return earlier != kNoCollision ? earlier : first_overlap(paths, first, middle, to, intervals);
  }

  bool overlap(const Hull& a, const Hull& b) const {
    const int found =
        search_ == Search::gjk ? ccdGJKIntersect(&a, &b, &ccd_) : ccdMPRIntersect(&a, &b, &ccd_);
    return found != 0 || a.asked > kMostIterations;
  }

  Search search_;
  double tolerance_;
  ccd_t ccd_;
};

void add(NarrowPhaseRegistry& registry, const char* name, Search search) {
  const MethodOption tolerance = detail::tolerance_option(
      kDefaultTolerance, "1",
      "fraction of the primitives' size that an interval's motion may have; smaller: fewer false "
      "alarms, more intervals");
  registry.add(name, {tolerance}, [search](const MethodOptions& o) {
    return detail::per_query(LibccdRule(search, o["tolerance"]));
  });
}

}  // namespace

void register_libccd(NarrowPhaseRegistry& registry) {
  add(registry, "libccd_gjk", Search::gjk);
  add(registry, "libccd_mpr", Search::mpr);
}

}  // namespace selvedge
