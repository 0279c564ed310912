// SPDX-License-Identifier: MIT
//
// The judge on plain arrays.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/judge/judge.h>

namespace selvedge::c {
namespace {

/// Surface at t = 0; empty if there is none.
TriangleMesh mesh_of(const selvedge_surface* given, const char* name) {
  if (given == nullptr) return {};
  const SurfaceState s = state(given, name);
  return {{s.x.begin(), s.x.end()}, {s.triangles.begin(), s.triangles.end()}};
}

void set_first(int32_t (&out)[2], const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
  out[0] = pairs.empty() ? -1 : pairs.front().first;
  out[1] = pairs.empty() ? -1 : pairs.front().second;
}

}  // namespace
}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_judge(const selvedge_surface* mesh, const selvedge_surface* body, const double* rest,
                   selvedge_verdict* out) {
  return c::call([&] {
    c::needed(mesh, "mesh");
    c::needed(out, "out");
    const TriangleMesh cloth = c::mesh_of(mesh, "mesh");
    TriangleMesh unstrained;
    if (rest != nullptr) {
      const auto x = c::rows<Vec3>(rest, mesh->vertices, "rest");
      unstrained = {{x.begin(), x.end()}, cloth.triangles};
    }
    const Verdict found = judge(cloth, c::mesh_of(body, "body"), unstrained);
    selvedge_verdict verdict{};
    verdict.self_crossings = found.self_intersections;
    verdict.body_crossings = found.body_intersections;
    verdict.self_touches = found.self_touches;
    verdict.body_touches = found.body_touches;
    verdict.inside_vertices = found.inside_vertices;
    verdict.max_penetration = found.max_penetration_m;
    verdict.max_stretch = found.max_stretch;
    verdict.max_compression = found.max_compression;
    c::set_first(verdict.first_self_crossing, found.first_self);
    c::set_first(verdict.first_body_crossing, found.first_body);
    *out = verdict;
  });
}

int selvedge_judge_path(const selvedge_surface* mesh, const selvedge_surface* body,
                        uint64_t* self_collisions, uint64_t* body_collisions) {
  return c::call([&] {
    c::needed(self_collisions, "self_collisions");
    c::needed(body_collisions, "body_collisions");
    const MovingSurface cloth = c::moving(mesh, "mesh");
    const MovingSurface against = body == nullptr ? MovingSurface{} : c::moving(body, "body");
    const PathVerdict found =
        judge_path(c::mesh_of(mesh, "mesh"), cloth.x_t1, c::mesh_of(body, "body"), against.x_t1);
    *self_collisions = found.self_collisions;
    *body_collisions = found.body_collisions;
  });
}
