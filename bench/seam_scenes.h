// SPDX-License-Identifier: MIT
//
// Surfaces that are one by their geometry and several by their vertices, beside the same surface
// with common vertices. Cloth slides over both.
#pragma once

#include <selvedge/scene/scene.h>
#include <selvedge/simulation/simulation.h>

#include <cstdint>
#include <string>
#include <vector>

namespace selvedge::bench {

/// A surface in parts and the same surface in one part.
struct Seam {
  std::string name;
  std::vector<TriangleMesh> parts, welded;
  Vec3 start = Vec3(-0.1, 0.0, 0.002);   ///< m, centre of the cloth
  Vec3 gravity = Vec3(0.0, 0.0, -9.81);  ///< m/s²
  int frames = 60;                       ///< at most
  bool is_cloth = false;                 ///< the parts are held cloth, not bodies
  bool is_quick = false;                 ///< its slides are short enough for a test
  bool is_obstacle = false;              ///< a step or gap that is real: only reported
};

/// How the cloth slides.
struct Slide {
  double speed = 1.0;     ///< m/s at the start, along x
  double friction = 0.0;  ///< Coulomb coefficient
  int frames = 60;        ///< of 1/60 s
  std::string response = "contact_force";
  Vec3 aside = Vec3::Zero();  ///< m, added to the start
};

/// Where the cloth ends.
struct SlideEnd {
  double distance = 0.0;     ///< m, of the mean of its particles
  double scatter = 0.0;      ///< m, half the range over several starts
  double max_stretch = 0.0;  ///< largest stretch of a spring in an accepted state
  std::string stopped;       ///< why the run ended early
};

/// The seams of the table. The seed draws how the parts lie and how far they are apart.
std::vector<Seam> seams(std::uint64_t seed);
/// Steps and gaps that cloth meets as obstacles.
std::vector<Seam> obstacles();

/// The scene in which the cloth slides over these bodies.
Scene slide_scene(const Seam& seam, const std::vector<TriangleMesh>& bodies, const Slide& slide);
SlideEnd slide_over(const Seam& seam, const std::vector<TriangleMesh>& bodies, const Slide& slide);
/// The same from several starts, which lie up to 3 mm aside: the mean distance, and half the range
/// of the distances. Where cloth slides over cloth with friction, or down a ball, one distance
/// depends on rounding.
SlideEnd mean_slide(const Seam& seam, const std::vector<TriangleMesh>& bodies, Slide slide,
                    int starts);

}  // namespace selvedge::bench
