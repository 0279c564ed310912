// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/scene/adaptive_cloth.h>
#include <selvedge/simulation/refinement.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

namespace selvedge {
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

std::string mesh_change(const Scene& scene) {
  for (const ClothSpec& cloth : scene.cloths)
    if (refine_of(cloth) != nullptr) return fmt::format("cloth \"{}\": \"refine\"", cloth.name);
  for (const SeamSpec& seam : scene.seams)
    if (seam.merge != 0.0) return fmt::format("seam \"{}\": \"merge\"", seam.name);
  return "";
}

Scene with_fixed_mesh(Scene scene) {
  for (ClothSpec& cloth : scene.cloths)
    std::visit([](auto& shape) { shape.refine = {}; }, cloth.shape);
  for (SeamSpec& seam : scene.seams) seam.merge = 0.0;
  return scene;
}

Refinement::Refinement(const Scene& scene, const BuiltScene& built, ClothPatternRegistry patterns)
    : scene_(scene), patterns_(std::move(patterns)), merging_(scene, built, patterns_) {
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
  if (spec.when == RefineSpec::When::curved) return piece.cells.curved(x, spec.angle);
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

std::unique_ptr<Simulation> Refinement::restored(const SimulationState& state,
                                                 const Methods& methods) {
  split(state.splits);
  for (const MergeEvent& event : state.merges) merging_.merge(event);
  return std::make_unique<Simulation>(scene(), build(), state, methods);
}

Scene Refinement::scene() const {
  if (merging_.active()) return merging_.scene();
  Scene scene = with_fixed_mesh(scene_);
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
  return build_scene(scene_, [&](std::size_t number) -> selvedge::Piece {
    for (const Piece& p : pieces_) {
      if (p.number != number) continue;
      selvedge::Piece piece{p.cells.cloth(), p.cells.rest()};
      piece.cloth.surface.vertices = p.start;
      return piece;
    }
    const ClothSpec& cloth = scene_.cloths[number];
    return make_piece(cloth, scene_.materials.at(cloth.material), patterns_);
  });
}

bool RefinedSimulation::settle(RunResult& r) const {
  const bool clean = simulation != nullptr && simulation->result().clean;
  const double late = postponed + (simulation != nullptr && !clean ? count : 0.0);
  if (clean) r.counters[counter] += count;
  if (late > 0.0) r.counters[counter + "_postponed"] += late;
  return clean;
}

namespace {

std::optional<RefinedSimulation> merge_due(const Refinement& refinement,
                                           const Simulation& simulation, const Methods& methods) {
  const SeamMerging::Due due = refinement.merging().due(simulation);
  const auto merged = static_cast<double>(due.event.pairs.size());
  if (merged + static_cast<double>(due.postponed) == 0.0) return std::nullopt;
  RefinedSimulation next{refinement, nullptr, "merged_pairs", merged,
                         static_cast<double>(due.postponed)};
  if (due.event.pairs.empty()) return next;
  SimulationState state = simulation.state();
  next.refinement.merge(due.event, state);
  ++state.step;
  state.memory.clear();  // integrators of several steps and friction start anew
  state.contact_memory.clear();
  state.pinches.clear();  // found again in the next step
  state.still = 0.0;
  next.simulation = std::make_unique<Simulation>(next.refinement.scene(), next.refinement.build(),
                                                 std::move(state), methods);
  next.simulation->verify_frame();
  return next;
}

void apply(const std::vector<SplitEvent>& events, const Simulation& simulation,
           const Methods& methods, RefinedSimulation& next) {
  SimulationState state = simulation.state();
  next.refinement.split(events, state);
  ++state.step;
  state.pinches.clear();  // found again in the next step
  state.still = 0.0;
  next.simulation =
      std::make_unique<Simulation>(next.refinement.scene(), next.refinement.build(), methods);
  state.memory = next.simulation->state().memory;  // integrators of several steps start anew
  state.contact_memory.clear();
  next.simulation->restore(std::move(state));
  next.simulation->verify_frame();
}

}  // namespace

std::optional<RefinedSimulation> split_due(const Refinement& refinement,
                                           const Simulation& simulation, const Methods& methods) {
  if (refinement.merging().active()) return merge_due(refinement, simulation, methods);
  if (!refinement.active()) return std::nullopt;
  const std::vector<SplitEvent> events = refinement.due(simulation.state());
  if (events.empty()) return std::nullopt;
  RefinedSimulation next{refinement, nullptr, "refinements"};
  apply(events, simulation, methods, next);
  return next;
}

std::optional<RefinedSimulation> join_due(const Refinement& refinement,
                                          const Simulation& simulation, const Methods& methods) {
  const Refinement::Joins joins = refinement.joins_due(simulation);
  double cells = 0.0;
  for (const SplitEvent& event : joins.events) cells += static_cast<double>(event.cells.size());
  if (cells + static_cast<double>(joins.postponed) == 0.0) return std::nullopt;
  RefinedSimulation next{refinement, nullptr, "joined_cells", cells,
                         static_cast<double>(joins.postponed)};
  if (!joins.events.empty()) apply(joins.events, simulation, methods, next);
  return next;
}

RefiningSimulation::RefiningSimulation(const Scene& scene, BuiltScene built, const Methods& methods)
    : methods_(methods), start_(built.cloth.surface.vertices) {
  refinement_.emplace(scene, built, methods.patterns);
  simulation_ = std::make_shared<Simulation>(with_fixed_mesh(scene), std::move(built), methods);
}

RefiningSimulation::RefiningSimulation(const Scene& scene, BuiltScene built, SimulationState state,
                                       const Methods& methods)
    : methods_(methods), start_(built.cloth.surface.vertices) {
  refinement_.emplace(scene, built, methods.patterns);
  was_changed_ = !state.splits.empty() || !state.merges.empty();
  simulation_ = was_changed_
                    ? refinement_->restored(state, methods)
                    : std::make_shared<Simulation>(with_fixed_mesh(scene), std::move(built),
                                                   std::move(state), methods);
}

void RefiningSimulation::begin_frame(const Exchange& exchange) {
  if (!changes_mesh() || frame_has_begun() || !simulation_->is_at_frame()) return;
  begun_ = simulation_->frame();
  change(split_due(*refinement_, *simulation_, methods_), exchange);
  change(join_due(*refinement_, *simulation_, methods_), exchange);
}

void RefiningSimulation::change(std::optional<RefinedSimulation> next, const Exchange& exchange) {
  if (!next) return;
  RunResult before = result();
  if (!next->settle(before)) {
    (void)next->settle(before_);
    return;
  }
  if (exchange.before) exchange.before();
  before_ = std::move(before);
  refinement_.emplace(std::move(next->refinement));
  simulation_ = std::move(next->simulation);
  simulation_->continue_sums(before_);
  was_changed_ = true;
  if (exchange.after) exchange.after();
}

void RefiningSimulation::step() {
  begin_frame();
  simulation_->step();
}

bool RefiningSimulation::step_towards(int frame) {
  if (simulation_->reached(frame)) return false;
  step();
  return true;
}

void RefiningSimulation::advance_to_frame(int frame, const std::function<void(double)>& accepted) {
  if (simulation_->reached(frame)) return simulation_->verify_frame();
  while (!simulation_->reached(frame)) {
    begin_frame();
    simulation_->advance_to_frame(simulation_->frame() + 1, accepted);
  }
}

void RefiningSimulation::restore(SimulationState state, bool has_begun, RunResult before) {
  if (state.splits.empty() && state.merges.empty()) {
    simulation_->restore(std::move(state));
  } else {
    simulation_ = refinement_->restored(state, methods_);
    was_changed_ = true;
  }
  begun_ = has_begun ? simulation_->frame() : -1;
  before_ = std::move(before);
  simulation_->continue_sums(before_);
}

std::vector<Vec3> RefiningSimulation::start() const {
  return was_changed_ ? refinement_->build().cloth.surface.vertices : start_;
}

RunResult RefiningSimulation::result() const {
  RunResult r = simulation_->result();
  carry_on(before_, r);
  r.steps = static_cast<int>(simulation_->state().step);
  return r;
}

}  // namespace selvedge
