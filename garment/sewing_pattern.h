// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace selvedge {

/// A point of a flat panel, m.
using Vec2 = Eigen::Vector2d;

/// The shape of an edge between its two vertices. Bezier curves have control points; an arc is part
/// of a circle, as in SVG paths; a polyline passes through points.
struct PatternCurve {
  enum class Kind { straight, quadratic, cubic, arc, polyline };
  Kind kind = Kind::straight;
  /// Control points in the plane of the panel, m: none, one or two of them count.
  std::array<Vec2, 2> control = {Vec2::Zero(), Vec2::Zero()};
  double radius = 0.0;          ///< m, of an arc, at least half the distance of the ends
  bool large_arc = false;       ///< the arc is longer than half a circle
  bool clockwise = false;       ///< the arc turns clockwise from its start to its end
  std::vector<Vec2> through{};  ///< m, points of a polyline between its ends
};

struct PatternEdge {
  std::array<std::int32_t, 2> endpoints = {0, 0};  ///< start and end, vertices of the panel
  PatternCurve curve;
  std::string label;  ///< such as lower_interface; empty: none
};

/// How a panel is bent around a cylinder before it is sewn. Lines along `axis` stay straight.
struct PatternBend {
  double radius = 0.0;  ///< m; the outer side of the cylinder is that of +z; 0: the panel is flat
  Vec2 at = Vec2::Zero();      ///< m, a point of the panel that keeps its place
  Vec2 axis = Vec2(0.0, 1.0);  ///< unit, in the plane of the panel
};

/// A flat piece of cloth. Its edges form one closed loop in order: each starts where the one before
/// it ends.
struct PatternPanel {
  std::string name;
  std::vector<Vec2> vertices;  ///< m
  std::vector<PatternEdge> edges;
  Vec3 translation = Vec3::Zero();   ///< m; the point p of the plane stands at rotation·(p, 0) +
  Mat3 rotation = Mat3::Identity();  ///< translation
  PatternBend bend;                  ///< before rotation and translation
  std::string label;                 ///< of the whole panel; empty: none
};

/// Two edges that are sewn together.
struct PatternStitch {
  struct Side {
    std::int32_t panel = 0, edge = 0;
  };
  /// Which ends meet: the end of one edge and the start of the other, or the two starts.
  enum class Direction { unknown, end_to_start, start_to_start };
  Side a, b;
  Direction direction = Direction::unknown;
};

/// A garment as flat panels, with their places about a body and the seams between them.
struct SewingPattern {
  std::string name;
  std::vector<PatternPanel> panels;
  std::vector<PatternStitch> stitches;
};

/// What a pattern must satisfy.
struct PatternLimits {
  /// Largest ratio of the lengths of two edges that are sewn together. The longer edge is gathered.
  double length_ratio = 3.0;
  /// Largest share of the area of a panel that another panel may cover in the same plane.
  double overlap = 0.5;
  double smallest = 1e-3;  ///< m, least width and height of a panel
  double largest = 50.0;  ///< m, greatest width and height of a panel, and distance from the origin
  /// Panels must have places, apart from each other and with seams that are not twisted. Otherwise
  /// a file may leave the places out.
  bool places = true;
};

/// Reads a pattern in the JSON format of GarmentCode and its predecessor Garment-Pattern-Generator
/// [KorostelevaLee2021] [KorostelevaSorkine2023]. Parameters and constraints are ignored.
/// Throws std::invalid_argument with file, panel, edge or stitch, fault and remedy, also where
/// check_sewing_pattern finds a fault.
SewingPattern read_sewing_pattern(const std::filesystem::path& file,
                                  const PatternLimits& limits = {});
/// The same for a text in memory; `name` stands for the file in messages and in the pattern.
SewingPattern parse_sewing_pattern(const std::string& json, const std::string& name,
                                   const PatternLimits& limits = {});

/// The same pattern as a text that parse_sewing_pattern reads: lengths in cm, curves absolute,
/// bends as "bend".
std::string sewing_pattern_text(const SewingPattern& pattern);

/// Throws std::invalid_argument for numbers that are not finite, a loop that is open or crosses
/// itself, a panel without area, size or stitch, an edge in two stitches, a stitch to a missing
/// edge, two sewn edges whose lengths differ too much, or two panels in one place. The message
/// begins with the name of the pattern.
void check_sewing_pattern(const SewingPattern& pattern, const PatternLimits& limits = {});

/// Point of an edge at the parameter t in [0, 1], m; t is the share of the length for a polyline.
Vec2 edge_point(const PatternPanel& panel, std::int32_t edge, double t);
/// Length of an edge along its curve, m.
double edge_length(const PatternPanel& panel, std::int32_t edge);
/// Angle by which an edge turns from its start to its end, rad, >= 0; that of an S adds up.
double edge_turning(const PatternPanel& panel, std::int32_t edge);
/// `pieces` + 1 points of an edge, equally far apart along the curve, both ends included, m.
std::vector<Vec2> divide_edge(const PatternPanel& panel, std::int32_t edge, std::int32_t pieces);

/// The parts into which an edge is divided at these shares of its length, ascending in (0, 1), and
/// the points between them, m.
struct EdgeParts {
  std::vector<PatternCurve> curves;
  std::vector<Vec2> points;
};
EdgeParts split_edge(const PatternPanel& panel, std::int32_t edge, std::span<const double> shares);

/// Where a point of the panel stands in space, m.
Vec3 place_point(const PatternPanel& panel, const Vec2& point);
/// Signed area of a panel, m²; negative if its loop runs clockwise.
double panel_area(const PatternPanel& panel);

/// Which way round the edges of a stitch are joined, and why.
struct SeamDirection {
  enum class Reason {
    file,         ///< the file says so
    shared_end,   ///< both edges have a vertex in common, as in a dart
    placement,    ///< the other way round the seam would be twisted in space
    orientation,  ///< other seams decide which sides of the panels face outward
    convention    ///< nothing decides: the end of one edge meets the start of the other
  };
  bool start_to_start = false;
  Reason reason = Reason::convention;
  /// The seam is twisted as the panels stand, although that is the direction.
  bool twisted = false;
};

/// Directions of all seams of a pattern that check_sewing_pattern accepts.
std::vector<SeamDirection> seam_directions(const SewingPattern& pattern);

}  // namespace selvedge
