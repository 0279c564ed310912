// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/simulation/detail/rest.h>
#include <selvedge/simulation/detail/simulation_parts.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace selvedge {
namespace detail {
namespace {

constexpr double kGravity = 9.81;  // m/s², by which forces are measured

// A contact within this share of its rest gap presses: more than the rounding of a solve.
constexpr double kTouch = 0.02;

// Most sweeps over the contacts. They end where ten of them take away less than this share.
constexpr int kSweeps = 400, kTogether = 10;
constexpr double kGains = 0.02;

/// A contact as it acts on the particles that move by themselves.
struct Touch {
  std::size_t begin, end;  // of the parts
  Vec3 normal;
  double friction;
  Vec3 force;       // N, on the first primitive
  double yielding;  // 1/kg: Σ weight² / mass
};

struct TouchPart {
  std::int32_t particle;
  double weight;
};

// Over-relaxation of the limiter's forces, which pass from spring to spring through the cloth.
constexpr double kOver = 1.7;

/// A strain at its limit as it acts on the particles that move by themselves.
struct Pull {
  std::size_t begin, end;  // of the parts
  double force = 0.0;      // >= 0
  double yielding = 0.0;   // Σ pull² / mass
};

struct PullPart {
  std::int32_t particle;
  Vec3 pull;
};

/// The nearest force of a friction cone.
Vec3 in_cone(const Vec3& force, const Vec3& normal, double friction) {
  const double push = normal.dot(force);
  const Vec3 across = force - push * normal;
  const double side = across.norm();
  if (push >= 0.0 && side <= friction * push) return force;
  if (push + friction * side <= 0.0) return Vec3::Zero();
  const double load = (push + friction * side) / (1.0 + friction * friction);
  return load * normal + (side > 0.0 ? Vec3(friction * load / side * across) : Vec3(Vec3::Zero()));
}

class Balance {
 public:
  explicit Balance(const ForcesAtRest& f) {
    followers_ = f.followers;
    if (followers_ != nullptr) {
      const std::size_t n = followers_->leaders().size();
      left_.assign(n, Vec3::Zero());
      mass_.assign(n, 0.0);
      followers_->gather(f.force, std::span(left_));
      followers_->gather(f.mass, std::span(mass_));
      for (const std::int32_t i : followers_->leaders()) free_.push_back(f.inv_mass[i] > 0.0);
    } else {
      left_.assign(f.force.begin(), f.force.end());
      mass_.assign(f.mass.begin(), f.mass.end());
      for (const double inverse : f.inv_mass.first(f.mass.size())) free_.push_back(inverse > 0.0);
    }
    for (const StepContact& c : f.near)
      if (c.gap <= (1.0 + kTouch) * c.point.rest_gap) add(c, f.step);
    for (const HeldStrain& held : f.held) add(held);
  }

  double sweep_down_to(double enough) {
    double share = measure();
    const bool any = !touches_.empty() || !pulls_.empty();
    for (int sweep = 0; sweep < kSweeps && share > enough && any;) {
      for (int k = 0; k < kTogether; ++k, ++sweep) {
        for (Touch& touch : touches_) relax(touch);
        for (Pull& pull : pulls_) relax(pull);
      }
      const double before = std::exchange(share, measure());
      if (!(share < (1.0 - kGains) * before)) break;
    }
    return share;
  }

 private:
  void add(const StepContact& c, double step) {
    Touch touch{parts_.size(),
                parts_.size(),
                c.point.normal,
                c.point.friction,
                in_cone(c.impulse / step, c.point.normal, c.point.friction),
                0.0};
    for (std::size_t k = 0; k < 4; ++k) add_part(c.point.vertex[k], c.point.weight[k]);
    touch.end = parts_.size();
    for (const TouchPart& part : std::span(parts_).subspan(touch.begin))
      touch.yielding += part.weight * part.weight / mass_[part.particle];
    if (!(touch.yielding > 0.0)) {
      parts_.resize(touch.begin);
      return;
    }
    apply(touch, touch.force);
    touches_.push_back(touch);
  }

  void add(const HeldStrain& held) {
    Pull pull{.begin = pull_parts_.size(), .end = 0};
    for (int k = 0; k < held.count; ++k)
      share_out(held.v[k], 1.0, [&](std::int32_t i, double weight) {
        pull_parts_.push_back({i, weight * held.pull[k]});
        pull.yielding += pull_parts_.back().pull.squaredNorm() / mass_[i];
      });
    pull.end = pull_parts_.size();
    if (pull.yielding > 0.0)
      pulls_.push_back(pull);
    else
      pull_parts_.resize(pull.begin);
  }

  void add_part(std::int32_t vertex, double weight) {
    share_out(vertex, weight, [&](std::int32_t i, double w) { parts_.push_back({i, w}); });
  }

  // Calls add(i, weight) for each free particle i that moves the vertex.
  void share_out(std::int32_t vertex, double weight, auto&& add) const {
    const auto add_free = [&](std::int32_t i, double w) {
      if (free_[i] && w != 0.0) add(i, w);
    };
    if (followers_ == nullptr) {
      if (static_cast<std::size_t>(vertex) < mass_.size()) add_free(vertex, weight);
    } else if (static_cast<std::size_t>(vertex) < followers_->particles()) {
      for (const Followers::Share& s : followers_->shares(vertex))
        add_free(s.leader, s.weight * weight);
    }
  }

  void apply(const Touch& touch, const Vec3& force) {
    for (std::size_t k = touch.begin; k < touch.end; ++k)
      left_[parts_[k].particle] += parts_[k].weight * force;
  }

  void relax(Touch& touch) {
    Vec3 parting = Vec3::Zero();  // m/s²
    for (std::size_t k = touch.begin; k < touch.end; ++k)
      parting += parts_[k].weight / mass_[parts_[k].particle] * left_[parts_[k].particle];
    const Vec3 next = in_cone(touch.force - parting / touch.yielding, touch.normal, touch.friction);
    apply(touch, next - std::exchange(touch.force, next));
  }

  void relax(Pull& pull) {
    double parting = 0.0;
    for (std::size_t k = pull.begin; k < pull.end; ++k)
      parting +=
          pull_parts_[k].pull.dot(left_[pull_parts_[k].particle]) / mass_[pull_parts_[k].particle];
    const double next = std::max(0.0, pull.force - kOver * parting / pull.yielding);
    const double more = next - std::exchange(pull.force, next);
    for (std::size_t k = pull.begin; k < pull.end; ++k)
      left_[pull_parts_[k].particle] += more * pull_parts_[k].pull;
  }

  double measure() const {
    double sum = 0.0, all = 0.0;
    for (std::size_t i = 0; i < mass_.size(); ++i) {
      if (!free_[i]) continue;
      sum += left_[i].squaredNorm() / mass_[i];
      all += mass_[i];
    }
    return all > 0.0 ? std::sqrt(sum / all) / kGravity : 0.0;
  }

  const Followers* followers_ = nullptr;
  std::vector<Vec3> left_;  // N, not balanced
  std::vector<double> mass_;
  std::vector<char> free_;
  std::vector<TouchPart> parts_;
  std::vector<Touch> touches_;
  std::vector<PullPart> pull_parts_;
  std::vector<Pull> pulls_;
};

}  // namespace

double unbalanced_share(const ForcesAtRest& forces, double enough) {
  return Balance(forces).sweep_down_to(enough);
}

}  // namespace detail

namespace {

// The unbalanced share of the weight below which cloth is at rest; and the speed, by that of a fall
// through the size of the cloth. A swing that passes its lowest point has no force left, and one
// that turns has no speed: cloth at rest has neither.
constexpr double kBalanced = 1e-3, kStill = 1e-3;

// Below this multiple of that speed, a run that ends at rest asks for exact contact forces.
constexpr double kNear = 30.0;

// m/s: above it, cloth does not creep but move.
constexpr double kMoves = 0.1;

/// m/s, of a fall through the root of the area of the largest piece.
double falling_speed(const BuiltScene& built) {
  std::vector<double> area(std::max<std::size_t>(built.piece_begin.size(), 2) - 1, 0.0);
  for (const Triangle& t : built.rest.triangles) {
    const auto next = std::upper_bound(built.piece_begin.begin(), built.piece_begin.end(), t[0]);
    const Vec3& a = built.rest.vertices[t[0]];
    area[std::clamp<std::ptrdiff_t>(next - built.piece_begin.begin() - 1, 0,
                                    std::ssize(area) - 1)] +=
        0.5 * (built.rest.vertices[t[1]] - a).cross(built.rest.vertices[t[2]] - a).norm();
  }
  return std::sqrt(detail::kGravity * std::sqrt(*std::max_element(area.begin(), area.end())));
}

std::string verdict(const RestReport& rest, const VertexNames& names) {
  const std::string unbalanced = fmt::format("unbalanced {:.2g} of the weight", rest.unbalanced);
  if (rest.at_rest) return fmt::format("at rest: {}", unbalanced);
  const bool moves = rest.max_speed > kMoves;
  const std::string where = rest.vertex < 0 ? "" : " at " + names.vertex(rest.vertex);
  return fmt::format("still {}: {:.{}f} mm/s{}, {}", moves ? "moving" : "creeping",
                     1e3 * rest.max_speed, rest.max_speed < 0.01 ? 1 : 0, where, unbalanced);
}

}  // namespace

void Simulation::Parts::note_motion() {
  last_motion = {};
  double most = 0.0;
  for (std::size_t i = 0; i < n(); ++i) {
    const double way = (state.x[i] - input.x_t0[i]).squaredNorm();
    if (!(way > most)) continue;
    most = way;
    last_motion.vertex = static_cast<std::int32_t>(i);
  }
  last_motion.speed = std::sqrt(most) / input.h;
}

// The contacts near the state, where no step has found them.
std::vector<StepContact> Simulation::Parts::contacts_now() {
  std::vector<ContactPoint> points;
  look_at_state();
  methods.detection.find_candidates();
  methods.detection.find_proximities(points);
  std::vector<StepContact> contacts;
  for (const ContactPoint& c : points) contacts.push_back({c, c.gap, Vec3::Zero()});
  return contacts;
}

// The share of the weight that would have changed the velocities in the last step without drag and
// damping: the force that was left with the reactions of contacts and of the limiter. An implicit
// step evaluates forces before the limiter moves its end, so that cloth which the limiter brings
// back to the same place in every step has forces there that are not in balance. `still`: N, the
// forces without motion.
double Simulation::Parts::accelerating_share(std::span<const Vec3> still) const {
  std::vector<Vec3> mean(n()), force(n());
  for (std::size_t i = 0; i < n(); ++i) mean[i] = (state.x[i] - input.x_t0[i]) / input.h;
  methods.integrator->forces().evaluate({state.x, mean, input.particles.mass, state.time}, force);
  double sum = 0.0, all = 0.0;
  for (std::size_t i = 0; i < n(); ++i) {
    if (!(input.inv_mass[i] > 0.0)) continue;
    const double mass = input.particles.mass[i];
    const Vec3 kept = input.particles.v[i] + input.h / mass * (force[i] - still[i]);
    sum += mass * std::max((state.v[i] - kept).squaredNorm(), (mean[i] - kept).squaredNorm());
    all += mass;
  }
  return all > 0.0 ? std::sqrt(sum / all) / (input.h * detail::kGravity) : 0.0;
}

RestReport Simulation::Parts::rest() {
  RestReport rest;
  const bool stepped = attempts.accepted;
  if (!stepped) {  // which particles are held is known from a step
    input.t0 = input.t1 = state.time;
    input.h = nominal_step();
    std::vector<Vec3> x_t1(input.x_t0.size());
    detail::hold_particles(scene, built, state, input, x_t1);
    last_motion = {};
    for (std::size_t i = 0; i < n(); ++i)
      if (const double speed = state.v[i].norm(); speed > last_motion.speed)
        last_motion = {static_cast<std::int32_t>(i), speed};
  }
  rest.vertex = last_motion.vertex;
  rest.max_speed = last_motion.speed;
  const std::vector<StepContact> near =
      stepped ? detail::step_contacts(*methods.response, outcome) : contacts_now();
  const std::vector<Vec3> still(n(), Vec3::Zero());
  std::vector<Vec3> force(n());
  methods.integrator->forces().evaluate({state.x, still, input.particles.mass, state.time}, force);
  rest.unbalanced = detail::unbalanced_share({.force = force,
                                              .mass = input.particles.mass,
                                              .inv_mass = std::span(input.inv_mass).first(n()),
                                              .near = near,
                                              .held = methods.strain.held(state.x),
                                              .step = input.h,
                                              .followers = input.followers},
                                             0.5 * kBalanced);
  if (stepped && methods.strain.has_moved())
    rest.unbalanced = std::min(rest.unbalanced, accelerating_share(force));
  rest.at_rest = rest.unbalanced < kBalanced && rest.max_speed < kStill * falling_speed(built) &&
                 !(methods.untangling() || attempts.given_up);
  rest.verdict = verdict(rest, methods.names);
  return rest;
}

bool Simulation::Parts::is_slow() const {
  return last_motion.speed < kStill * falling_speed(built);
}

// A tenth of the load may be wrong in a step, so that contacts pull a little: cloth that should lie
// still hangs on them.
bool Simulation::Parts::settles() const {
  if (!scene.time.until_rest || state.step == 0) return false;
  const double near = kNear * kStill * falling_speed(built);
  return std::all_of(state.v.begin(), state.v.end(),
                     [&](const Vec3& v) { return v.squaredNorm() < near * near; });
}

}  // namespace selvedge
