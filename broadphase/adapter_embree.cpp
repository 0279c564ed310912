// SPDX-License-Identifier: MIT
// I. Wald, S. Woop, C. Benthin, G. Johnson, M. Ernst, "Embree: a kernel framework for efficient CPU
// ray tracing", 2014 [Wald2014].
//
// rtcCollide supports only user geometry: with triangle geometry the library aborts the program. It
// receives boxes without time steps, because the boxes cover the whole step.
#include <selvedge/broadphase/adapters.h>
#include <selvedge/broadphase/detail/box_library.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

void bounds_of(const RTCBoundsFunctionArguments* args) {
  const auto& boxes = *static_cast<const std::span<const detail::UnitBox>*>(args->geometryUserPtr);
  const detail::UnitBox& box = boxes[args->primID];
  RTCBounds& out = *args->bounds_o;
  out.lower_x = box.lo[0];
  out.lower_y = box.lo[1];
  out.lower_z = box.lo[2];
  out.upper_x = box.hi[0];
  out.upper_y = box.hi[1];
  out.upper_z = box.hi[2];
}

void add_pairs(void* out, RTCCollision* collisions, unsigned int count) {
  auto& pairs = *static_cast<detail::UnitPairs*>(out);
  for (unsigned int i = 0; i < count; ++i) pairs.add(collisions[i].primID0, collisions[i].primID1);
}

/// For a surface against itself the library reports both (i, j) and (j, i).
void add_ordered_pairs(void* out, RTCCollision* collisions, unsigned int count) {
  auto& pairs = *static_cast<detail::UnitPairs*>(out);
  for (unsigned int i = 0; i < count; ++i)
    if (collisions[i].primID0 < collisions[i].primID1)
      pairs.add(collisions[i].primID0, collisions[i].primID1);
}

class EmbreeLibrary final : public detail::BoxLibrary {
 public:
  EmbreeLibrary() : device_(rtcNewDevice(nullptr)) {
    if (!device_)
      throw std::runtime_error("Embree cannot start: error " +
                               std::to_string(rtcGetDeviceError(nullptr)));
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void* bytes, ssize_t change, bool) {
          *static_cast<std::atomic<std::int64_t>*>(bytes) += change;
          return true;
        },
        &bytes_);
  }
  ~EmbreeLibrary() override {
    for (Scene& s : scenes_) s.release();
    rtcReleaseDevice(device_);
  }
  EmbreeLibrary(const EmbreeLibrary&) = delete;
  EmbreeLibrary& operator=(const EmbreeLibrary&) = delete;

  void build(int slot, std::span<const detail::UnitBox> boxes, bool) override {
    Scene& s = scenes_[slot];
    s.release();
    s.boxes = boxes;
    s.scene = rtcNewScene(device_);
    s.geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    // Low quality with refitting was measured too: a sixth less time in total, but its builder
    // aborts the program with an assertion on coincident boxes.
    rtcSetSceneBuildQuality(s.scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetGeometryUserPrimitiveCount(s.geometry, static_cast<unsigned int>(boxes.size()));
    rtcSetGeometryUserData(s.geometry, &s.boxes);
    rtcSetGeometryBoundsFunction(s.geometry, bounds_of, nullptr);
    rtcAttachGeometry(s.scene, s.geometry);
    commit(s);
  }

  /// Rebuilds in place: at this quality the library's refit costs as much as a build.
  bool refit(int slot, std::span<const detail::UnitBox> boxes) override {
    Scene& s = scenes_[slot];
    s.boxes = boxes;
    commit(s);
    return true;
  }

  void find(int slot_a, int slot_b, detail::UnitPairs& out) override {
    rtcCollide(scenes_[slot_a].scene, scenes_[slot_b].scene, add_pairs, &out);
    check("looks for pairs");
  }
  void find_self(int slot, detail::UnitPairs& out) override {
    rtcCollide(scenes_[slot].scene, scenes_[slot].scene, add_ordered_pairs, &out);
    check("looks for pairs");
  }

  std::size_t bytes() const override { return static_cast<std::size_t>(bytes_.load()); }

  BroadPhaseTraits traits() const override {
    return {.source =
                "rtcCollide of Embree over swept triangles; I. Wald, S. Woop, C. Benthin, G. "
                "Johnson, M. Ernst, Embree: a kernel framework for efficient CPU ray tracing, "
                "2014"};
  }

 private:
  struct Scene {
    std::span<const detail::UnitBox> boxes;
    RTCScene scene = nullptr;
    RTCGeometry geometry = nullptr;

    void release() {
      if (geometry) rtcReleaseGeometry(geometry);
      if (scene) rtcReleaseScene(scene);
      geometry = nullptr;
      scene = nullptr;
    }
  };

  void commit(Scene& s) {
    rtcCommitGeometry(s.geometry);
    rtcCommitScene(s.scene);
    check("builds its tree");
  }

  void check(const char* when) const {
    if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE)
      throw std::runtime_error("Embree fails while it " + std::string(when) + ": error " +
                               std::to_string(error));
  }

  std::atomic<std::int64_t> bytes_{0};
  RTCDevice device_;
  std::array<Scene, detail::kBoxSlots> scenes_;
};

}  // namespace

void register_embree(BroadPhaseRegistry& registry) {
  registry.add("embree_collide", {}, [](const MethodOptions&) {
    return detail::make_box_broad_phase(std::make_unique<EmbreeLibrary>());
  });
}

}  // namespace selvedge
