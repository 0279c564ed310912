// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/narrowphase/narrow_phase.h>

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// Adversarial queries for the exact narrow phase, with verdicts of the judge. In each family some
// queries barely touch and others barely miss. The families cover the ends of the step and of the
// primitives, roots of high multiplicity, degenerate shapes and motions, times that are exactly or
// almost doubles, and any scale and position.
namespace selvedge::ccd_queries {

using Random = std::mt19937_64;

int integer(Random& r, int lo, int hi);
double real(Random& r, double lo, double hi);

/// Integer coordinates in [-size, size].
Query grid(Random& r, ContactKind kind, int size);
/// Real coordinates in [-size, size).
Query uniform(Random& r, ContactKind kind, double size);
/// Moves one to three coordinates to a neighbouring double.
void nudge(Random& r, Query& q);

struct Family {
  std::string_view name;
  Query (*make)(Random& r, ContactKind kind);
};

/// All families. The first kBasicFamilies consist of small integers except for some roundings. The
/// first kIntegerFamilies of these consist of integers only, unless nudged.
std::span<const Family> families();
inline constexpr int kIntegerFamilies = 9, kBasicFamilies = 16;
inline constexpr int kNudgedFamily = 5;  ///< the nudged one among the integer families

inline ContactKind kind_of_index(std::size_t i) {
  return i % 2 == 0 ? ContactKind::point_triangle : ContactKind::edge_edge;
}

/// A unit triangle at rest, and a point that falls onto its interior from one height to another.
Query falling_point(double from, double to);

struct Truth {
  bool touches = false;
  double toi_lo = kNoCollision, toi_hi = kNoCollision;
};

/// Verdict of the judge, which shares no code with the narrow phase, and enclosure of the first
/// time of contact.
Truth truth_of(const Query& q);

/// Stores the queries as two surfaces, every third point-triangle query with the roles of the
/// surfaces exchanged, and their pairs in order.
struct Scene {
  struct Surface {
    std::vector<Vec3> x_t0, x_t1;
    std::vector<Edge> edges;
    std::vector<Triangle> triangles;
    SurfaceView view() const { return {x_t0, x_t1, edges, triangles, 0.0, 0}; }
  };
  Surface a, b;
  CandidatePairs pairs;
  /// Query index of each pair in the three lists.
  std::vector<std::size_t> point_triangle, triangle_point, edge_edge;
};
Scene scene_of(std::span<const Query> queries);

/// Kind and hexadecimal coordinates, one vertex per line, to read or to paste into a test.
std::string hex_text(const Query& q);
/// The eight lines of the query file: numerator and denominator of each coordinate, and the
/// verdict.
std::string file_rows(const Query& q, bool touches);

}  // namespace selvedge::ccd_queries
