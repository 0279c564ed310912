// SPDX-License-Identifier: MIT
//
// Garments from sewing patterns, put on bodies.
#include <selvedge/bindings/c/calls.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/scene/fabric_file.h>

#include <filesystem>
#include <map>

struct selvedge_garment {
  selvedge::c::Mesh worn, flat, body;
  std::string verdict, hash;
  std::map<std::string, double> figures;

  explicit selvedge_garment(selvedge::DressResult&& r)
      : worn(std::move(r.garment)),
        flat(std::move(r.flat)),
        body(std::move(r.body)),
        verdict(r.verdict()),
        hash(r.state_hash),
        figures{{"worn", r.worn()},     {"good", r.good()},
                {"clean", r.clean},     {"sewn", r.sewn},
                {"at_rest", r.at_rest}, {"max_stretch", r.max_stretch},
                {"drop_m", r.drop},     {"states_judged", static_cast<double>(r.states)}} {}
};

namespace selvedge::c {
namespace {

UpAxis axis_of(char up) {
  if (up == 'x') return UpAxis::x;
  if (up == 'z') return UpAxis::z;
  if (up == 'y' || up == 0) return UpAxis::y;
  throw std::invalid_argument("pattern_up is none of 'x', 'y', 'z' and 0");
}

DressConfig config_of(const selvedge_dress_options& options) {
  DressConfig config;
  config.edge_length = options.edge_length;
  if (options.fabric != nullptr) {
    config.fabric = find_fabric(options.fabric, std::filesystem::current_path()).material;
    config.fabric_name = options.fabric;
    config.wearable_stretch = config.fabric.strain_limit;
  }
  if (options.body_friction != 0.0) config.body_friction = options.body_friction;
  config.fit_origin = options.fit_origin != 0;
  return config;
}

TriangleMesh mesh_of(const selvedge_surface* surface) {
  const SurfaceState s = state(surface, "body");
  return {{s.x.begin(), s.x.end()}, {s.triangles.begin(), s.triangles.end()}};
}

}  // namespace
}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_dress(const char* pattern, const char* name, const selvedge_surface* body,
                   const selvedge_dress_options* options, selvedge_garment** out) {
  return c::call([&] {
    const selvedge_dress_options& given = c::needed(options, "options");
    c::needed(pattern, "pattern");
    c::needed(out, "out");
    DressConfig config = c::config_of(given);
    const SewingPattern sewn =
        turned_upright(parse_sewing_pattern(pattern, name == nullptr ? "pattern" : name),
                       c::axis_of(given.pattern_up));
    find_fabrics(sewn, std::filesystem::current_path(), config);
    *out = new selvedge_garment(dress(sewn, c::mesh_of(body), config));
  });
}
void selvedge_garment_free(selvedge_garment* garment) { delete garment; }

const selvedge_mesh* selvedge_garment_mesh(const selvedge_garment* garment) {
  return garment == nullptr ? nullptr : &garment->worn;
}
const selvedge_mesh* selvedge_garment_flat(const selvedge_garment* garment) {
  return garment == nullptr ? nullptr : &garment->flat;
}
const selvedge_mesh* selvedge_garment_body(const selvedge_garment* garment) {
  return garment == nullptr ? nullptr : &garment->body;
}
const char* selvedge_garment_verdict(const selvedge_garment* garment) {
  return garment == nullptr ? nullptr : garment->verdict.c_str();
}
int selvedge_garment_figure(const selvedge_garment* garment, const char* name, double* out) {
  return c::call([&] {
    const selvedge_garment& given = c::needed(garment, "garment");
    c::needed(out, "out") = c::figure_named(name, given.figures);
  });
}
const char* selvedge_garment_hash(const selvedge_garment* garment) {
  return garment == nullptr ? nullptr : garment->hash.c_str();
}
