// SPDX-License-Identifier: MIT
//
// A step of the leaders alone, from which the followers are eliminated: x = P y is a constraint of
// the solve, which holds exactly, and not a stiff force. The reduced system has the matrix
// Pᵀ (M + h D + h² K) P; its preconditioner is built from it. The mass is lumped, the row sums of
// Pᵀ M P: momentum, the centre of mass and the weight are those of M, moments of inertia differ by
// O(cell²). Contacts name all particles; see TermOperator.
//
// The two layers of a bilayered cloth [KangCho2002; survey 2.4] share this: the solve has the
// sparse layer alone, with its internal forces and with all forces from outside. The dense layer is
// carried along, P y, and then makes one local iteration of [KangChoiCho2000] under its own
// internal forces and springs to P y, so that x = P y + d. Contacts of the dense layer act on P y,
// with d fixed.
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/solver/integrator.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace selvedge {
namespace {

constexpr std::size_t kPartGrain = 2048;

/// Pᵀ f(P y) for the sum f of some forces, which belong to others.
class FollowedForces final : public Force {
 public:
  /// `couples`: the matrix has the blocks by which a follower couples its leaders.
  FollowedForces(const Followers& followers, std::vector<Force*> forces, bool couples)
      : followers_(followers),
        forces_(std::move(forces)),
        couples_(couples),
        x_(followers.particles()),
        v_(x_),
        f_(x_) {}

  void add_force(const ForceState& state, std::span<Vec3> f) const override {
    const ForceState all = spread(state);
    std::fill(f_.begin(), f_.end(), Vec3::Zero());
    for (const Force* force : forces_) force->add_force(all, f_);
    followers_.gather(std::span<const Vec3>(f_), f);
  }
  double energy(const ForceState& state) const override {
    const ForceState all = spread(state);
    double sum = 0.0;
    for (const Force* force : forces_) sum += force->energy(all);
    return sum;
  }
  void add_links(std::vector<Edge>& links) const override;
  void bind(const BlockMatrix& matrix) override;
  void add_jacobian(const ForceState& state, double h, BlockMatrix& a) const override;
  // A row of Pᵀ K P is at most the sum of the rows of K with their weights, as P has the row
  // sums 1.
  void add_stiffness_bound(const ForceState& state, std::span<double> stiffness,
                           std::span<double> damping) const override {
    const ForceState all = spread(state);
    std::vector<double> k(followers_.particles(), 0.0), d(k);
    for (const Force* force : forces_) force->add_stiffness_bound(all, k, d);
    followers_.gather(std::span<const double>(k), stiffness);
    followers_.gather(std::span<const double>(d), damping);
  }
  void add_ties(const ForceState& state, std::span<double> stiffness) const override {
    const ForceState all = spread(state);
    std::vector<double> k(followers_.particles(), 0.0);
    for (const Force* force : forces_) force->add_ties(all, k);
    followers_.gather(std::span<const double>(k), stiffness);
  }

 private:
  struct Part {
    std::int32_t from;  // block of all_
    double weight;
  };
  /// The state of all particles. Their masses are those at the start of the step.
  ForceState spread(const ForceState& state) const {
    followers_.spread(state.x, x_);
    followers_.spread(state.v, v_);
    return {x_, v_, masses_.of(followers_, state.mass), state.time};
  }
  /// Masses of all particles such that their weight, gathered, is that of the lumped masses.
  struct Masses {
    std::vector<double> all;
    std::span<const double> of(const Followers& followers, std::span<const double> lumped) {
      all.assign(followers.particles(), 0.0);
      for (std::size_t l = 0; l < lumped.size(); ++l) all[followers.leaders()[l]] = lumped[l];
      return all;
    }
  };

  const Followers& followers_;
  std::vector<Force*> forces_;
  bool couples_;
  mutable BlockMatrix all_;                // of all particles
  std::vector<std::int32_t> target_;       // blocks of the reduced matrix, ascending
  std::vector<std::size_t> target_begin_;  // parts of each
  std::vector<Part> parts_;
  mutable Masses masses_;
  mutable std::vector<Vec3> x_, v_, f_;
};

void FollowedForces::add_links(std::vector<Edge>& links) const {
  std::vector<Edge> all;
  for (const Force* force : forces_) force->add_links(all);
  if (couples_)
    for (const std::int32_t i : followers_.nodes()) all.push_back({i, i});
  for (const Edge& link : all)
    for (const Followers::Share& a : followers_.shares(link[0]))
      for (const Followers::Share& b : followers_.shares(link[1]))
        if (a.leader != b.leader) links.push_back({a.leader, b.leader});
}

void FollowedForces::bind(const BlockMatrix& matrix) {
  std::vector<Edge> links;
  for (const Force* force : forces_) force->add_links(links);
  all_ = BlockMatrix(followers_.particles(), std::move(links));
  for (Force* force : forces_) force->bind(all_);
  std::vector<std::pair<std::int32_t, Part>> parts;
  for (std::size_t i = 0; i < all_.size(); ++i)
    for (std::int32_t k = all_.row_begin()[i]; k < all_.row_begin()[i + 1]; ++k)
      for (const Followers::Share& a : followers_.shares(i))
        for (const Followers::Share& b : followers_.shares(all_.columns()[k]))
          parts.push_back({matrix.slot(a.leader, b.leader), {k, a.weight * b.weight}});
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  target_.clear();
  target_begin_.clear();
  parts_.clear();
  for (const auto& [target, part] : parts) {
    if (target_.empty() || target_.back() != target) {
      target_.push_back(target);
      target_begin_.push_back(parts_.size());
    }
    parts_.push_back(part);
  }
  target_begin_.push_back(parts_.size());
}

void FollowedForces::add_jacobian(const ForceState& state, double h, BlockMatrix& a) const {
  all_.set_zero();
  const ForceState all = spread(state);
  for (const Force* force : forces_) force->add_jacobian(all, h, all_);
  const std::span<const Mat3> from = std::as_const(all_).values();
  const std::span<Mat3> to = a.values();
  parallel_for(target_.size(), kPartGrain, [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t)
      for (std::size_t k = target_begin_[t]; k < target_begin_[t + 1]; ++k)
        to[target_[t]] += parts_[k].weight * from[parts_[k].from];
  });
}

/// The forces as forces on the leaders: those that couple particles, and those from outside, which
/// stay so.
std::vector<std::unique_ptr<Force>> followed(const Followers& followers, const ForceSum& forces) {
  std::vector<Force*> inside, outside;
  for (const auto& force : forces.members()) {
    std::vector<Edge> links;
    force->add_links(links);
    (links.empty() ? outside : inside).push_back(force.get());
  }
  std::vector<std::unique_ptr<Force>> all;
  all.push_back(std::make_unique<FollowedForces>(followers, std::move(inside), true));
  if (!outside.empty())
    all.push_back(std::make_unique<FollowedForces>(followers, std::move(outside), false));
  return all;
}

/// The leaders of `all`, with the row sums of Pᵀ M P as masses.
Particles lead(const Followers& followers, const Particles& all) {
  const std::span<const std::int32_t> leaders = followers.leaders();
  Particles own{followers.select(all.x), followers.select(all.v),
                std::vector<double>(leaders.size(), 0.0), std::vector<double>(leaders.size(), 0.0),
                &followers};
  followers.gather(std::span<const double>(all.mass), std::span(own.mass));
  for (std::size_t l = 0; l < leaders.size(); ++l)
    if (all.inv_mass[leaders[l]] > 0.0) own.inv_mass[l] = 1.0 / own.mass[l];
  return own;
}

/// The leaders that move these particles.
std::vector<std::int32_t> lead(const Followers& followers, std::span<const std::int32_t> all) {
  std::vector<std::int32_t> own;
  for (const std::int32_t i : all)
    for (const Followers::Share& s : followers.shares(i)) own.push_back(s.leader);
  return own;
}

void save_part(const Integrator& part, std::vector<double>& memory) {
  std::vector<double> own;
  part.save_memory(own);
  memory.push_back(static_cast<double>(own.size()));
  memory.insert(memory.end(), own.begin(), own.end());
}

/// Returns the rest of `memory`.
std::span<const double> restore_part(Integrator& part, std::span<const double> memory) {
  const double size = memory.empty() ? 0.0 : memory[0];
  if (!(size >= 0.0 && size < static_cast<double>(memory.size())))
    throw std::invalid_argument("the memory of the integrator belongs to another scene");
  const auto own = static_cast<std::size_t>(size);
  part.restore_memory(memory.subspan(1, own));
  return memory.subspan(1 + own);
}

class Following final : public Integrator {
 public:
  Following(const Followers& followers, std::vector<std::unique_ptr<Force>> forces,
            const MakeIntegrator& make)
      : Integrator(std::move(forces), followers.particles()),
        followers_(followers),
        leaders_(make(followed(followers_, forces_), followers_.leaders().size())) {}

  IntegratorTraits traits() const override { return leaders_->traits(); }
  double stable_step(const ModeBound& mode, double wanted) const override {
    return leaders_->stable_step(mode, wanted);
  }
  double stable_step(const Particles& particles, double time, double wanted) override {
    particles_ = lead(followers_, particles);
    return leaders_->stable_step(particles_, time, wanted);
  }
  void begin(const StepStart& start, StepEnd end) override;
  // Contacts of cloth with followers do without; those of rigid bodies carry what pushes the body.
  std::span<const Vec3> unbalanced(std::span<const Vec3> mean) override {
    if (!followers_.has_rigid()) return {};
    const std::vector<Vec3> own = followers_.select(mean);
    const std::span<const Vec3> rest = leaders_->unbalanced(own);
    if (rest.empty()) return {};
    unbalanced_.assign(followers_.particles(), Vec3::Zero());
    for (std::size_t l = 0; l < rest.size(); ++l) unbalanced_[followers_.leaders()[l]] = rest[l];
    return unbalanced_;
  }
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override {
    const StepEnd own = select(end);
    const SolveReport report = leaders_->solve(terms, own, looser);
    spread(own, end);
    return report;
  }
  std::map<std::string, double> counters() const override { return leaders_->counters(); }

 private:
  StepEnd select(StepEnd end) {
    mean_ = followers_.select(end.mean);
    v_ = end.v.empty() ? std::vector<Vec3>(mean_.size()) : followers_.select(end.v);
    return {mean_, v_};
  }
  void spread(StepEnd own, StepEnd end) const {
    followers_.spread(own.mean, end.mean);
    if (!traits().ends_with_mean) followers_.spread(own.v, end.v);
  }
  // The memory of the forces is that of all particles.
  void remember(const ForceState& end) override {
    v_ = followers_.select(end.v);
    leaders_->accept({{}, v_, {}, end.time});
  }
  void save_history(std::vector<double>& memory) const override { save_part(*leaders_, memory); }
  std::span<const double> restore_history(std::span<const double> memory) override {
    return restore_part(*leaders_, memory);
  }

  Followers followers_;
  std::vector<Vec3> unbalanced_;  // N·s, of all particles
  std::unique_ptr<Integrator> leaders_;
  Particles particles_;  // the leaders at the start of the step
  std::vector<Vec3> mean_, v_;
  std::vector<std::int32_t> touched_;
};

void Following::begin(const StepStart& start, StepEnd end) {
  particles_ = lead(followers_, start.particles);
  touched_ = lead(followers_, start.touched_particles);
  if (end.mean.empty()) {  // an implicit step that `solve` ends
    leaders_->begin({particles_, start.time, start.h, start.touched, touched_}, {});
    return;
  }
  const StepEnd own = select(end);
  leaders_->begin({particles_, start.time, start.h, start.touched, touched_}, own);
  spread(own, end);
}

/// The layers of a cloth: a sparse one, which carries, leads a dense one.
class Layered final : public Integrator {
 public:
  Layered(const Followers& layers, std::vector<std::unique_ptr<Force>> forces,
          std::vector<std::unique_ptr<Force>> local, const MakeIntegrator& make)
      : Integrator(std::move(forces), layers.particles()),
        layers_(layers),
        sparse_(make(followed(layers_, forces_), layers_.leaders().size())),
        dense_(integrators().at("implicit_kang_as_printed")(std::move(local), layers_.particles(),
                                                            ImplicitConfig{})),
        offset_(layers_.particles(), Vec3::Zero()) {}

  IntegratorTraits traits() const override { return sparse_->traits(); }
  double stable_step(const ModeBound& mode, double wanted) const override {
    return sparse_->stable_step(mode, wanted);
  }
  double stable_step(const Particles& particles, double time, double wanted) override {
    own_ = lead(layers_, particles);
    return sparse_->stable_step(own_, time, wanted);
  }
  void begin(const StepStart& start, StepEnd end) override;
  SolveReport solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) override;
  std::map<std::string, double> counters() const override { return sparse_->counters(); }

 private:
  void relax(const StepStart& start, std::span<const Vec3> prescribed);
  void spread(StepEnd end) const;
  void remember(const ForceState& end) override {
    v_ = layers_.select(end.v);
    sparse_->accept({{}, v_, {}, end.time});
  }
  void save_history(std::vector<double>& memory) const override {
    save_part(*sparse_, memory);
    save_part(*dense_, memory);
  }
  std::span<const double> restore_history(std::span<const double> memory) override {
    return restore_part(*dense_, restore_part(*sparse_, memory));
  }

  Followers layers_;
  std::unique_ptr<Integrator> sparse_, dense_;
  Particles own_, all_;  // the leaders and all particles at the start of the step
  std::vector<Vec3> mean_, v_, all_mean_, all_v_;
  std::vector<Vec3> offset_;  // m/s, of the dense layer from P y
  SolveReport first_;         // of the solve without contacts, until the next one reports it
  std::vector<ImplicitTerm> terms_;
  std::vector<std::int32_t> touched_;
};

void Layered::begin(const StepStart& start, StepEnd end) {
  own_ = lead(layers_, start.particles);
  touched_ = lead(layers_, start.touched_particles);
  mean_ = layers_.select(end.mean);
  v_ = layers_.select(end.v);
  sparse_->begin({own_, start.time, start.h, start.touched, touched_}, {mean_, v_});
  first_ = traits().is_implicit ? sparse_->solve({}, {mean_, v_}, 1.0) : SolveReport{};
  relax(start, end.mean);
  spread(end);
}

/// One local iteration of the dense layer, from where P y carries it, in the frame that moves with
/// P y; the sparse layer is held.
void Layered::relax(const StepStart& start, std::span<const Vec3> prescribed) {
  const std::size_t n = layers_.particles();
  std::vector<Vec3> carried(n), before(n);
  layers_.spread(mean_, carried);
  layers_.spread(own_.v, before);
  all_ = start.particles;
  all_mean_.assign(n, Vec3::Zero());
  all_v_.assign(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    all_.x[i] += start.h * carried[i];
    all_.v[i] -= before[i];
  }
  for (const std::int32_t i : layers_.leaders()) all_.inv_mass[i] = 0.0;
  for (const std::int32_t i : layers_.nodes())
    if (all_.inv_mass[i] <= 0.0) all_mean_[i] = prescribed[i] - carried[i];
  dense_->begin({all_, start.time, start.h}, {all_mean_, all_v_});
  for (const std::int32_t i : layers_.nodes()) offset_[i] = all_mean_[i];
}

/// v = P y + offset.
void Layered::spread(StepEnd end) const {
  const auto put = [&](std::span<const Vec3> y, std::span<Vec3> v) {
    layers_.spread(y, v);
    for (const std::int32_t i : layers_.nodes()) v[i] += offset_[i];
  };
  put(mean_, end.mean);
  if (!traits().ends_with_mean) put(v_, end.v);
}

// A term M Σ w v = rhs of dense particles, in y: M Σ w P y = rhs - M Σ w offset.
SolveReport Layered::solve(std::span<const ImplicitTerm> terms, StepEnd end, double looser) {
  terms_.assign(terms.begin(), terms.end());
  for (ImplicitTerm& t : terms_) {
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 4; ++k)
      if (t.particle[k] >= 0) sum += t.weight[k] * offset_[t.particle[k]];
    t.rhs -= t.matrix * sum;
  }
  mean_ = layers_.select(end.mean);
  v_ = layers_.select(end.v);
  SolveReport report = sparse_->solve(terms_, {mean_, v_}, looser);
  report.iterations += first_.iterations;
  report.bytes += first_.bytes;
  first_ = {};
  spread(end);
  return report;
}

}  // namespace

std::unique_ptr<Integrator> make_following(const Followers& followers,
                                           std::vector<std::unique_ptr<Force>> forces,
                                           const MakeIntegrator& make) {
  return std::make_unique<Following>(followers, std::move(forces), make);
}

std::unique_ptr<Integrator> make_layered(const Followers& layers,
                                         std::vector<std::unique_ptr<Force>> forces,
                                         std::vector<std::unique_ptr<Force>> local,
                                         const MakeIntegrator& make) {
  return std::make_unique<Layered>(layers, std::move(forces), std::move(local), make);
}

}  // namespace selvedge
