// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/internal/adaptive_cloth.h>
#include <selvedge/simulation/detail/refinement.h>
#include <selvedge/simulation/internal/mesh_change.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge::detail {
namespace {

void refuse_what_needs_one_mesh(const Scene& scene, const BuiltScene& built,
                                const std::string& piece) {
  const char* fault = nullptr;
  if (scene.water) fault = "\"water\" wets the vertices that there are; leave one of them out";
  if (scene.contact.untangle_start)
    fault = "contact.start \"untangle\" counts on its triangles; untangle it in a run of its own";
  if (scene.contact.carry_tangled)
    fault = "contact.still_tangled \"carry\" counts on its triangles; leave one of them out";
  if (!built.cloth.layers.empty())
    fault = "the layers of a bilayered cloth need one that stays; leave one of them out";
  if (fault != nullptr)
    throw std::invalid_argument(
        fmt::format("cloth \"{}\": \"refine\" changes the mesh, but {}", piece, fault));
}

double kinetic_energy(const std::vector<double>& mass, std::span<const Vec3> v) {
  double sum = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) sum += 0.5 * mass[i] * v[i].squaredNorm();
  return sum;
}

}  // namespace

Refinement::Refinement(const Scene& scene, const BuiltScene& built, ClothPatternRegistry patterns)
    : scene_(&scene), patterns_(std::move(patterns)), merging_(scene, built, patterns_) {
  for (std::size_t p = 0; p < scene.cloths.size(); ++p) {
    const auto first = built.piece_begin[p], end = built.piece_begin[p + 1];
    sizes_.push_back(static_cast<std::size_t>(end - first));
    const ClothSpec& cloth = scene.cloths[p];
    const RefineSpec* spec = refine_of(cloth);
    if (spec == nullptr) continue;
    refuse_what_needs_one_mesh(scene, built, cloth.name);
    const std::vector<Vec3>& x = built.cloth.surface.vertices;
    AdaptiveCloth cells = make_adaptive_cloth(cloth, scene.materials.at(cloth.material), patterns_);
    std::vector<double> mass = cells.cloth().mass;
    pieces_.push_back(
        {p, *spec, std::move(cells), {x.begin() + first, x.begin() + end}, std::move(mass), 0.0});
  }
}

std::size_t Refinement::begin(std::size_t number) const {
  std::size_t first = 0;
  for (std::size_t p = 0; p < number; ++p) first += sizes_[p];
  return first;
}

const Refinement::Piece& Refinement::piece(std::int32_t number) const {
  for (const Piece& p : pieces_)
    if (static_cast<std::int32_t>(p.number) == number) return p;
  throw std::invalid_argument(
      fmt::format("piece {} of the scene is not one that is refined", number));
}

Refinement::Piece& Refinement::piece(std::int32_t number) {
  return const_cast<Piece&>(std::as_const(*this).piece(number));
}

std::vector<GridCell> Refinement::due(const Piece& piece, std::span<const Vec3> x,
                                      std::span<const Vec3> v, double time) const {
  const RefineSpec& spec = piece.spec;
  if (spec.when == RefineSpec::When::curved) return piece.cells.curved(x, spec.angle());
  if (time < piece.last + spec.after) return {};
  const bool slow =
      std::all_of(v.begin(), v.end(), [&](const Vec3& u) { return u.norm() <= spec.speed; });
  if (!slow && kinetic_energy(piece.mass, v) >= spec.energy) return {};
  return piece.cells.divisible();
}

std::vector<SplitEvent> Refinement::due(const SimulationState& state) const {
  std::vector<SplitEvent> events;
  for (const Piece& p : pieces_) {
    const std::size_t first = begin(p.number), n = sizes_[p.number];
    std::vector<GridCell> cells = due(p, std::span(state.x).subspan(first, n),
                                      std::span(state.v).subspan(first, n), state.time);
    if (!cells.empty())
      events.push_back({static_cast<std::int32_t>(p.number), state.time, std::move(cells)});
  }
  return events;
}

void Refinement::split(const SplitEvent& event, std::vector<Vec3>& x, std::vector<Vec3>& v) {
  Piece& p = piece(event.piece);
  if (event.join) {
    const std::vector<std::int32_t> number = p.cells.join(event.cells, x, v);
    std::vector<Vec3> start(x.size());
    for (std::size_t i = 0; i < number.size(); ++i)
      if (number[i] >= 0) start[number[i]] = p.start[i];
    p.start = std::move(start);
  } else {
    const std::int32_t before = p.cells.vertex_count();
    p.cells.split(event.cells, x, v);
    for (std::int32_t i = before; i < p.cells.vertex_count(); ++i) {
      const auto [a, b] = p.cells.parents(i);
      p.start.push_back(0.5 * (p.start[a] + p.start[b]));
    }
  }
  p.mass = p.cells.cloth().mass;
  p.last = event.time;
  sizes_[p.number] = p.start.size();
}

void Refinement::split(const std::vector<SplitEvent>& events) {
  for (const SplitEvent& event : events) {
    std::vector<Vec3> x = piece(event.piece).start, v(x.size(), Vec3::Zero());
    split(event, x, v);
  }
}

void Refinement::split(const std::vector<SplitEvent>& events, SimulationState& state) {
  for (const SplitEvent& event : events) {
    const auto first = static_cast<std::ptrdiff_t>(begin(static_cast<std::size_t>(event.piece)));
    const auto end = first + static_cast<std::ptrdiff_t>(sizes_[event.piece]);
    const auto of_piece = [&](const std::vector<Vec3>& all) {
      return std::vector<Vec3>(all.begin() + first, all.begin() + end);
    };
    std::vector<Vec3> x = of_piece(state.x), v = of_piece(state.v);
    split(event, x, v);
    const auto put = [&](std::vector<Vec3>& all, const std::vector<Vec3>& part) {
      all.erase(all.begin() + first, all.begin() + end);
      all.insert(all.begin() + first, part.begin(), part.end());
    };
    put(state.x, x);
    put(state.v, v);
    state.splits.push_back(event);
  }
}

void Refinement::repeat(const SimulationState& state) {
  split(state.splits);
  for (const MergeEvent& event : state.merges) merging_.merge(event);
}

Scene Refinement::scene() const {
  if (merging_.active()) return merging_.scene();
  Scene scene = with_fixed_mesh(*scene_);
  for (HandleSpec& handle : scene.handles)
    for (const Piece& p : pieces_) {
      if (scene.cloths[p.number].name != handle.geometry) continue;
      handle.pivots = handle.vertices.size();
      std::set<std::int32_t> held(handle.vertices.begin(), handle.vertices.end());
      for (std::int32_t i = 0; i < p.cells.vertex_count(); ++i) {
        const auto [a, b] = p.cells.parents(i);
        if (!held.contains(a) || !held.contains(b)) continue;
        held.insert(i);
        handle.vertices.push_back(i);
      }
    }
  return scene;
}

BuiltScene Refinement::build() const {
  if (merging_.active()) return merging_.build();
  return build_scene(*scene_, [&](std::size_t number) -> selvedge::Piece {
    for (const Piece& p : pieces_) {
      if (p.number != number) continue;
      selvedge::Piece piece{p.cells.cloth(), p.cells.rest()};
      piece.cloth.surface.vertices = p.start;
      return piece;
    }
    const ClothSpec& cloth = scene_->cloths[number];
    return make_piece(cloth, scene_->materials.at(cloth.material), patterns_);
  });
}

}  // namespace selvedge::detail
