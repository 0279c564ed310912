// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/patterns/make_cloth.h>

#include <cstdint>

namespace selvedge {

/// A yarn as an elastic rod of round section.
struct YarnConfig {
  double tex = 20.0;            ///< g/km, > 0
  double density = 909.0;       ///< kg/m³ with the air inside, > 0; 1/1.1 g/cm³ [Peirce1937]
  double modulus = 3.6e9;       ///< Pa, Young's modulus of the section with its air, > 0
  double bending_share = 0.05;  ///< bending rigidity relative to a solid rod, in (0, 1]

  double diameter() const;  ///< m
  double stretch() const;   ///< N, EA
  double bending() const;   ///< N·m², EI
};

/// A weave and its yarns. Warp j floats over the weft yarns i with (i + step·j) mod (over + under)
/// < over: plain 1, 1, 1; twill 2/1 2, 1, 1; satin of 5 4, 1, 2.
struct WeaveConfig {
  std::int32_t over = 1, under = 1;  ///< >= 1
  std::int32_t step = 1;             ///< >= 1, without a common divisor with over + under
  YarnConfig warp, weft;
  double crimp_share = 0.5;  ///< share of the warp in the sum of both crimp heights, in (0, 1)
  double contact = 5000.0;   ///< N/m, stiffness of a crossing against compression, > 0
  double rotation = 5e-6;    ///< N·m per rad, moment that turns one yarn on another, >= 0
  std::int32_t links = 2;    ///< of a yarn between two crossings, even, >= 2

  bool warp_over(std::int32_t i, std::int32_t j) const;
  double warp_crimp() const;  ///< m, height between crest and trough [Peirce1937]
  double weft_crimp() const;  ///< m; both crimps add up to the sum of the diameters
};

/// The particles of a woven swatch. Yarns go on by half a cell beyond their last crossings.
struct WeaveLayout {
  std::int32_t wefts, warps, links;

  WeaveLayout(const GridConfig& grid, const WeaveConfig& weave)
      : wefts(grid.cells_x + 1), warps(grid.cells_y + 1), links(weave.links) {}
  /// Particle of the surface between warp j and weft i.
  std::int32_t middle(std::int32_t i, std::int32_t j) const { return j * wefts + i; }
  /// Particle k of a yarn; particle links/2 + links·i of warp j lies on weft i.
  std::int32_t warp(std::int32_t j, std::int32_t k) const {
    return wefts * warps + j * on_warp() + k;
  }
  std::int32_t weft(std::int32_t i, std::int32_t k) const {
    return wefts * warps + warps * on_warp() + i * on_weft() + k;
  }
  std::int32_t at(std::int32_t crossing) const { return links / 2 + links * crossing; }
  std::int32_t on_warp() const { return links * wefts + 1; }  ///< particles of a warp yarn
  std::int32_t on_weft() const { return links * warps + 1; }
};
/// Particles along the yarns of a weave [Kawabata1973; survey 7.1.3], with a crossing at each
/// vertex of `grid`; warp along x. The surface lies between warp and weft, and its vertices come
/// first, row by row as in make_rectangular; the particles of the yarns belong to no triangle. Of
/// `material` only damping and strain limit are taken. Throws std::invalid_argument also if the
/// yarns are too thick for the cells.
ClothMesh make_weave(const GridConfig& grid, const WeaveConfig& weave, const Material& material);

/// How the loops of a weft knit stand beside each other.
enum class KnitStructure : std::uint8_t {
  jersey,    ///< all to the front
  rib,       ///< some wales to the front, as many to the back
  interlock  ///< two 1 x 1 ribs, each in the gaps of the other
};

/// A weft knit and its yarn.
struct KnitConfig {
  YarnConfig yarn;
  double contact = 5000.0;  ///< N/m, stiffness of an interlock against compression, > 0
  double sliding = 500.0;   ///< N/m, the same against sliding of one yarn on the other, > 0
  double rotation = 1e-5;   ///< N·m per rad, moment that turns one yarn on the other, >= 0
  /// Rigidity against twist over that against bending, > 0. A solid rod has 0.8; fibres that slide
  /// lower the bending more.
  double twist = 5.0;
  std::int32_t links = 2;  ///< of a leg between two interlocks, even, >= 2
  KnitStructure structure = KnitStructure::jersey;
  std::int32_t wales = 1;  ///< of a rib: in a row on each side, >= 1; 2: a 2 x 2 rib
};

/// The loop of a plain knit, in plan [Peirce1947]: two arcs of three eighths of the wale spacing
/// about the centre of the head and that of the sinker, which lie half of the course spacing above
/// and below the middle of the loop, and straight legs between them. Lengths along the yarn count
/// from the top of the head, in plan. With the spacings 4 d and 2√3 d of a yarn of diameter d, all
/// yarns touch, and the loop has the length 16.66 d.
struct KnitLoop {
  double wale = 0.0, course = 0.0;  ///< m, spacings across and along the wales
  double radius = 0.0;              ///< m, of the arcs
  double arc = 0.0;                 ///< rad, from the top of the head to the leg
  double leg = 0.0;                 ///< m, straight part of a leg
  /// m, crossings of the head and of the leg with the loop of the next course.
  double head_crossing = 0.0, leg_crossing = 0.0;
  double height = 0.0;  ///< m, from the heads at the back to the legs at the front

  /// Throws std::invalid_argument if a yarn of this diameter (m) does not fit.
  KnitLoop(double wale, double course, double diameter);
  double length() const { return 4.0 * radius * arc + 2.0 * leg; }  ///< m, of a whole loop
  /// Place on the half of the loop from the head down to the right, m from the middle of the loop;
  /// `along` in [0, length()/2]. The legs have z = 0 at the front, heads and sinkers z = -height.
  Vec3 place(double along) const;
};

/// The particles of a knitted swatch: course by course, from the lowest up, and along each from
/// left to right.
struct KnitLayout {
  std::int32_t wales, courses, links;
  /// Yarns of a course: 2 of an interlock, the second half a course above the first.
  std::int32_t yarns;

  KnitLayout(const GridConfig& grid, const KnitConfig& knit)
      : wales(grid.cells_x + 1),
        courses(grid.cells_y + 1),
        links(knit.links),
        yarns(knit.structure == KnitStructure::interlock ? 2 : 1) {}
  std::int32_t rows() const { return courses * yarns; }  ///< of loops, from the lowest up
  /// Particle of the surface in the middle of a loop.
  std::int32_t middle(std::int32_t wale, std::int32_t course) const {
    return course * wales + wale;
  }
  /// Particle k of a loop of a row: 0 and on_loop() lie at the bottoms of its sinkers, on_loop()/2
  /// on top of its head. The row of the first yarn of a course is course * yarns.
  std::int32_t on(std::int32_t wale, std::int32_t row, std::int32_t k) const {
    return wales * courses + row * on_course() + wale * on_loop() + k;
  }
  std::int32_t on_loop() const { return 8 * links; }  ///< links of a loop
  std::int32_t on_course() const { return on_loop() * wales + 1; }
};
/// Particles along the loops of a weft knit [Peirce1947; survey 7.1.3], with a loop of each yarn at
/// each vertex of `grid`; courses along x. The surface lies on the legs of the first yarn, at the
/// front of wales to the front and at the back of the others; its vertices come first, row by row
/// as in make_rectangular, and the particles of the yarn belong to no triangle. The yarn is set, so
/// the swatch is at rest. Of `material` only damping and strain limit are taken. Throws
/// std::invalid_argument also if the yarn is too thick for the loops.
ClothMesh make_knit(const GridConfig& grid, const KnitConfig& knit, const Material& material);

}  // namespace selvedge
