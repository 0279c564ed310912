// SPDX-License-Identifier: MIT
#include <selvedge/run/frame_writer.h>

namespace selvedge {

// The formats register themselves in their own files. A new one adds its name to both lists.
void register_gltf(FrameFormatRegistry& registry);
void register_mdd(FrameFormatRegistry& registry);
void register_obj(FrameFormatRegistry& registry);
void register_pc2(FrameFormatRegistry& registry);
void register_ply(FrameFormatRegistry& registry);
void register_usd(FrameFormatRegistry& registry);
void register_vtk(FrameFormatRegistry& registry);
void register_wrenches(FrameFormatRegistry& registry);

FrameFormatRegistry frame_formats() {
  FrameFormatRegistry registry;
  for (const auto add : {register_gltf, register_mdd, register_obj, register_pc2, register_ply,
                         register_usd, register_vtk, register_wrenches})
    add(registry);
  return registry;
}

}  // namespace selvedge
