// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/types.h>

#include <filesystem>
#include <optional>
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

/// An elastic along an edge or a line. It is stretched while the seams close.
struct PatternElastic {
  double ratio = 0.0;       ///< its rest length over that of the cloth, in (0, 1]; 0: there is none
  double stiffness = 20.0;  ///< N, force per strain, > 0
};

struct PatternEdge {
  std::array<std::int32_t, 2> endpoints = {0, 0};  ///< start and end, vertices of the panel
  PatternCurve curve;
  std::string label;  ///< such as lower_interface; empty: none
  PatternElastic elastic{};
};

/// A straight line across a panel, from vertex to vertex, along which it is folded, gathered by an
/// elastic, or sewn to another panel. Its ends lie on the loop or inside.
struct PatternLine {
  std::array<std::int32_t, 2> endpoints = {0, 0};  ///< start and end, vertices of the panel
  /// rad, in (-π, π): by which the cloth is folded at rest; > 0 where its inner sides come together
  std::optional<double> angle{};
  double stiffness = 0.05;  ///< N, moment of the fold per length and angle, > 0
  PatternElastic elastic{};
};

/// How a panel is bent around a cylinder before it is sewn. Lines along `axis` stay straight.
struct PatternBend {
  double radius = 0.0;  ///< m; the outer side of the cylinder is that of +z; 0: the panel is flat
  Vec2 at = Vec2::Zero();      ///< m, a point of the panel that keeps its place
  Vec2 axis = Vec2(0.0, 1.0);  ///< unit, in the plane of the panel
};

/// A flat piece of cloth. Its edges form one closed loop in order: each starts where the one before
/// it ends. Its lines are numbered after its edges.
struct PatternPanel {
  std::string name;
  std::vector<Vec2> vertices;  ///< m
  std::vector<PatternEdge> edges;
  Vec3 translation = Vec3::Zero();   ///< m; the point p of the plane stands at rotation·(p, 0) +
  Mat3 rotation = Mat3::Identity();  ///< translation
  PatternBend bend;                  ///< before rotation and translation
  std::string label;                 ///< of the whole panel; empty: none
  std::vector<PatternLine> lines{};
  std::string fabric{};  ///< name of its own fabric; empty: that of the garment

  bool is_line(std::int32_t edge) const { return edge >= static_cast<std::int32_t>(edges.size()); }
  /// Start and end of an edge or a line.
  const std::array<std::int32_t, 2>& endpoints(std::int32_t edge) const {
    const auto e = static_cast<std::size_t>(edge);
    return is_line(edge) ? lines[e - edges.size()].endpoints : edges[e].endpoints;
  }
};

/// Two edges that are sewn together, or an edge and a line of another panel.
struct PatternStitch {
  struct Side {
    std::int32_t panel = 0, edge = 0;  ///< numbers past the edges name the lines of the panel
  };
  /// Which ends meet: the end of one edge and the start of the other, or the two starts.
  enum class Direction { unknown, end_to_start, start_to_start };
  /// A zip and buttons stay open until all seams are closed.
  enum class Closure { seam, zip, buttons };
  Side a, b;
  Direction direction = Direction::unknown;
  Closure closure = Closure::seam;
  std::vector<double> buttons{};  ///< where they are, shares of the length of side a, in [0, 1]
};

/// A garment as flat panels, with their places about a body and the seams between them.
struct SewingPattern {
  std::string name;
  std::vector<PatternPanel> panels;
  std::vector<PatternStitch> stitches;

  /// Whether a stitch joins an edge to a line, such as the border of a pocket to a front.
  bool is_on_a_line(const PatternStitch& stitch) const {
    return panels[static_cast<std::size_t>(stitch.a.panel)].is_line(stitch.a.edge) ||
           panels[static_cast<std::size_t>(stitch.b.panel)].is_line(stitch.b.edge);
  }
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
/// bends as "bend", angles in degrees.
std::string sewing_pattern_text(const SewingPattern& pattern);

/// Throws std::invalid_argument for numbers that are not finite, a loop that is open or crosses
/// itself, a panel without area, size or stitch, an edge in two stitches, a stitch to a missing
/// edge, two sewn edges whose lengths differ too much, lines that cross or leave the panel, or two
/// panels in one place. The message
/// begins with the name of the pattern.
void check_sewing_pattern(const SewingPattern& pattern, const PatternLimits& limits = {});

// Edges may be lines in what follows, but for split_edge.

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
    placement,    ///< the other way round the seam would be twisted in space, or it is on a line
    orientation,  ///< other seams or the places decide which sides of the panels face outward
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
