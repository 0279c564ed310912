// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/parallel.h>
#include <selvedge/scene/detail/make_piece.h>

namespace selvedge::detail {

/// Makes a piece of the scene by its number, placed as it starts.
using PieceMaker = FunctionRef<Piece(std::size_t piece)>;

/// build_scene with other pieces than the scene's own.
BuiltScene build_scene(const Scene& scene, const PieceMaker& make);

}  // namespace selvedge::detail
