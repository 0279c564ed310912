// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/broadphase/detail/box_library.h>

#include <memory>

namespace selvedge::detail {

/// CGAL's AABB tree as a library of boxes.
std::unique_ptr<BoxLibrary> make_cgal_tree();

}  // namespace selvedge::detail
