// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/scene.h>

#include <string>

namespace selvedge {

/// What changes the mesh of a scene between frames: `cloth "skirt": "refine"`, or `seam "side":
/// "merge"`; "" if nothing does.
std::string mesh_change(const Scene& scene);
/// The scene without "refine" and "merge": a Simulation of it keeps the mesh that it is given.
Scene with_fixed_mesh(Scene scene);

}  // namespace selvedge
