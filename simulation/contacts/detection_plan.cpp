// SPDX-License-Identifier: MIT
#include <selvedge/simulation/contacts/detail/detection_plan.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace selvedge::detail {
namespace {

/// Primitives that keep apart by this share of the least distance at the start do not collide; the
/// share is a million times the rounding.
constexpr double kApart = 1e-6;

std::vector<std::int32_t> body_begins(const BuiltScene& built) {
  std::vector<std::int32_t> begins = {0};
  for (const auto& body : built.bodies)
    begins.push_back(begins.back() + static_cast<std::int32_t>(body->vertex_count()));
  return begins;
}

std::vector<SheetProof> make_sheets(const BuiltScene& built) {
  std::vector<SheetProof> sheets;
  const TriangleMesh& cloth = built.cloth.surface;
  for (std::size_t p = 0; p + 1 < built.piece_begin.size(); ++p) {
    const std::int32_t begin = built.piece_begin[p], end = built.piece_begin[p + 1];
    std::vector<Triangle> triangles;
    for (const Triangle& t : cloth.triangles)
      if (t[0] >= begin && t[0] < end)
        triangles.push_back({t[0] - begin, t[1] - begin, t[2] - begin});
    sheets.emplace_back(std::span(cloth.vertices).subspan(begin, end - begin), triangles);
  }
  return sheets;
}

}  // namespace

DetectionPlan::DetectionPlan(const Scene& scene, const BuiltScene& built,
                             const Distances& distances, bool exact)
    : proofs_(scene.plan.proofs),
      on_(scene.plan.proofs && exact),
      distances_(distances),
      piece_begin_(built.piece_begin),
      body_begin_(body_begins(built)) {
  const bool pieces_are_apart = built.merged_areas.empty();  // no triangle is of two pieces
  // Without self-collision for the check of frames alone.
  if (proofs_ && pieces_are_apart) sheets_ = make_sheets(built);
}

bool DetectionPlan::sheets_keep_apart(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                                      double distance, double between) {
  boxes_.clear();
  for (std::size_t p = 0; p < sheets_.size(); ++p) {
    const std::size_t begin = piece_begin_[p], count = piece_begin_[p + 1] - begin;
    const auto mine_t0 = x_t0.subspan(begin, count), mine_t1 = x_t1.subspan(begin, count);
    const double least = distance > 0.0 ? distance : kApart * sheets_[p].nearest();
    if (!sheets_[p].keeps_apart(mine_t0, mine_t1, least)) return false;
    if (sheets_.size() == 1) return true;
    const SweptBox box = swept_box(mine_t0, mine_t1);
    for (const SweptBox& other : boxes_)
      if (!keep_apart(box, other, between)) return false;
    boxes_.push_back(box);
  }
  return !sheets_.empty();
}

bool DetectionPlan::self_is_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) {
  ++self_.asked;
  if (!on_ || !backoff_.is_due()) return false;
  const bool idle = sheets_keep_apart(x_t0, x_t1, distances_.proximity,
                                      distances_.reach + 2.0 * distances_.margin);
  backoff_.note(idle);
  if (idle) ++self_.idle;
  return idle;
}

bool DetectionPlan::self_stays_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1) {
  if (sheets_keep_apart(x_t0, x_t1, 0.0, 0.0)) return true;
  --self_.idle;  // not idle after all
  return false;
}

bool DetectionPlan::bodies_are_idle(std::span<const Vec3> x_t0, std::span<const Vec3> x_t1,
                                    std::span<const Vec3> bodies_t0,
                                    std::span<const Vec3> bodies_t1, bool move) {
  if (bodies_t0.empty()) return true;
  ++bodies_.asked;
  if (!on_) return false;
  const std::size_t count = body_begin_.size() - 1;
  if (move || body_boxes_.empty()) {
    body_boxes_.clear();
    for (std::size_t b = 0; b < count; ++b) {
      const std::size_t begin = body_begin_[b], size = body_begin_[b + 1] - begin;
      body_boxes_.push_back(
          swept_box(bodies_t0.subspan(begin, size), bodies_t1.subspan(begin, size)));
    }
  }
  const SweptBox cloth = swept_box(x_t0, x_t1);
  const double least = distances_.reach + 2.0 * distances_.margin;
  const bool idle = std::all_of(body_boxes_.begin(), body_boxes_.end(), [&](const SweptBox& body) {
    return keep_apart(cloth, body, least);
  });
  if (idle) ++bodies_.idle;
  return idle;
}

bool DetectionPlan::self_is_uncrossed(std::span<const Vec3> x) {
  ++crossings_self_.asked;
  if (!proofs_ || !crossings_backoff_.is_due()) return false;
  const bool idle = sheets_keep_apart(x, x, 0.0, 0.0);
  crossings_backoff_.note(idle);
  if (idle) ++crossings_self_.idle;
  return idle;
}

bool DetectionPlan::bodies_are_uncrossed(std::span<const Vec3> x, std::span<const Vec3> bodies) {
  ++crossings_bodies_.asked;
  if (!proofs_) return false;
  const SweptBox cloth = swept_box(x, x);
  for (std::size_t b = 0; b + 1 < body_begin_.size(); ++b) {
    const auto own = bodies.subspan(body_begin_[b], body_begin_[b + 1] - body_begin_[b]);
    if (!keep_apart(cloth, swept_box(own, own), 0.0)) return false;
  }
  ++crossings_bodies_.idle;
  return true;
}

void DetectionPlan::note_uncrossed() {
  ++crossings_self_.asked;
  ++crossings_self_.idle;
  if (body_begin_.size() == 1) return;
  ++crossings_bodies_.asked;
  ++crossings_bodies_.idle;
}

std::map<std::string, IdleCount> DetectionPlan::counts() const {
  std::map<std::string, IdleCount> all;
  if (crossings_self_.asked > 0) all["crossings_self"] = crossings_self_;
  if (crossings_bodies_.asked > 0) all["crossings_body"] = crossings_bodies_;
  if (self_.asked > 0) all["self_collision"] = self_;
  if (bodies_.asked > 0) all["body_collision"] = bodies_;
  return all;
}

}  // namespace selvedge::detail
