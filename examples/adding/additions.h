// SPDX-License-Identifier: MIT
// The additions of docs/adding.md, one per file of this folder.
#pragma once

#include <selvedge/core/cloth_pattern.h>
#include <selvedge/core/force.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/scene/methods.h>

namespace adding {

void register_one_axis(selvedge::BroadPhaseRegistry& registry);
void register_sampled(selvedge::NarrowPhaseRegistry& registry);
void register_stop(selvedge::ResponseRegistry& registry);
void register_dragged_euler(selvedge::IntegratorRegistry& registry);
selvedge::ForceLaw weight_spring_law();
selvedge::ClothPattern mesh_of_threads_pattern();
selvedge::FrameFormat points_format();

}  // namespace adding
