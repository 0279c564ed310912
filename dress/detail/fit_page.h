// SPDX-License-Identifier: MIT
//
// The page of a fit report.
#pragma once

#include <selvedge/dress/dress.h>

#include <string>
#include <vector>

namespace selvedge::detail {

/// A colour for each triangle of the garment, linear RGB, by the ease of its zone.
std::vector<Vec3> fit_colours(const DressResult& r);
/// fit.html beside the folder pictures/ with fit_front.png, fit_back.png, fit_left.png and
/// fit_right.png.
std::string fit_page(const std::string& pattern_name, const DressResult& r);

}  // namespace selvedge::detail
