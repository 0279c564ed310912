// SPDX-License-Identifier: MIT
//
// The garment between two phases: its scene, and the merge of seams that have closed.
#include <fmt/format.h>
#include <selvedge/core/cloth/cloth_elements.h>
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/patterns/make_cloth.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/internal/seam_merging.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace selvedge::detail {
namespace {

constexpr double kOpeningShare = 0.1;  // of the edge length of the mesh
constexpr double kLeastMerge = 2.0;    // rest gaps, the shortest distance at which pairs merge
/// Of the widest seam at the start; seams that are open by more span the body.
constexpr double kSpanning = 0.5;
constexpr std::size_t kMostMoves = 64;  // blocked pairs that move_together tries
constexpr double kMoveShare = 0.98;     // of the distance of a pair, which it moves a vertex
constexpr const char* kCloth = "garment";
constexpr const char* kBody = "body";
constexpr const char* kMaterial = "fabric";
/// The reach of the pull, relative to the largest opening. Within a hundredth of the reach, the
/// pull decreases to zero.
constexpr double kReach = 1.25;
constexpr double kLeastReach = 0.05;  // m
/// Duration over which a pull damps the rate of the distance, s.
constexpr double kSeamDamping = 0.02;

double pair_distance(const Garment& garment, const Edge& pair) {
  return (garment.surface.vertices[pair[1]] - garment.surface.vertices[pair[0]]).norm();
}

SeamSpec seam_spec(std::span<const Edge> pairs, double tension, double reach, double merge) {
  SeamSpec spec;
  spec.geometry = {kCloth, kCloth};
  for (const Edge& pair : pairs)
    for (int side = 0; side < 2; ++side) spec.vertices[side].push_back(pair[side]);
  spec.sewing = {
      .pull = tension / reach, .tolerance = reach, .damping = kSeamDamping * tension / reach};
  spec.merge = merge;
  return spec;
}

/// The warp of a fabric runs along x of a flat mesh, and along y of a panel.
Material along_panel(Material fabric) {
  if (fabric.stretch_weft) std::swap(fabric.stretch_stiffness, *fabric.stretch_weft);
  if (fabric.bending_weft) std::swap(fabric.bending_stiffness, *fabric.bending_weft);
  if (!fabric.tension_weft.empty()) std::swap(fabric.tension_curve, fabric.tension_weft);
  if (!fabric.bending_curve_weft.empty())
    std::swap(fabric.bending_curve, fabric.bending_curve_weft);
  return fabric;
}

/// A fabric with at least a bending stiffness, N·m; that of one that is softer has no curve then.
Material stiffened(Material fabric, double least) {
  if (fabric.bending_stiffness < least) {
    fabric.bending_stiffness = least;
    fabric.bending_curve = {};
  }
  if (fabric.bending_weft && *fabric.bending_weft < least) {
    fabric.bending_weft = least;
    fabric.bending_curve_weft = {};
  }
  return fabric;
}

/// The fabrics of a garment, that of panels without one of their own first, and which one each
/// triangle has.
struct Fabrics {
  std::vector<Material> list;
  std::vector<std::int32_t> of_triangle;
};

Fabrics fabrics_of(const Garment& garment, const DressConfig& config, double least_bending) {
  Fabrics fabrics{{config.fabric}, {}};
  std::map<std::string, std::int32_t> number = {{"", 0}};
  for (const std::string& name : garment.panel_fabrics) {
    const auto [at, is_new] =
        number.try_emplace(name, static_cast<std::int32_t>(fabrics.list.size()));
    if (is_new) fabrics.list.push_back(config.fabrics.at(name));
  }
  for (Material& fabric : fabrics.list) fabric = stiffened(along_panel(fabric), least_bending);
  for (const std::int32_t panel : garment.panel_of_triangle)
    fabrics.of_triangle.push_back(
        number.at(garment.panel_fabrics[static_cast<std::size_t>(panel)]));
  return fabrics;
}

/// A hinge on a fold line, by its index, and its length in the flat pattern, m.
struct FoldHinge {
  std::size_t hinge = 0;
  double length = 0.0;
};

/// The hinges of the flat pieces that lie along a row of vertices.
std::vector<FoldHinge> hinges_along(const Garment& garment, const ClothMesh& cloth,
                                    const std::vector<std::int32_t>& row) {
  std::set<Edge> along;
  for (std::size_t i = 1; i < row.size(); ++i)
    along.insert({std::min(row[i - 1], row[i]), std::max(row[i - 1], row[i])});
  struct Side {
    std::set<std::int32_t> opposite;
    double length = 0.0;
  };
  std::map<Edge, Side> sides;  // of each edge on the surface
  for (const Triangle& t : garment.flat.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = t[k], b = t[(k + 1) % 3];
      if (!along.contains({std::min(a, b), std::max(a, b)})) continue;
      const std::int32_t u = garment.corner[a], v = garment.corner[b];
      Side& side = sides[{std::min(u, v), std::max(u, v)}];
      side.opposite.insert(garment.corner[t[(k + 2) % 3]]);
      side.length = (garment.flat.vertices[b] - garment.flat.vertices[a]).norm();
    }
  std::vector<FoldHinge> found;
  for (std::size_t h = 0; h < cloth.hinges.size(); ++h) {
    const auto& v = cloth.hinges[h].v;
    const auto at = sides.find({std::min(v[2], v[3]), std::max(v[2], v[3])});
    if (at == sides.end()) continue;
    const Side& side = at->second;
    if (side.opposite.contains(v[0]) && side.opposite.contains(v[1]))
      found.push_back({h, side.length});
  }
  return found;
}

/// Sets the rest angles along fold lines, and adds hinges that hold them.
void add_folds(const Garment& garment, const Material& fabric, ClothMesh& cloth) {
  for (const DividedFold& fold : garment.folds)
    for (const auto& [h, length] : hinges_along(garment, cloth, fold.vertices)) {
      // The angle of a hinge is positive where the outer sides come together.
      cloth.hinges[h].rest_angle = -fold.angle;
      Hinge crease = cloth.hinges[h];
      crease.stiffness = fold.stiffness * length;
      crease.damping = fabric.bending_damping;
      crease.sine = false;
      cloth.hinges.push_back(crease);
    }
}

/// Share of the stiffness of cloth along an elastic that remains: its gathers are finer than the
/// mesh, so that it gives way until it is flat. Its strain limit stays.
constexpr double kGathered = 0.05;

/// Springs without a strain limit, along the elastics, in place of the cloth there.
void add_elastics(const Garment& garment, const Material& fabric, ClothMesh& cloth) {
  if (garment.elastics.empty()) return;
  constexpr double none = StrainLimitOfSpring::kDefault;
  cloth.strain_limit.resize(cloth.springs.size(), none);
  std::set<Edge> gathered;
  for (const DividedElastic& elastic : garment.elastics)
    for (std::size_t i = 1; i < elastic.vertices.size(); ++i) {
      const std::int32_t u = garment.corner[elastic.vertices[i - 1]],
                         v = garment.corner[elastic.vertices[i]];
      gathered.insert({std::min(u, v), std::max(u, v)});
    }
  for (Spring& spring : cloth.springs)
    if (gathered.contains({std::min(spring.a, spring.b), std::max(spring.a, spring.b)}))
      spring.stiffness *= kGathered;
  for (const DividedElastic& elastic : garment.elastics)
    for (std::size_t i = 1; i < elastic.vertices.size(); ++i) {
      const std::int32_t u = elastic.vertices[i - 1], v = elastic.vertices[i];
      if (garment.corner[u] == garment.corner[v]) continue;
      const double rest =
          elastic.elastic.ratio * (garment.flat.vertices[v] - garment.flat.vertices[u]).norm();
      cloth.springs.push_back({garment.corner[u], garment.corner[v], rest,
                               elastic.elastic.stiffness / rest, fabric.spring_damping});
      cloth.strain_limit.push_back(none);
      if (!cloth.curve_of_spring.empty()) cloth.curve_of_spring.push_back(-1);
    }
}

ClothMesh make_cloth(const Garment& garment, const DressConfig& config,
                     const PhaseSettings& settings) {
  const Fabrics fabrics = fabrics_of(garment, config, settings.least_bending);
  ClothMesh cloth =
      fabrics.list.size() == 1
          ? make_from_pattern(garment.surface, garment.flat, fabrics.list[0])
          : make_from_pattern(garment.surface, garment.flat, fabrics.list, fabrics.of_triangle);
  add_folds(garment, config.fabric, cloth);
  if (settings.with_elastics) add_elastics(garment, config.fabric, cloth);
  return cloth;
}

std::string layer_name(std::size_t k) { return fmt::format("under_{}", k); }

Piece layer_piece(const UnderLayer& layer) {
  const WornGarment& worn = *layer.worn;
  return {make_from_pattern({layer.x, worn.surface.triangles}, worn.flat, worn.fabric), worn.flat};
}

BodySpec skin_spec(const std::string& name, const TriangleMesh& mesh, double friction) {
  BodyFile skin;
  skin.mesh = mesh;
  skin.load.weld = false;
  return {.name = name, .shape = skin, .placement = {}, .motion = {}, .friction = friction};
}

/// The garments below at rest, while the new one is sewn around them.
void add_held_layers(const Garment& garment, const PhaseSettings& settings, Scene& scene) {
  for (std::size_t k = 0; k < garment.under.size(); ++k) {
    const UnderLayer& layer = garment.under[k];
    scene.bodies.push_back(
        skin_spec(layer_name(k), {layer.x, layer.worn->surface.triangles}, settings.friction));
  }
}

/// The garments below as cloth, with frictions of their own.
void add_layers(const Garment& garment, Scene& scene) {
  const auto add_friction = [&](std::size_t k, const std::string& other, double friction) {
    scene.contact.pairs.push_back(
        {.a = layer_name(k), .b = other, .friction = friction, .rest_gap = {}});
  };
  for (std::size_t k = 0; k < garment.under.size(); ++k) {
    const UnderLayer& layer = garment.under[k];
    const std::string material = layer_name(k) + " fabric";
    scene.materials[material] = layer.worn->fabric;
    ClothFile surface;
    surface.mesh = {layer.x, layer.worn->surface.triangles};
    scene.cloths.push_back(
        {.name = layer_name(k), .shape = surface, .placement = {}, .material = material});
    add_friction(k, kBody, layer.worn->body_friction);
    add_friction(k, kCloth, layer.worn->outer_friction);
    for (std::size_t outer = k + 1; outer < garment.under.size(); ++outer)
      add_friction(k, layer_name(outer), layer.worn->outer_friction);
  }
}

/// Takes over the vertices of the garment, and of those below if they are cloth.
void take_vertices(std::span<const Vec3> x, std::span<const Vec3> v, bool with_under,
                   Garment& garment) {
  const auto assign = [](std::vector<Vec3>& to, std::span<const Vec3> from) {
    to.assign(from.begin(), from.end());
  };
  std::size_t at = x.size();
  if (with_under)
    for (const UnderLayer& layer : garment.under) at -= layer.x.size();
  assign(garment.surface.vertices, x.first(at));
  assign(garment.velocity, v.first(at));
  if (!with_under) return;
  for (UnderLayer& layer : garment.under) {
    const std::size_t count = layer.x.size();
    assign(layer.x, x.subspan(at, count));
    assign(layer.v, v.subspan(at, count));
    at += count;
  }
}

/// New index of each vertex when pairs merge: the one with the smaller index represents both, as in
/// SeamMerging.
std::vector<std::int32_t> numbers_after(std::size_t vertices, std::span<const Edge> pairs) {
  std::vector<std::int32_t> owner(vertices);
  std::iota(owner.begin(), owner.end(), 0);
  for (const Edge& pair : pairs) {
    const std::int32_t a = owner[pair[0]], b = owner[pair[1]];
    std::replace(owner.begin(), owner.end(), std::max(a, b), std::min(a, b));
  }
  std::vector<std::int32_t> rank(vertices, 0), number(vertices);
  std::int32_t count = 0;
  for (std::size_t v = 0; v < vertices; ++v)
    if (owner[v] == static_cast<std::int32_t>(v)) rank[v] = count++;
  for (std::size_t v = 0; v < vertices; ++v) number[v] = rank[owner[v]];
  return number;
}

}  // namespace

bool Garment::is_chosen(std::size_t s, SeamChoice choice) const {
  if (choice == SeamChoice::all) return true;
  if (choice == SeamChoice::gathered) return stitches[s].is_gathered();
  double widest = 0.0;
  for (const Stitching& stitch : stitches) widest = std::max(widest, stitch.span);
  const bool spans = stitches[s].span > kSpanning * widest;
  return spans == (choice == SeamChoice::spanning);
}

std::vector<Edge> Garment::open_pairs(std::size_t s) const {
  std::vector<Edge> pairs;
  if (stitches[s].closes_last && !is_closing) return pairs;
  for (std::size_t i = 0; i < stitches[s].a.size(); ++i) {
    if (!stitches[s].is_joined.empty() && !stitches[s].is_joined[i]) continue;
    const std::int32_t a = corner[stitches[s].a[i]], b = corner[stitches[s].b[i]];
    if (a != b) pairs.push_back({a, b});
  }
  return pairs;
}

std::size_t Garment::open_pairs() const {
  std::size_t sum = 0;
  for (std::size_t s = 0; s < stitches.size(); ++s) sum += open_pairs(s).size();
  return sum;
}

std::size_t Garment::pairs(std::size_t s) const {
  const std::vector<char>& joined = stitches[s].is_joined;
  return joined.empty() ? stitches[s].a.size()
                        : static_cast<std::size_t>(std::count(joined.begin(), joined.end(), 1));
}

double Garment::opening(std::size_t s) const {
  double largest = 0.0;
  for (const Edge& pair : open_pairs(s)) largest = std::max(largest, pair_distance(*this, pair));
  return largest;
}

double Garment::largest_opening() const {
  double largest = 0.0;
  for (std::size_t s = 0; s < stitches.size(); ++s) largest = std::max(largest, opening(s));
  return largest;
}

std::size_t Garment::widest_seam() const {
  std::size_t widest = 0;
  for (std::size_t s = 1; s < stitches.size(); ++s)
    if (opening(s) > opening(widest)) widest = s;
  return widest;
}

double Garment::mean_opening() const {
  double sum = 0.0;
  for (std::size_t s = 0; s < stitches.size(); ++s)
    for (const Edge& pair : open_pairs(s)) sum += pair_distance(*this, pair);
  return sum / static_cast<double>(std::max<std::size_t>(1, open_pairs()));
}

Garment start_garment(const GarmentMesh& mesh, std::span<const WornGarment> under,
                      std::span<const std::string> held_labels) {
  Garment garment;
  garment.surface = {mesh.placed, mesh.flat.triangles};
  garment.flat = mesh.flat;
  garment.velocity.assign(mesh.placed.size(), Vec3::Zero());
  garment.corner.resize(mesh.placed.size());
  std::iota(garment.corner.begin(), garment.corner.end(), 0);
  garment.panel_of_triangle = mesh.panel_of_triangle;
  garment.mirrored = mesh.mirrored;
  garment.image = mesh.image;
  garment.folds = mesh.folds;
  garment.elastics = mesh.elastics;
  garment.panel_fabrics = mesh.panel_fabrics;
  for (const GarmentMesh::Stitch& stitch : mesh.stitches) {
    const auto pieces = static_cast<double>(std::max<std::size_t>(2, stitch.a.size()) - 1);
    const auto [shorter, longer] = std::minmax(stitch.length_a, stitch.length_b);
    double span = 0.0;
    for (std::size_t i = 0; i < stitch.a.size(); ++i)
      span += (mesh.placed[stitch.b[i]] - mesh.placed[stitch.a[i]]).norm();
    garment.stitches.push_back({stitch.a, stitch.b, longer / pieces, longer / shorter - 1.0,
                                span / static_cast<double>(stitch.a.size()),
                                stitch.closure != PatternStitch::Closure::seam});
    if (stitch.closure != PatternStitch::Closure::buttons) continue;
    std::vector<char>& joined = garment.stitches.back().is_joined;
    joined.assign(stitch.a.size(), 0);
    for (const std::int32_t pair : stitch.buttons) joined[static_cast<std::size_t>(pair)] = 1;
  }
  for (std::size_t p = 0; p < mesh.edge_vertices.size(); ++p)
    for (std::size_t e = 0; e < mesh.edge_vertices[p].size(); ++e)
      garment.borders.push_back(
          {static_cast<std::int32_t>(p), static_cast<std::int32_t>(e), mesh.edge_vertices[p][e]});
  for (const std::string& label : held_labels)
    if (const auto found = mesh.labels.find(label); found != mesh.labels.end())
      garment.held.insert(garment.held.end(), found->second.begin(), found->second.end());
  for (const WornGarment& worn : under)
    garment.under.push_back({&worn, worn.surface.vertices,
                             std::vector<Vec3>(worn.surface.vertices.size(), Vec3::Zero())});
  return garment;
}

DressScene make_dress_scene(const Garment& garment, const TriangleMesh& body,
                            const DressConfig& config, const PhaseSettings& settings) {
  DressScene made;
  Scene& scene = made.scene;
  scene.name = "dress";
  Material fabric = stiffened(config.fabric, settings.least_bending);
  fabric.friction = std::min(fabric.friction, settings.friction);
  scene.materials[kMaterial] = fabric;
  ClothFile surface;
  surface.mesh = garment.surface;
  scene.cloths.push_back(
      {.name = kCloth, .shape = surface, .placement = {}, .material = kMaterial});
  scene.bodies.push_back(skin_spec(kBody, body, settings.friction));
  if (settings.hold_under)
    add_held_layers(garment, settings, scene);
  else
    add_layers(garment, scene);
  scene.gravity = settings.gravity;
  scene.air.viscous_drag = settings.drag;
  scene.contact.rest_gap = config.rest_gap;
  scene.solver.strain_limiter = settings.limit_strain;
  scene.contact.carry_tangled = settings.moving_fps > 0.0;
  scene.time.fps = settings.moving_fps > 0.0 ? settings.moving_fps : config.fps;
  scene.time.steps_per_frame = config.steps_per_frame;
  scene.time.energy_guard = false;  // a garment on its way loses its energy to the air
  scene.time.frames = std::numeric_limits<int>::max() / 64;
  if (settings.pull > 0.0) {
    const double reach = std::max(kLeastReach, kReach * garment.largest_opening());
    for (std::size_t s = 0; s < garment.stitches.size(); ++s) {
      const std::vector<Edge> pairs = garment.open_pairs(s);
      if (pairs.empty() || !garment.is_chosen(s, settings.seams)) continue;
      const double tension = settings.pull * garment.stitches[s].spacing;  // N, of each pair
      const double merge =
          settings.merge > 0.0 ? merge_distance(garment.stitches[s], config, settings.merge) : 0.0;
      scene.seams.push_back(seam_spec(pairs, tension, reach, merge));
    }
  }
  made.built = build_scene(scene, [&](std::size_t piece) {
    if (piece == 0) return Piece{make_cloth(garment, config, settings), garment.flat};
    return layer_piece(garment.under[piece - 1]);
  });
  made.built.velocity = garment.velocity;
  for (std::size_t k = 0; k + 1 < scene.cloths.size(); ++k)
    made.built.velocity.insert(made.built.velocity.end(), garment.under[k].v.begin(),
                               garment.under[k].v.end());
  return made;
}

std::unique_ptr<Simulation> start_simulation(DressScene& scene, const Dressing& dressing) {
  dressing.deadline.check();
  auto simulation = std::make_unique<Simulation>(with_fixed_mesh(scene.scene),
                                                 std::move(scene.built), dressing.methods);
  simulation->set_trace(&dressing.deadline.trace());
  return simulation;
}

double merge_distance(const Stitching& stitch, const DressConfig& config, double share) {
  return std::max(kLeastMerge * config.rest_gap, share * stitch.spacing);
}

std::size_t merge_closed(const DressScene& scene, const Simulation& simulation,
                         const Methods& methods, Garment& garment, DressResult& result) {
  SeamMerging merging(scene.scene, simulation.built(), methods.patterns);
  const MergeEvent event = merging.due(simulation).event;
  if (event.pairs.empty()) return 0;
  SimulationState state = simulation.state();
  take_state(simulation, garment);
  const std::set<Edge> merged(event.pairs.begin(), event.pairs.end());
  for (std::size_t s = 0; s < garment.stitches.size(); ++s)
    for (const Edge& pair : garment.open_pairs(s))
      if (merged.contains(pair))
        result.seams[s].opening_at_merge =
            std::max(result.seams[s].opening_at_merge, pair_distance(garment, pair));
  const std::vector<std::int32_t> number =
      numbers_after(garment.surface.vertices.size(), event.pairs);
  for (Triangle& t : garment.surface.triangles)
    for (std::int32_t& v : t) v = number[v];
  for (std::int32_t& v : garment.corner) v = number[v];
  merging.merge(event, state);
  take_vertices(state.x, state.v, scene.scene.cloths.size() > 1, garment);
  return event.pairs.size();
}

std::size_t move_together(const Simulation& simulation, Garment& garment, const Dressing& dressing,
                          double share) {
  const std::span<const Triangle> triangles = simulation.cloth_triangles();
  const std::vector<Vec3>& body = simulation.body_positions();
  const auto collides = [&](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    return !find_collisions(from, to, triangles).empty() ||
           !find_collisions(MovingSurface{from, to, triangles},
                            {body, body, simulation.body_triangles()})
                .empty();
  };
  take_state(simulation, garment);
  std::vector<Vec3> x(simulation.positions().begin(), simulation.positions().end());
  std::set<std::int32_t> moved;
  std::size_t tries = 0;
  for (std::size_t s = 0; s < garment.stitches.size(); ++s) {
    const double near = merge_distance(garment.stitches[s], dressing.config, share);
    for (const Edge& pair : garment.open_pairs(s)) {
      if (pair_distance(garment, pair) > near || tries == kMostMoves) continue;
      if (moved.contains(pair[0]) || moved.contains(pair[1])) continue;
      dressing.deadline.check();
      ++tries;
      for (const auto& [v, other] : {Edge{pair[0], pair[1]}, Edge{pair[1], pair[0]}}) {
        std::vector<Vec3> to = x;
        to[v] += kMoveShare * (x[other] - x[v]);
        if (collides(x, to)) continue;
        x = std::move(to);
        garment.surface.vertices[v] = x[v];
        moved.insert(pair.begin(), pair.end());
        break;
      }
    }
  }
  return moved.size() / 2;
}

double mean_height(std::span<const Vec3> x, std::span<const double> weight) {
  double sum = 0.0, total = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double w = weight.empty() ? 1.0 : weight[i];
    sum += w * x[i].z();
    total += w;
  }
  return sum / total;
}

void take_state(const Simulation& simulation, Garment& garment) {
  const bool with_under = simulation.built().piece_begin.size() > 2;
  take_vertices(simulation.positions(), simulation.velocities(), with_under, garment);
}

double garment_height(const Simulation& simulation) {
  return mean_height(of_garment(simulation, simulation.positions()),
                     of_garment(simulation, std::span<const double>(simulation.mass())));
}

double max_stretch(const Simulation& simulation, std::size_t piece) {
  const BuiltScene& built = simulation.built();
  const std::int32_t begin = built.piece_begin[piece], end = built.piece_begin[piece + 1];
  std::vector<Spring> springs;
  for (std::size_t i = 0; i < built.cloth.springs.size(); ++i) {
    const Spring& spring = built.cloth.springs[i];
    const bool is_elastic = !built.cloth.strain_limit.empty() &&
                            built.cloth.strain_limit[i] == StrainLimitOfSpring::kDefault;
    if (begin <= spring.a && spring.a < end && !is_elastic) springs.push_back(spring);
  }
  return spring_strains(springs, simulation.positions()).max;
}

void Deadline::check() const {
  if (watch_.seconds() > budget_)
    throw DressOverBudget(fmt::format("not finished within {:g} s", budget_));
}

double closed_opening(const DressConfig& config) { return kOpeningShare * config.edge_length; }

void add_run(const Simulation& simulation, const char* phase, DressResult& result) {
  const RunResult run = simulation.result();
  result.clean = result.clean && run.clean;
  result.states += run.steps;
  for (const auto& [part, s] : run.phase_s) result.seconds[std::string(phase) + "/" + part] += s;
}

}  // namespace selvedge::detail
