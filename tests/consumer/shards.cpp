// SPDX-License-Identifier: MIT
// A particle program that has never heard of cloth: triangular shards with arrays of its own fall
// on a floor, and selvedge's broad and narrow phase say when each lands.
#include <selvedge/broadphase/broad_phase.h>
#include <selvedge/narrowphase/narrow_phase.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

namespace {

struct Shards {
  std::vector<selvedge::Vec3> before, after;
  std::vector<selvedge::Triangle> faces;
  std::vector<selvedge::Edge> edges;
};

void add_shard(Shards& shards, const selvedge::Vec3& corner, double size, double fall) {
  const auto first = static_cast<std::int32_t>(shards.before.size());
  const selvedge::Vec3 offsets[] = {{0, 0, 0}, {size, 0, 0}, {0, size, size}};
  for (const selvedge::Vec3& offset : offsets) {
    shards.before.push_back(corner + offset);
    shards.after.push_back(corner + offset - selvedge::Vec3(0, 0, fall));
  }
  shards.faces.push_back({first, first + 1, first + 2});
  shards.edges.insert(shards.edges.end(),
                      {{first, first + 1}, {first + 1, first + 2}, {first, first + 2}});
}

selvedge::SurfaceView view(const Shards& shards) {
  return {shards.before, shards.after, shards.edges, shards.faces, 0.0, 0};
}

}  // namespace

int main() {
  // 100 shards, one above each cell of a floor of two triangles, the lower half fast enough to
  // land.
  Shards rain, floor;
  for (int i = 0; i < 100; ++i) {
    const double height = 0.05 + 0.01 * i;
    add_shard(rain, selvedge::Vec3(0.1 + 0.08 * (i % 10), 0.1 + 0.08 * (i / 10), height), 0.02,
              0.545);
  }
  floor.before = floor.after = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  floor.faces = {{0, 1, 2}, {0, 2, 3}};
  floor.edges = {{0, 1}, {1, 2}, {0, 2}, {2, 3}, {0, 3}};

  const auto broad_phase = selvedge::broad_phases().at("bvh_aabb")();
  const auto narrow_phase = selvedge::narrow_phases().at("ccd_exact")({});
  selvedge::CandidatePairs pairs;
  broad_phase->find_pairs(view(rain), view(floor), pairs);
  std::vector<selvedge::Contact> contacts;
  narrow_phase->find_contacts(view(rain), view(floor), pairs, contacts);

  std::set<std::int32_t> landed;
  for (const selvedge::Contact& contact : contacts) {
    if (contact.kind == selvedge::ContactKind::point_triangle) {
      landed.insert(contact.vertex[0] / 3);
    }
  }
  std::printf("%zu of 100 shards landed, %zu candidate pairs\n", landed.size(), pairs.size());
  return landed.size() == 50 ? 0 : 1;
}
