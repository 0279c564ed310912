// SPDX-License-Identifier: MIT
#include <selvedge/run/detail/coming_events.h>

#include <algorithm>

namespace selvedge::detail {
namespace {

struct Span {
  double begin, end;  ///< s
  /// What happens at its begin acts in the next step.
  bool has(double time) const { return time >= begin && time <= end; }
};

bool acts(const HandleSpec& handle, const Span& left) {
  if (handle.release && left.has(*handle.release)) return true;
  const Keyframe now = pose_at(handle.motion, left.begin);
  return std::any_of(handle.motion.begin(), handle.motion.end(), [&](const Keyframe& key) {
    return key.time > left.begin &&
           (key.translation != now.translation || key.rotation.coeffs() != now.rotation.coeffs());
  });
}

bool flows_otherwise(const WaterSource& source, const Span& left) {
  return source.rate > 0.0 && (left.has(source.begin) || left.has(source.end));
}

}  // namespace

bool events_come(const Scene& scene, const BuiltScene& built, double time) {
  const Span left{time, scene.time.frames / scene.time.fps};
  const auto in = [&](const auto& all, const auto& comes) {
    return std::any_of(all.begin(), all.end(), comes);
  };
  return in(built.bodies, [&](const auto& body) { return !body->is_static(time, left.end); }) ||
         in(scene.handles, [&](const HandleSpec& handle) { return acts(handle, left); }) ||
         (scene.water && in(scene.water->sources, [&](const WaterSource& source) {
            return flows_otherwise(source, left);
          }));
}

}  // namespace selvedge::detail
