// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/core/base/collision_types.h>

#include <span>
#include <vector>

namespace selvedge::detail {

/// Proofs that candidates of a step do not collide, whatever end its particles reach within the
/// clearance of the pair (see find_proximities). Only the other candidates are tested for
/// collisions. Positions are in the joint index space of ContactPoint.
class Certificates {
 public:
  /// Forgets the clearances of the candidates of the cloth with itself (`self`), or with the
  /// bodies: the candidates or the start have changed.
  void clear(bool self) { of(self).rooms.clear(); }
  void clear() {
    clear(false);
    clear(true);
  }
  /// The ends for which rooms are given next, m.
  void begin(std::span<const Vec3> x_t1);
  /// The clearance of each candidate of the cloth with itself (`self`), or with the bodies; m.
  std::vector<float>& rooms(bool self) { return of(self).rooms; }

  /// Compares the present ends with those of the rooms; the first `particles` are cloth. Call
  /// before `open`.
  void measure(std::span<const Vec3> x_t1, std::size_t particles);
  /// Those of the candidates `all` of the surfaces `a` and `b` that may collide at the ends that
  /// were measured, in their order. Valid until the next call for the same surfaces.
  const CandidatePairs& open(bool self, const SurfaceView& a, const SurfaceView& b,
                             const CandidatePairs& all);

 private:
  struct List {
    std::vector<float> rooms;
    std::vector<float> moved;  // m, largest change of a coordinate of each end since, rounded up
    float most = 0.0F;         // of all vertices
    CandidatePairs open;
  };

  List& of(bool self) { return self ? self_ : bodies_; }
  void measure(List& list, std::span<const Vec3> x_t1, const Vec3& shift) const;

  std::vector<Vec3> x_t1_;  // ends of the rooms
  List bodies_, self_;
};

}  // namespace selvedge::detail
