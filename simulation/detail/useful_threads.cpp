// SPDX-License-Identifier: MIT
#include <selvedge/simulation/detail/useful_threads.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

constexpr std::size_t kVerticesPerThread = 600, kFewest = 2, kMost = 1024;

}  // namespace

int useful_threads(const Scene& scene, const BuiltScene& built) {
  const double end = scene.time.frames / scene.time.fps;
  std::size_t vertices = built.cloth.surface.vertices.size();
  for (const auto& body : built.bodies)
    if (!body->is_static(0.0, end)) vertices += body->vertex_count();
  const std::size_t threads = (vertices + kVerticesPerThread - 1) / kVerticesPerThread;
  return static_cast<int>(std::clamp(threads, kFewest, kMost));
}

}  // namespace selvedge::detail
