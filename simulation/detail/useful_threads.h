// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/scene/build.h>

namespace selvedge::detail {

/// The number of threads beyond which the steps of the scene become no faster: one per 600
/// particles and vertices of moving bodies, at least two. A sheet of 2,500 particles takes as long
/// with 4 as with 8 threads and longer with 16; one of 10,000 gains little beyond 8
/// (docs/lab/performance.md, More threads).
int useful_threads(const Scene& scene, const BuiltScene& built);

}  // namespace selvedge::detail
