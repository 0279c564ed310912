// SPDX-License-Identifier: MIT
// The additions of docs/adding.md, one per file of this folder.
#pragma once

#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/methods.h>

namespace adding {

void register_one_axis(selvedge::BroadPhaseRegistry& registry);
void register_sampled(selvedge::NarrowPhaseRegistry& registry);
void register_stop(selvedge::ResponseRegistry& registry);
void register_dragged_euler(selvedge::IntegratorRegistry& registry);
void register_weight_spring(selvedge::ForceLawRegistry& registry);
void register_threads(selvedge::ClothPatternRegistry& registry);
void register_points(selvedge::FrameFormatRegistry& registry);

}  // namespace adding
