// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/bodies/driven_body.h>
#include <selvedge/core/base/internal/serial_loops.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/batch.h>
#include <selvedge/simulation/internal/carried.h>
#include <selvedge/simulation/internal/mesh_change.h>
#include <selvedge/simulation/run_result.h>
#include <selvedge/simulation/simulation.h>

#include <algorithm>
#include <functional>
#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

constexpr std::size_t kNobody = static_cast<std::size_t>(-1);

// A change of the mesh and the search for a way out of a tangle have more memory than a state.
bool may_share(const Scene& scene) {
  return mesh_change(scene).empty() && !scene.contact.untangle_start &&
         !scene.contact.carry_tangled;
}

}  // namespace

struct Batch::Parts {
  /// A simulation in which one member at a time makes its steps.
  struct Worker {
    std::optional<Simulation> simulation;
    std::vector<DrivenBody*> driven;
    std::size_t member = kNobody;
    bool busy = false;
  };
  /// A member; what it carries is in a worker while it has one.
  struct Member {
    std::size_t kind = 0;
    Worker* worker = nullptr;
    CarriedSimulation carried;
    std::vector<DrivenBody> driven;
  };
  /// The members of one Scene object.
  struct Kind {
    std::shared_ptr<const Scene> scene;
    std::optional<Member> start;  // none: its only member cannot be copied
    std::mutex guard;             // of the workers
    std::vector<std::unique_ptr<Worker>> workers;
  };
  /// The positions and velocities of all members.
  struct Arrays {
    std::vector<Vec3> x, v;
  };

  std::shared_ptr<const Methods> methods;
  std::vector<std::size_t> driven;
  std::vector<std::unique_ptr<Kind>> kinds;
  std::vector<Member> members;
  std::vector<std::size_t> begin;
  std::shared_ptr<Arrays> arrays;
  std::vector<std::size_t> handed_out;  // members that the program may have changed since a step

  std::vector<std::size_t> all() const {
    std::vector<std::size_t> numbers(members.size());
    std::iota(numbers.begin(), numbers.end(), std::size_t{0});
    return numbers;
  }
  void add(std::size_t number, const std::shared_ptr<const Scene>& scene);
  std::unique_ptr<Worker> make_worker(const Kind& kind, const SimulationState* state) const;
  Kind& kind_of(std::size_t member) { return *kinds[members[member].kind]; }
  void check(std::size_t member) const;
  void check(std::span<const std::size_t> chosen) const;
  Worker* claim(Kind& kind, std::size_t number);
  Worker& load(std::size_t number);
  void free(std::size_t number);
  void unload(Worker& worker);
  const SimulationState& state_of(std::size_t number) const;
  bool fits(std::size_t member) const;
  void lay_out();
  void write(std::size_t member);
  void write_handed_out();
  std::vector<MemberFailure> each(std::span<const std::size_t> chosen,
                                  const std::function<void(Simulation&)>& act);
};

std::unique_ptr<Batch::Parts::Worker> Batch::Parts::make_worker(
    const Kind& kind, const SimulationState* state) const {
  auto worker = std::make_unique<Worker>();
  BuiltScene built = build_scene(*kind.scene, *methods);
  for (const std::size_t body : driven) worker->driven.push_back(&drive_body(built, body));
  if (state == nullptr)
    worker->simulation.emplace(*kind.scene, std::move(built), *methods);
  else
    worker->simulation.emplace(*kind.scene, std::move(built), *state, *methods);
  return worker;
}

void Batch::Parts::add(std::size_t number, const std::shared_ptr<const Scene>& scene) {
  const bool shares = may_share(*scene);
  std::size_t k = 0;
  while (k < kinds.size() && !(shares && kinds[k]->scene == scene)) ++k;
  if (k < kinds.size()) {
    members.push_back(*kinds[k]->start);
    return;
  }
  kinds.push_back(std::make_unique<Kind>());
  Kind& kind = *kinds.back();
  kind.scene = scene;
  std::unique_ptr<Worker> worker = make_worker(kind, nullptr);
  members.emplace_back().kind = k;
  Member& member = members.back();
  for (const DrivenBody* body : worker->driven) member.driven.push_back(*body);
  if (shares) {
    member.carried = CarriedSimulation::out_of(*worker->simulation);
    kind.start = member;
  } else {
    worker->member = number;
    member.worker = worker.get();
  }
  kind.workers.push_back(std::move(worker));
}

void Batch::Parts::check(std::size_t member) const {
  if (member >= members.size())
    throw std::invalid_argument(
        fmt::format("there is no member {}; the batch has {}, from 0 on", member, members.size()));
}

void Batch::Parts::unload(Worker& worker) {
  if (worker.member == kNobody) return;
  Member& member = members[worker.member];
  member.carried = CarriedSimulation::out_of(*worker.simulation);
  for (std::size_t d = 0; d < driven.size(); ++d) member.driven[d] = *worker.driven[d];
  member.worker = nullptr;
  worker.member = kNobody;
}

// Under the guard of the kind: the worker that has the member, else one that is free; null: none.
Batch::Parts::Worker* Batch::Parts::claim(Kind& kind, std::size_t number) {
  Worker* worker = members[number].worker;
  for (const auto& other : kind.workers)
    if (worker == nullptr && !other->busy) worker = other.get();
  if (worker == nullptr) return nullptr;
  worker->busy = true;
  if (worker->member != number) unload(*worker);
  return worker;
}

// A scene has at most as many workers as threads step its members at once.
Batch::Parts::Worker& Batch::Parts::load(std::size_t number) {
  Member& member = members[number];
  Kind& kind = kind_of(number);
  std::unique_lock lock(kind.guard);
  Worker* worker = claim(kind, number);
  lock.unlock();
  if (worker == nullptr) {
    std::unique_ptr<Worker> made = make_worker(kind, &kind.start->carried.state());
    worker = made.get();
    worker->busy = true;
    lock.lock();
    kind.workers.push_back(std::move(made));
    lock.unlock();
  }
  if (worker->member == number) return *worker;
  for (std::size_t d = 0; d < driven.size(); ++d) *worker->driven[d] = member.driven[d];
  std::move(member.carried).put_into(*worker->simulation);
  member.carried = {};
  worker->member = number;
  member.worker = worker;
  return *worker;
}

void Batch::Parts::free(std::size_t number) {
  const std::lock_guard lock(kind_of(number).guard);
  members[number].worker->busy = false;
}

const SimulationState& Batch::Parts::state_of(std::size_t number) const {
  const Member& member = members[number];
  return member.worker != nullptr ? member.worker->simulation->state() : member.carried.state();
}

// Where a mesh has changed, all members move to other arrays.
void Batch::Parts::lay_out() {
  begin.assign(1, 0);
  for (std::size_t k = 0; k < members.size(); ++k)
    begin.push_back(begin.back() + state_of(k).x.size());
  arrays = std::make_shared<Arrays>();
  arrays->x.resize(begin.back());
  arrays->v.resize(begin.back());
  for (std::size_t k = 0; k < members.size(); ++k) write(k);
}

bool Batch::Parts::fits(std::size_t member) const {
  return state_of(member).x.size() == begin[member + 1] - begin[member];
}

void Batch::Parts::write(std::size_t member) {
  if (!fits(member)) return;
  const SimulationState& state = state_of(member);
  std::copy(state.x.begin(), state.x.end(), arrays->x.begin() + begin[member]);
  std::copy(state.v.begin(), state.v.end(), arrays->v.begin() + begin[member]);
}

void Batch::Parts::write_handed_out() {
  for (const std::size_t k : handed_out) write(k);
  if (!std::ranges::all_of(handed_out, [&](std::size_t k) { return fits(k); })) lay_out();
}

void Batch::Parts::check(std::span<const std::size_t> chosen) const {
  std::vector<char> seen(members.size(), 0);
  for (const std::size_t k : chosen) {
    check(k);
    if (std::exchange(seen[k], 1) != 0)
      throw std::invalid_argument(fmt::format("member {} is named twice; name each once", k));
  }
}

std::vector<MemberFailure> Batch::Parts::each(std::span<const std::size_t> chosen,
                                              const std::function<void(Simulation&)>& act) {
  check(chosen);
  write_handed_out();
  handed_out.clear();
  std::vector<std::optional<MemberFailure>> failed(chosen.size());
  const auto act_on = [&](std::size_t i) {
    const std::size_t k = chosen[i];
    try {
      act(*load(k).simulation);
    } catch (const SimulationFailed& error) {
      failed[i] = {k, error.kind, error.what()};
    }
    write(k);
    free(k);
  };
  const bool enough = chosen.size() >= static_cast<std::size_t>(thread_count());
  parallel_for(chosen.size(), 1, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      if (enough) {
        const SerialLoops serial;
        act_on(i);
      } else {
        run_isolated([&] { act_on(i); });
      }
    }
  });
  if (!std::ranges::all_of(chosen, [&](std::size_t k) { return fits(k); })) lay_out();
  std::vector<MemberFailure> failures;
  for (const auto& failure : failed)
    if (failure) failures.push_back(*failure);
  std::ranges::sort(failures, {}, &MemberFailure::member);
  return failures;
}

Batch::Batch(std::vector<std::shared_ptr<const Scene>> scenes, std::span<const std::size_t> driven)
    : Batch(std::move(scenes), driven, std::make_shared<const Methods>()) {}

Batch::Batch(std::vector<std::shared_ptr<const Scene>> scenes, std::span<const std::size_t> driven,
             std::shared_ptr<const Methods> methods)
    : parts_(std::make_unique<Parts>()) {
  parts_->methods = std::move(methods);
  parts_->driven.assign(driven.begin(), driven.end());
  parts_->members.reserve(scenes.size());
  for (std::size_t k = 0; k < scenes.size(); ++k) {
    try {
      parts_->add(k, scenes[k]);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("member {}: {}", k, error.what()));
    }
  }
  parts_->lay_out();
}

Batch::~Batch() = default;

std::size_t Batch::size() const { return parts_->members.size(); }

const Scene& Batch::scene(std::size_t member) const {
  parts_->check(member);
  return *parts_->kind_of(member).scene;
}

std::vector<MemberFailure> Batch::step(std::span<const std::size_t> members) {
  return parts_->each(members, [](Simulation& simulation) { simulation.step(); });
}

std::vector<MemberFailure> Batch::step() { return step(parts_->all()); }

std::vector<MemberFailure> Batch::advance(int frames, std::span<const std::size_t> members) {
  return parts_->each(members, [frames](Simulation& simulation) {
    const int begin = simulation.frame();
    for (int frame = begin + 1; frame <= begin + frames; ++frame)
      simulation.advance_to_frame(frame);
  });
}

std::vector<MemberFailure> Batch::advance(int frames) { return advance(frames, parts_->all()); }

std::span<const Vec3> Batch::positions() const {
  parts_->write_handed_out();
  return parts_->arrays->x;
}

std::span<const Vec3> Batch::velocities() const {
  parts_->write_handed_out();
  return parts_->arrays->v;
}

std::span<const std::size_t> Batch::vertex_begin() const {
  parts_->write_handed_out();
  return parts_->begin;
}

std::shared_ptr<const void> Batch::owner() const { return parts_->arrays; }

Simulation& Batch::member(std::size_t member) {
  parts_->check(member);
  Parts::Worker& worker = parts_->load(member);
  parts_->free(member);
  if (std::ranges::find(parts_->handed_out, member) == parts_->handed_out.end())
    parts_->handed_out.push_back(member);
  return *worker.simulation;
}

void Batch::move_body(std::size_t member, std::size_t body, std::span<const Vec3> x) {
  Simulation& simulation = this->member(member);
  const auto at = std::ranges::find(parts_->driven, body);
  if (at == parts_->driven.end())
    throw std::invalid_argument(
        fmt::format("body {} is not driven; name it in `driven` when you make the batch", body));
  const auto d = static_cast<std::size_t>(at - parts_->driven.begin());
  simulation.move_body(*parts_->members[member].worker->driven[d], x);
}

RunResult Batch::result(std::size_t member) { return this->member(member).result(); }

MemberState Batch::save(std::size_t member) {
  const Simulation& simulation = this->member(member);
  MemberState saved{simulation.state(), {}};
  for (const std::size_t body : parts_->driven) {
    const Body& driven = *simulation.built().bodies[body];
    std::vector<Vec3>& x = saved.bodies[body];
    x.resize(driven.vertex_count());
    driven.positions(simulation.time(), x);
  }
  return saved;
}

void Batch::restore(std::size_t member, const MemberState& state) {
  Simulation& simulation = this->member(member);
  const Parts::Worker& worker = *parts_->members[member].worker;
  if (state.bodies.size() != parts_->driven.size())
    throw std::invalid_argument(
        fmt::format("the state has {} driven bodies, the batch {}; save it from a simulation or a "
                    "batch with the same",
                    state.bodies.size(), parts_->driven.size()));
  for (const std::size_t body : parts_->driven)
    if (!state.bodies.contains(body))
      throw std::invalid_argument(fmt::format("body {} is driven, but not in the state", body));
  simulation.restore(state.state);  // refuses a state of another scene before a body moves
  if (parts_->driven.empty()) return;
  for (std::size_t d = 0; d < parts_->driven.size(); ++d)
    worker.driven[d]->place(state.bodies.at(parts_->driven[d]), state.state.time);
  simulation.restore(state.state);
}

void Batch::reset(std::size_t member) {
  parts_->check(member);
  Parts::Kind& kind = parts_->kind_of(member);
  Parts::Member& own = parts_->members[member];
  if (kind.start) {
    if (own.worker != nullptr) parts_->unload(*own.worker);
    own = *kind.start;
  } else {
    kind.workers[0] = parts_->make_worker(kind, nullptr);
    kind.workers[0]->member = member;
    own.worker = kind.workers[0].get();
  }
  parts_->write(member);
  if (!parts_->fits(member)) parts_->lay_out();
}

}  // namespace selvedge
