// SPDX-License-Identifier: MIT
//
// Closed forms of contact that the responses must meet, each of them as far as it claims: particles
// on a plane and against each other, without any cloth between.
#include <gtest/gtest.h>
#include <selvedge/response/response.h>
#include <selvedge/tests/dense_algebra.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

namespace selvedge::response_oracles_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double kGravity = 9.81;
constexpr double kRest = 0.002;  // m, rest gap of all contacts here
constexpr double kFrameStep = 1.0 / 120.0;

/// The response with those of the settings that it has.
std::unique_ptr<Response> make_response(const std::string& name, const MethodOptions& settings) {
  const ResponseRegistry registry = responses();
  const auto& entry = registry.at(name);
  return entry(known_options(entry.options(), settings));
}

/// Particles that fly freely and meet a plane that may move, and each other: what the simulation
/// does in a step, without springs, so that the implicit solve is one small dense system.
class World {
 public:
  World(const std::string& response, bool implicit, const MethodOptions& config = {})
      : response_(make_response(response, config)), implicit_(implicit) {}

  Vec3 normal = Vec3::UnitZ(), body_velocity = Vec3::Zero(), gravity{0, 0, -kGravity};
  double friction = 0.0, rest_gap = kRest;
  bool plane = true;  // all particles against it; else particle 0 against particle 1
  int copies = 1;     // of each contact, as where parts of a surface lie against each other
  std::vector<Vec3> x, v;
  std::vector<double> mass;
  Ledger ledger;  // of all steps
  double time = 0.0;

  void add(double m, const Vec3& position, const Vec3& velocity = Vec3::Zero()) {
    mass.push_back(m);
    x.push_back(position);
    v.push_back(velocity);
  }
  double height(std::size_t i = 0) const { return normal.dot(x[i] - body_); }
  Vec3 slip(std::size_t i = 0) const { return x[i] - body_ - height(i) * normal; }
  Response& response() { return *response_; }

  void run(double seconds, double h) {
    for (int k = static_cast<int>(std::lround(seconds / h)); k > 0; --k) step(h);
  }

  void step(double h) {
    const std::size_t n = x.size();
    x_t0_ = x;
    predicted_ = v;
    x_t0_.push_back(body_);
    inv_mass_.clear();
    for (const double m : mass) inv_mass_.push_back(1.0 / m);
    inv_mass_.push_back(0.0);
    for (Vec3& u : predicted_) u += h * gravity;
    body_step_ = {h * body_velocity};
    const ResponseStep step{{x_t0_, inv_mass_, n, h}, mass, body_step_, v, predicted_, implicit_};
    response_->begin(step);
    response_->add(contacts());
    std::vector<Vec3> solved = predicted_;
    bool in_solve = false;
    if (implicit_) in_solve = solve(solved);
    std::vector<Vec3> x_t1(x_t0_);
    for (std::size_t i = 0; i < n; ++i) x_t1[i] += h * solved[i];
    x_t1[n] = body_ + body_step_[0];
    response_->correct(x_t1);
    EXPECT_EQ(x_t1[n], body_ + body_step_[0]);
    std::vector<Vec3> after(n);
    for (std::size_t i = 0; i < n; ++i) after[i] = (x_t1[i] - x_t0_[i]) / h;
    std::vector<ContactImpulse> impulses;
    response_->impulses(implicit_ ? solved : after, impulses);
    const std::vector<Vec3> before = in_solve ? after : solved;
    response_->finish(after);
    ledger.add(measure({step.motion, mass, impulses, before, after, in_solve}));
    for (std::size_t i = 0; i < n; ++i) x[i] = x_t1[i];
    v = after;
    body_ += body_step_[0];
    time += h;
  }

 private:
  std::vector<ContactPoint> contacts() const {
    const auto body = static_cast<std::int32_t>(x.size());
    std::vector<ContactPoint> list;
    for (std::int32_t i = 0; plane && i < copies * body; ++i)
      list.push_back({{i % body, body, body, body}, {1, -1, 0, 0}, normal, 0, rest_gap, friction});
    if (!plane) list.push_back({{0, 1, 1, 1}, {1, -1, 0, 0}, normal, 0, rest_gap, friction});
    for (ContactPoint& c : list) c.gap = normal.dot(relative(c, x_t0_));
    return list;
  }

  // M v⁺ + terms v⁺ = M (v + h g) + rhs, solved again until the contacts agree. True: with terms.
  bool solve(std::vector<Vec3>& out) {
    const auto n = static_cast<Eigen::Index>(x.size());
    bool any = false;
    for (int round = 0; round < 20; ++round) {
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(3 * n, 3 * n);
      Eigen::VectorXd b(3 * n);
      for (Eigen::Index i = 0; i < n; ++i) {
        a.block<3, 3>(3 * i, 3 * i).diagonal().setConstant(mass[i]);
        b.segment<3>(3 * i) = mass[i] * predicted_[i];
      }
      any = false;
      for (const ImplicitTerm& t : response_->terms()) {
        any = true;
        for (int p = 0; p < 4; ++p) {
          if (t.particle[p] < 0) continue;
          b.segment<3>(3 * t.particle[p]) += t.weight[p] * t.rhs;
          for (int q = 0; q < 4; ++q)
            if (t.particle[q] >= 0)
              a.block<3, 3>(3 * t.particle[p], 3 * t.particle[q]) +=
                  t.weight[p] * t.weight[q] * t.matrix;
        }
      }
      const Eigen::VectorXd solution = selvedge::testing::solve_dense(a, b);
      for (Eigen::Index i = 0; i < n; ++i) out[i] = solution.segment<3>(3 * i);
      if (!response_->update(out)) break;
    }
    return any;
  }

  std::unique_ptr<Response> response_;
  bool implicit_;
  std::vector<Vec3> x_t0_, predicted_, body_step_;  // of the last step, which the response views
  std::vector<double> inv_mass_;
  Vec3 body_ = Vec3::Zero();
};

std::vector<std::string> names() {
  std::vector<std::string> list;
  for (const auto& [name, factory] : responses()) list.push_back(name);
  return list;
}

// Those whose friction is Coulomb's, and by how much `penalty` creeps where it should stick.
const std::vector<std::string> kCoulomb = {"contact_force", "impulse", "position_correction"};
const std::vector<std::string> kRestitution = {"impulse", "reflection", "position_velocity"};

World on_incline(const std::string& response, bool implicit, double mu,
                 const MethodOptions& config = {}) {
  World world(response, implicit, config);
  world.normal = Vec3(-0.5, 0.0, std::sqrt(0.75));  // 30 degrees
  world.friction = mu;
  world.add(0.01, kRest * world.normal);
  return world;
}

TEST(Incline, CoulombsFrictionSticksWhereItExceedsTheSlope) {
  for (const bool implicit : {false, true})
    for (const std::string& name : kCoulomb) {
      World world = on_incline(name, implicit, 0.6);  // tan 30° = 0.577
      world.run(10.0, kFrameStep);
      EXPECT_LT(world.slip().norm(), 1e-6) << name << implicit;
      EXPECT_NEAR(world.height(), kRest, 1e-5) << name << implicit;
    }
}

TEST(Incline, CoulombsFrictionSlidesWithItsAcceleration) {
  for (const bool implicit : {false, true})
    for (const std::string& name : kCoulomb) {
      World world = on_incline(name, implicit, 0.3);
      world.run(1.0, kFrameStep);
      EXPECT_NEAR(world.v[0].norm(), 2.35629, 2e-3 * 2.35629) << name << implicit;
      EXPECT_NEAR(world.slip().norm(), 1.17814, 0.02 * 1.17814) << name << implicit;  // O(h)
    }
}

TEST(Incline, PenaltySlidesByCoulombAndCreepsAtItsSlipSpeed) {
  constexpr double slip_speed = 1e-4;
  const MethodOptions config{{"damping", 5.0},
                             {"slip_speed", slip_speed}};  // nearly critical: it settles at once
  for (const bool implicit : {false, true}) {
    const double h = implicit ? kFrameStep : 1e-3;
    World sliding = on_incline("penalty", implicit, 0.3, config);
    sliding.run(0.5, h);
    const double speed = sliding.v[0].norm();
    sliding.run(0.5, h);
    EXPECT_NEAR(sliding.v[0].norm() - speed, 0.5 * 2.35629, 2e-3) << implicit;
    World sticking = on_incline("penalty", implicit, 0.6, config);
    sticking.run(1.0, h);
    const double settled = sticking.slip().norm();
    sticking.run(1.0, h);
    EXPECT_LE(sticking.slip().norm() - settled, slip_speed) << implicit;
    if (implicit) {
      EXPECT_GT(sticking.slip().norm() - settled, 0.1 * slip_speed);  // it does creep
    }
  }
}

TEST(Incline, WithoutFrictionEveryResponseSlidesFreely) {
  const MethodOptions config{{"retention", 1.0}};
  for (const std::string& name : names()) {
    World world = on_incline(name, name == "penalty", 0.0, config);
    world.run(1.0, kFrameStep);
    EXPECT_NEAR(world.v[0].norm(), 0.5 * kGravity, 0.01 * kGravity) << name;
  }
}

/// Friction that the first solve takes for a particle of 10 g that falls on a plane at `speed`,
/// while the other forces pull it sideways, N·s.
Vec3 first_friction_at(double speed) {
  constexpr double h = kFrameStep, m = 0.01;
  const std::unique_ptr<Response> response = make_response("contact_force", {});
  const std::vector<Vec3> x{Vec3(0, 0, kRest), Vec3::Zero()}, v{Vec3(0, 0, -speed)};
  const std::vector<Vec3> still{Vec3::Zero()};
  const std::vector<Vec3> predicted{v[0] + h * Vec3(0, 0, -kGravity)};
  const std::vector<Vec3> unbalanced{h * m * kGravity * Vec3(0.1, 0, -1)};
  const std::vector<double> mass{m}, inv_mass{1.0 / m, 0.0};
  ResponseStep step{{x, inv_mass, 1, h}, mass, still, v, predicted};
  step.unbalanced = unbalanced;
  response->begin(step);
  const std::vector<ContactPoint> contacts{
      {{0, 1, 1, 1}, {1, -1, 0, 0}, Vec3::UnitZ(), kRest, kRest, 0.3}};
  response->add(contacts);
  const auto terms = response->terms();
  return terms.size() == 1 ? Vec3(terms[0].rhs.x(), terms[0].rhs.y(), 0.0) : Vec3::Constant(NAN);
}

/// Number of solves that a particle of 10 g takes until its contact agrees. It rests on a plane,
/// and the impulse of the other forces is `pull`. `known`: the response receives it.
int solves_under(const Vec3& pull, bool known) {
  constexpr double h = kFrameStep, m = 0.01;
  const std::unique_ptr<Response> response = make_response("contact_force", {});
  const std::vector<Vec3> x{Vec3(0, 0, kRest), Vec3::Zero()}, still{Vec3::Zero()};
  const std::vector<Vec3> predicted{h * Vec3(0, 0, -kGravity)}, unbalanced{pull};
  const std::vector<double> mass{m}, inv_mass{1.0 / m, 0.0};
  ResponseStep step{{x, inv_mass, 1, h}, mass, still, still, predicted};
  if (known) step.unbalanced = unbalanced;
  response->begin(step);
  const std::vector<ContactPoint> contacts{
      {{0, 1, 1, 1}, {1, -1, 0, 0}, Vec3::UnitZ(), kRest, kRest, 0.3}};
  response->add(contacts);
  int solves = 0;
  std::vector<Vec3> v = predicted;
  do {
    Mat3 a = m * Mat3::Identity();
    Vec3 b = pull;
    for (const ImplicitTerm& term : response->terms()) {
      a += term.matrix;
      b += term.rhs;
    }
    v[0] = a.inverse() * b;
    ++solves;
  } while (response->update(v));
  EXPECT_LT(v[0].head<2>().norm(), 1e-4);  // it sticks
  return solves;
}

TEST(FirstGuess, TakesOneSolveWhereItKnowsTheForcesThatItMustBalance) {
  // Twenty times the weight of the particle hangs on it, and pulls it sideways.
  const double weight = kFrameStep * 0.01 * kGravity;
  EXPECT_EQ(solves_under(weight * Vec3(5, 0, -20), true), 1);
  EXPECT_GT(solves_under(weight * Vec3(5, 0, -20), false), 1);
}

TEST(FirstGuess, BalancesOtherForcesAtRestButNotInAnImpact) {
  EXPECT_NEAR(first_friction_at(0.0).x(), -0.1 * kFrameStep * 0.01 * kGravity, 1e-6);
  EXPECT_EQ(first_friction_at(5.0).norm(), 0.0);
}

/// The term of a contact that two solves of another particle have preceded or, if not `late`, of
/// the first solve. Other forces pull its particle; `known`: the response receives them.
ImplicitTerm term_of_contact(bool late, bool known) {
  constexpr double h = kFrameStep, m = 0.01;
  const std::unique_ptr<Response> response = make_response("contact_force", {});
  const std::vector<Vec3> x{Vec3(0, 0, kRest), Vec3(1, 0, kRest), Vec3::Zero()};
  const std::vector<Vec3> v(2, Vec3::Zero()), still{Vec3::Zero()};
  const std::vector<Vec3> predicted(2, h * Vec3(0, 0, -kGravity));
  const std::vector<Vec3> unbalanced(2, h * m * kGravity * Vec3(5, 0, -20));
  const std::vector<double> mass{m, m}, inv_mass{1.0 / m, 1.0 / m, 0.0};
  ResponseStep step{{x, inv_mass, 2, h}, mass, still, v, predicted};
  if (known) step.unbalanced = unbalanced;
  response->begin(step);
  const auto contact = [](std::int32_t particle) {
    return ContactPoint{{particle, 2, 2, 2}, {1, -1, 0, 0}, Vec3::UnitZ(), kRest, kRest, 0.3};
  };
  const std::vector<ContactPoint> first{contact(0)}, second{contact(1)};
  if (late) {
    response->add(first);
    std::vector<Vec3> end = v;
    for (int solve = 0; solve < 2; ++solve) {
      response->terms();
      response->update(end);
    }
  }
  response->add(second);
  const auto terms = response->terms();
  EXPECT_FALSE(terms.empty());
  EXPECT_EQ(terms.back().particle[0], 1);
  return terms.back();
}

TEST(FirstGuess, AContactFoundAfterASolveIsACollisionAndBalancesNothing) {
  const ImplicitTerm early = term_of_contact(false, true), late = term_of_contact(true, true),
                     unknown = term_of_contact(true, false);
  EXPECT_EQ(late.rhs, unknown.rhs);
  EXPECT_EQ(late.matrix, unknown.matrix);
  EXPECT_LT(early.rhs.x(), 2.0 * late.rhs.x());  // friction against five times the weight
  EXPECT_LT(late.rhs.x(), 1e-12);
}

TEST(Floor, ASlidingParticleStopsWhereCoulombSays) {
  for (const bool implicit : {false, true})
    for (const std::string& name : kCoulomb) {
      World world(name, implicit);
      world.friction = 0.3;
      world.add(0.01, Vec3(0, 0, kRest), Vec3(1, 0, 0));
      world.run(0.33, 1e-3);
      EXPECT_GT(world.v[0].norm(), 0.01) << name;  // stops at 0.33979 s
      world.run(0.67, 1e-3);
      EXPECT_NEAR(world.x[0].x(), 0.16990, 0.005 * 0.16990) << name << implicit;
      EXPECT_LT(world.v[0].norm(), 1e-6) << name << implicit;
    }
}

TEST(Floor, AnUnstickingRetentionIsNoCoulombFriction) {
  // What eq. 48 keeps of a slip in a step is the same whatever presses, and depends on the step.
  std::vector<double> way;
  for (const double h : {kFrameStep, 0.5 * kFrameStep}) {
    World world("reflection", false);
    world.friction = 0.3;
    world.add(0.01, Vec3(0, 0, kRest), Vec3(1, 0, 0));
    world.run(1.0, h);
    way.push_back(world.x[0].x());
  }
  EXPECT_NEAR(way[0], 0.9 / (1.0 - 0.9) * kFrameStep, 1e-4);
  EXPECT_NEAR(way[0] / way[1], 2.0, 0.01);
}

TEST(Floor, FrictionIsOfThePlaceHoweverManyContactsStandForIt) {
  for (const bool implicit : {false, true})
    for (const std::string& name : names()) {
      std::vector<double> way;
      for (const int copies : {1, 2, 5}) {
        World world(name, implicit);
        world.friction = 0.3;
        world.copies = copies;
        world.add(0.01, Vec3(0, 0, kRest), Vec3(1, 0, 0));
        world.run(0.2, 1e-3);
        way.push_back(world.x[0].x());
      }
      EXPECT_NEAR(way[1] / way[0], 1.0, 1e-3) << name << implicit;
      EXPECT_NEAR(way[2] / way[0], 1.0, 1e-3) << name << implicit;
    }
}

/// Velocities after a step of a triangle that lands, while it slides, on points held below it, each
/// of which is met `copies` times.
std::vector<Vec3> landed(const std::string& name, const std::vector<Vec3>& weights, int copies) {
  const std::unique_ptr<Response> response = make_response(name, {});
  std::vector<Vec3> x{Vec3(0, 0, kRest), Vec3(0.01, 0, kRest), Vec3(0, 0.01, kRest)};
  const std::vector<Vec3> v(3, Vec3(0.7, -0.4, -0.1)), still(weights.size(), Vec3::Zero());
  const std::vector<double> mass(3, 0.01);
  std::vector<double> inv_mass(3, 100.0);
  std::vector<ContactPoint> contacts;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const Vec3& w = weights[k];
    x.push_back(w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - kRest * Vec3::UnitZ());
    inv_mass.push_back(0.0);
    for (int copy = 0; copy < copies; ++copy)
      contacts.push_back({{static_cast<std::int32_t>(3 + k), 0, 1, 2},
                          {1, -w[0], -w[1], -w[2]},
                          -Vec3::UnitZ(),
                          kRest,
                          kRest,
                          0.3,
                          ContactKind::triangle_point});
  }
  response->begin({{x, inv_mass, 3, kFrameStep}, mass, still, v, v, false});
  response->add(contacts);
  std::vector<Vec3> x_t1 = x, after(3);
  for (int i = 0; i < 3; ++i) x_t1[i] += kFrameStep * v[i];
  response->correct(x_t1);
  for (int i = 0; i < 3; ++i) after[i] = (x_t1[i] - x[i]) / kFrameStep;
  response->finish(after);
  return after;
}

TEST(Floor, TheShareThatSlidesOnIsThatOfEachPlace) {
  const Vec3 slip(0.7, -0.4, 0.0);
  for (const std::string name : {"reflection", "position_velocity"})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> share(0.05, 1.0);
      std::vector<Vec3> weights(1 + seed % 6);
      for (Vec3& w : weights) {
        w = Vec3(share(random), share(random), share(random));
        w /= w.sum();
      }
      const std::vector<Vec3> once = landed(name, weights, 1), often = landed(name, weights, 3);
      double most = 0.0;
      for (const Vec3& w : weights) {
        Vec3 there = w[0] * once[0] + w[1] * once[1] + w[2] * once[2];
        there.z() = 0.0;
        most = std::max(most, there.norm() / slip.norm());
      }
      if (name == "reflection") {
        EXPECT_NEAR(most, 0.9, 1e-6) << "seed " << seed;
      }
      for (int i = 0; i < 3; ++i)
        EXPECT_LT((often[i] - once[i]).norm(), 1e-6) << name << " seed " << seed;
    }
}

/// Heights of the tops between bounces, over the rest gap; the time of the first hit in `hit`.
std::vector<double> tops(World& world, double h, int bounces, double& hit) {
  std::vector<double> heights;
  double before = world.v[0].z();
  for (int k = 0; k < 1000000 && static_cast<int>(heights.size()) < bounces; ++k) {
    world.step(h);
    const double now = world.v[0].z();
    if (before < 0.0 && now > 0.0 && heights.empty() && hit < 0.0) hit = world.time - 0.5 * h;
    if (before > 0.0 && now <= 0.0) heights.push_back(world.height() - kRest);
    before = now;
  }
  return heights;
}

TEST(Drop, RestitutionGivesTheHeightsOfItsSquare) {
  const MethodOptions config{{"restitution", 0.5}};
  for (const std::string& name : kRestitution) {
    World world(name, false, config);
    world.add(0.01, Vec3(0, 0, 1.0 + kRest));
    double hit = -1.0;
    const std::vector<double> heights = tops(world, 1e-4, 2, hit);
    EXPECT_NEAR(hit, 0.451524, 2e-4) << name;
    EXPECT_NEAR(heights[0], 0.25, 0.25 * 0.005) << name;
    EXPECT_NEAR(heights[1], 0.0625, 0.0625 * 0.02) << name;
    world.run(1.37 - world.time, 1e-4);  // 1.354571 s
    EXPECT_LT(world.v[0].norm(), 1e-12) << name;
    EXPECT_NEAR(world.height(), kRest, 1e-4) << name;
  }
}

TEST(Drop, AnElasticBounceDoesNotRise) {
  const MethodOptions config{{"restitution", 1.0}};
  for (const std::string& name : kRestitution) {
    World world(name, false, config);
    world.add(0.01, Vec3(0, 0, 0.1 + kRest));
    double hit = -1.0;
    const std::vector<double> heights = tops(world, 1e-4, 10, hit);
    EXPECT_NEAR(heights.back(), 0.1, 0.1 * 0.03) << name;
    EXPECT_LT(heights.back(), 0.1 * 1.003) << name;
  }
}

TEST(Drop, OthersDoNotBounce) {
  for (const std::string& name : names()) {
    if (name == "penalty") continue;
    for (const bool implicit : {false, true}) {
      World world(name, implicit);
      world.add(0.01, Vec3(0, 0, 0.3));
      double highest = 0.0;
      for (int k = 0; k < 120; ++k) {
        world.step(kFrameStep);
        if (k > 40) highest = std::max(highest, world.height());  // it hits at 0.25 s
      }
      EXPECT_LT(highest, 1.01 * kRest) << name << implicit;
      EXPECT_LT(world.v[0].norm(), 1e-3) << name << implicit;
    }
  }
}

TEST(Collision, OfOneKilogramWithThreeAtRestLeavesAQuarter) {
  for (const std::string& name : names()) {
    if (name == "penalty") continue;
    const bool implicit = name == "contact_force";
    World world(name, implicit);
    world.plane = false;
    world.gravity.setZero();
    world.normal = -Vec3::UnitX();
    world.add(1.0, Vec3(-0.02, 0, 0), Vec3(4, 0, 0));
    world.add(3.0, Vec3::Zero());
    world.run(10 * kFrameStep, kFrameStep);
    // A stiff contact gives a little; what has no force inside a solve is exact.
    const double tolerance = implicit ? 0.02 : 1e-13;
    EXPECT_NEAR(world.v[0].x(), 1.0, tolerance) << name;
    EXPECT_NEAR(world.v[1].x(), 1.0, tolerance) << name;
    EXPECT_NEAR(world.v[0].x() + 3.0 * world.v[1].x(), 4.0, 1e-13) << name;
    if (!implicit) {
      EXPECT_NEAR(world.ledger.energy_normal + world.ledger.energy_friction, -6.0, 1e-11) << name;
    }
    EXPECT_LT(world.ledger.momentum_error, 1e-13) << name;
  }
}

TEST(Collision, RestitutionIsTheShareOfTheRelativeSpeed) {
  for (const std::string& name : kRestitution) {
    const MethodOptions config{{"restitution", 0.5}};
    World world(name, false, config);
    world.plane = false;
    world.gravity.setZero();
    world.normal = -Vec3::UnitX();
    world.add(1.0, Vec3(-0.02, 0, 0), Vec3(4, 0, 0));
    world.add(3.0, Vec3::Zero());
    world.run(5 * kFrameStep, kFrameStep);
    EXPECT_NEAR(world.v[1].x() - world.v[0].x(), 2.0, 1e-13) << name;
    EXPECT_NEAR(world.v[0].x() + 3.0 * world.v[1].x(), 4.0, 1e-13) << name;
    EXPECT_NEAR(world.ledger.energy_normal, -6.0 * 0.75, 1e-11) << name;  // 1 - e²
  }
}

struct Impact1D {
  double depth = 0.0, time = 0.0, rebound = 0.0;
};

/// A particle of 10 g at 1 m/s into a penalty contact, at steps of `share`/ω.
Impact1D hit(double stiffness, double zeta, bool implicit, double share) {
  const double m = 0.01, omega = std::sqrt(stiffness / m);
  const MethodOptions config{{"stiffness", stiffness}, {"damping", 2.0 * zeta * m * omega}};
  World world("penalty", implicit, config);
  world.gravity.setZero();
  world.rest_gap = 1.0;
  world.add(m, Vec3(0, 0, 1.0), Vec3(0, 0, -1));
  const double h = share / omega;
  Impact1D impact;
  while (world.time < 2.0 * pi / omega && (world.time == 0.0 || world.height() < 1.0)) {
    world.step(h);
    impact.depth = std::max(impact.depth, 1.0 - world.height());
  }
  impact.time = world.time;
  impact.rebound = world.v[0].z();
  return impact;
}

TEST(Penalty, GoesAsDeepAndLastsAsLongAsAnOscillator) {
  for (double stiffness = 10.0; stiffness <= 1e7; stiffness *= 10.0)
    for (const bool implicit : {false, true}) {
      const double root = std::sqrt(0.01 / stiffness);
      const Impact1D impact = hit(stiffness, 0.0, implicit, 2e-3);
      EXPECT_NEAR(impact.depth / root, 1.0, 0.005) << stiffness << implicit;
      EXPECT_NEAR(impact.time / (pi * root), 1.0, 0.005) << stiffness << implicit;
      EXPECT_NEAR(impact.rebound, 1.0, 0.01) << stiffness << implicit;
    }
}

TEST(Penalty, ADamperLeavesTheReboundOfAContactThatCannotPull) {
  for (const double zeta : {0.05, 0.1, 0.3, 0.6})
    for (const bool implicit : {false, true}) {
      const double root = std::sqrt(1.0 - zeta * zeta);
      const double clamped = std::exp(-zeta * (pi - 2.0 * std::asin(zeta)) / root);
      const double pulling = std::exp(-zeta * pi / root);
      const double e = hit(1e3, zeta, implicit, 1e-3).rebound;
      EXPECT_NEAR(e, clamped, 0.005) << zeta << implicit;
      EXPECT_GT(e, pulling) << zeta << implicit;
    }
}

// A damper that pulls would brake it.
TEST(Penalty, LeavesAParticleThatPartsFasterThanItsSpringPushesAlone) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int draw = 0; draw < 200; ++draw) {
    const double stiffness = 100.0 * share(random), damping = 0.1 + share(random);
    const MethodOptions config{{"stiffness", stiffness}, {"damping", damping}};
    const double depth = kRest * share(random);
    // In an implicit step the spring pushes with what is left of the depth at its end.
    const double speed = (1.0 + share(random)) * stiffness * depth / damping + 1e-3;
    for (const bool implicit : {false, true}) {
      World world("penalty", implicit, config);
      world.gravity.setZero();
      world.friction = share(random);
      const Vec3 velocity(share(random), 0.0, speed);
      world.add(0.01, Vec3(0, 0, kRest - depth), velocity);
      world.step(1e-4);
      EXPECT_LT((world.v[0] - velocity).norm(), 1e-9)
          << stiffness << " N/m, " << damping << " N·s/m, " << depth << " m deep";
    }
  }
}

TEST(Penalty, GivesBackNoMoreThanItStored) {
  for (const double share : {0.1, 0.5, 1.0, 2.0, 20.0})
    EXPECT_LE(hit(1e4, 0.0, true, share).rebound, 1.0 + 1e-12) << share;
}

TEST(Penalty, AnExplicitStepBearsTheContactsUpToTheBoundItNames) {
  for (const double damping : {0.0, 0.5, 5.0})
    for (const double factor : {0.97, 1.03}) {
      const MethodOptions config{{"stiffness", 1e4}, {"damping", damping}};
      World world("penalty", false, config);
      world.rest_gap = 1.0;
      world.gravity = Vec3(0, 0, -1e4);  // pressed deep, so that it never parts
      const double depth = 0.01 * 1e4 / 1e4;
      world.add(0.01, Vec3(0, 0, 1.0 - depth + 1e-6));
      const double bound = world.response().stable_step(1.0 / 0.01);
      if (damping == 0.0) {
        EXPECT_NEAR(bound, 2.0 * std::sqrt(0.01 / 1e4), 1e-12);
      }
      world.step(factor * bound);
      EXPECT_NEAR(world.response().stable_step(), bound, 1e-9 * bound);  // one contact: the same
      world.run(400 * factor * bound, factor * bound);
      const double off = std::abs(world.height() - (1.0 - depth));
      if (factor < 1.0) {
        EXPECT_LT(off, 1e-5) << damping;
      } else {
        EXPECT_GT(off, 1e-4) << damping;
      }
    }
}

TEST(MovingFrame, ChangesNothing) {
  const Vec3 drift(3.0, -2.0, 1.0);
  MethodOptions config;
  for (const std::string& name : names())
    for (const bool implicit : {false, true}) {
      if (name == "penalty" && !implicit) config.set("stiffness", 100.0);
      std::vector<Vec3> ends;
      for (const Vec3& frame : {Vec3(0, 0, 0), drift}) {
        World world(name, implicit, config);
        world.friction = 0.3;
        world.body_velocity = frame;
        world.add(0.01, Vec3(0.1, 0.0, 0.05), Vec3(Vec3(1.0, 0.5, -0.2) + frame));
        world.run(0.5, kFrameStep);
        ends.push_back(world.slip() + world.height() * world.normal);
      }
      EXPECT_LT((ends[0] - ends[1]).norm(), 1e-9) << name << implicit;
    }
}

TEST(MovingFrame, TheReflectionAsPrintedFailsInIt) {
  // [survey eq. 49] as printed: parts of the absolute velocity, and the body's added to them.
  const auto printed = [](const Vec3& v, const Vec3& body, const Vec3& n, double keep,
                          double give) {
    const Vec3 vn = n.dot(v) * n, vt = v - vn;
    return Vec3(keep * vt - give * vn + body);
  };
  const auto mended = [](const Vec3& v, const Vec3& body, const Vec3& n, double keep, double give) {
    const Vec3 r = v - body, rn = n.dot(r) * n, rt = r - rn;
    return Vec3(keep * rt - give * rn + body);
  };
  const Vec3 n = Vec3::UnitZ(), v(1, 0, -2), drift(3, -2, 1);
  const Vec3 at_rest = printed(v, Vec3::Zero(), n, 0.9, 0.5);
  EXPECT_EQ(at_rest, mended(v, Vec3::Zero(), n, 0.9, 0.5));
  EXPECT_LT((mended(v + drift, drift, n, 0.9, 0.5) - drift - at_rest).norm(), 1e-15);
  EXPECT_GT((printed(v + drift, drift, n, 0.9, 0.5) - drift - at_rest).norm(), 2.0);
  // `reflection` is the mended one, at any speed of the body.
  const MethodOptions config{{"restitution", 0.5}};
  for (const Vec3& body : {Vec3(0, 0, 0), drift}) {
    World world("reflection", false, config);
    world.gravity.setZero();
    world.body_velocity = body;
    world.add(0.01, Vec3(0, 0, kRest), v + body);
    world.step(kFrameStep);
    EXPECT_LT((world.v[0] - mended(v + body, body, n, 0.9, 0.5)).norm(), 1e-13);
  }
}

TEST(InverseDynamics, GivesTheForceOfTheMendedEquationEqualAndOpposite) {
  const double h = kFrameStep, m1 = 0.01, m2 = 0.03;
  const Vec3 v1(0.1, 0, -2), v2(0, 0.2, 1), gravity(1, 2, -kGravity);
  for (const bool sticking : {false, true}) {
    const MethodOptions config{{"sticking", sticking ? 1.0 : 0.0}};
    World world("inverse_dynamics", false, config);
    world.plane = false;
    world.gravity = gravity;
    world.add(m1, Vec3(0, 0, kRest), v1);
    world.add(m2, Vec3::Zero(), v2);
    world.step(h);
    // [survey eq. 46, 47 mended] F_c1 = m_eff ((V2 - V1)/h + F2/m2 - F1/m1)
    Vec3 force = m1 * m2 / (m1 + m2) * ((v2 - v1) / h + gravity - gravity);
    if (!sticking) force = force.z() * Vec3::UnitZ();
    EXPECT_LT((world.v[0] - (v1 + h * (gravity + force / m1))).norm(), 1e-12);
    EXPECT_LT((world.v[1] - (v2 + h * (gravity - force / m2))).norm(), 1e-12);
    // As printed, the forces of the pair sum to the negative of what acts on both from outside.
    const Vec3 f1 = m1 * gravity, f2 = m2 * gravity;
    const Vec3 common = (m1 * v1 + m2 * v2 + (f1 + f2) * h) / (m1 + m2);
    const Vec3 printed1 = m1 * (common - v1) / h - f1, printed2 = m2 * (common - v2) / h - f2;
    EXPECT_LT((printed1 + printed2).norm(), 1e-12);  // with the external force in the common speed
    const Vec3 wrong = printed1 - f1 + printed2 - f2;  // and taken off again
    EXPECT_GT(wrong.norm(), 0.9 * (f1 + f2).norm());
  }
}

TEST(PositionCorrection, GivesNoVelocityForAGapThatWasTooSmall) {
  for (const char* name : {"position_correction", "position_velocity", "impulse"}) {
    World world(name, false);
    world.gravity.setZero();
    world.add(0.01, Vec3(0, 0, 0.5 * kRest));
    world.run(10 * kFrameStep, kFrameStep);
    EXPECT_NEAR(world.height(), kRest, 1e-12) << name;
    EXPECT_LT(world.v[0].norm(), 1e-12) << name;
  }
}

/// Contacts of all shapes among particles, of which some may be anchors.
struct Swarm {
  std::vector<Vec3> x_t0, x_t1, v;
  std::vector<double> mass, inv_mass;
  std::vector<ContactPoint> contacts;

  Swarm(unsigned seed, double anchors) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform;
    const int n = 24;
    for (int i = 0; i < n; ++i) {
      x_t0.push_back(0.1 * Vec3(normal(random), normal(random), normal(random)));
      v.push_back(Vec3(normal(random), normal(random), normal(random)));
      mass.push_back(0.01 * (0.1 + uniform(random)));
      inv_mass.push_back(uniform(random) < anchors ? 0.0 : 1.0 / mass.back());
      x_t1.push_back(x_t0.back() + kFrameStep * v.back());
    }
    for (int k = 0; k < 30; ++k) {
      ContactPoint c;
      for (int j = 0; j < 4; ++j) {
        do c.vertex[j] = static_cast<std::int32_t>(random() % n);
        while (std::find(c.vertex.begin(), c.vertex.begin() + j, c.vertex[j]) !=
               c.vertex.begin() + j);
      }
      const double s = uniform(random), t = uniform(random);
      if (k % 2 == 0)
        c.weight = {1.0, -s * t, -s * (1.0 - t), s - 1.0};
      else
        c.weight = {1.0 - s, s, t - 1.0, -t};
      const Vec3 along = relative(c, x_t0);
      c.gap = along.norm();
      c.normal = along / c.gap;
      c.rest_gap = c.gap * (0.5 + uniform(random));
      c.friction = uniform(random);
      contacts.push_back(c);
    }
  }

  ResponseStep step() const {
    return {{x_t0, inv_mass, x_t0.size(), kFrameStep}, mass, {}, v, v, false};
  }
};

Ledger answer(Response& response, Swarm& swarm) {
  const std::vector<Vec3> before = swarm.v;
  response.begin(swarm.step());
  response.add(swarm.contacts);
  response.correct(swarm.x_t1);
  std::vector<Vec3> after;
  for (std::size_t i = 0; i < swarm.x_t1.size(); ++i)
    after.push_back((swarm.x_t1[i] - swarm.x_t0[i]) / kFrameStep);
  std::vector<ContactImpulse> impulses;
  response.impulses(after, impulses);
  response.finish(after);
  return measure({swarm.step().motion, swarm.mass, impulses, before, after});
}

TEST(Momentum, IsKeptByWhoeverClaimsItAndWhatAnchorsTakeIsTold) {
  for (const auto& [name, make] : responses())
    for (unsigned seed = 1; seed <= 20; ++seed)
      for (const double anchors : {0.0, 0.3}) {
        const auto response = make();
        if (!response->traits().keeps_momentum) continue;
        Swarm swarm(seed, anchors);
        const Ledger ledger = answer(*response, swarm);
        EXPECT_GT(ledger.to_particles.norm(), 0.0) << name;
        EXPECT_LT(ledger.momentum_error, 1e-12) << name << " " << seed;
        EXPECT_LT((ledger.to_particles + ledger.to_anchors).norm(), 1e-13) << name << " " << seed;
        if (anchors == 0.0) {
          EXPECT_EQ(ledger.to_anchors, Vec3(Vec3::Zero())) << name;
        }
      }
}

TEST(Energy, IsNeverGivenByAPassiveResponse) {
  for (const auto& [name, make] : responses())
    for (const bool friction : {false, true})
      for (unsigned seed = 1; seed <= 40; ++seed) {
        const auto response = make();
        if (!response->traits().passive) continue;
        Swarm swarm(seed, 0.0);
        for (ContactPoint& c : swarm.contacts)
          if (!friction) c.friction = 0.0;
        const Ledger ledger = answer(*response, swarm);
        EXPECT_LE(ledger.energy_gained, 1e-16) << name << " " << seed;
        EXPECT_LE(ledger.energy_kinetic, 1e-16) << name << " " << seed;
        EXPECT_NEAR(ledger.energy_normal + ledger.energy_friction, ledger.energy_kinetic,
                    1e-12 * std::abs(ledger.energy_kinetic))
            << name << " " << seed;
      }
}

// A stage that reports no impulses, such as a fail-safe, must account for all that it changes.
TEST(Energy, OfAStageWithoutImpulsesIsThatOfItsVelocities) {
  const Swarm swarm(1, 0.0);
  std::vector<Vec3> after;
  double kinetic = 0.0;
  for (std::size_t i = 0; i < swarm.v.size(); ++i) {
    after.push_back(2.0 * swarm.v[i]);
    kinetic += 0.5 * swarm.mass[i] * swarm.v[i].squaredNorm();
  }
  const Ledger faster = measure({swarm.step().motion, swarm.mass, {}, swarm.v, after});
  EXPECT_NEAR(faster.energy_normal, 3.0 * kinetic, 1e-12 * kinetic);
  EXPECT_NEAR(faster.energy_gained, 3.0 * kinetic, 1e-12 * kinetic);
  const Ledger slower = measure({swarm.step().motion, swarm.mass, {}, after, swarm.v});
  EXPECT_NEAR(slower.energy_normal, -3.0 * kinetic, 1e-12 * kinetic);
  EXPECT_EQ(slower.energy_gained, 0.0);
}

TEST(Anchors, DoNotMoveByABit) {
  for (const auto& [name, make] : responses())
    for (unsigned seed = 1; seed <= 20; ++seed) {
      Swarm swarm(seed, 0.4);
      const std::vector<Vec3> before = swarm.x_t1;
      const auto response = make();
      answer(*response, swarm);
      for (std::size_t i = 0; i < before.size(); ++i)
        if (swarm.inv_mass[i] <= 0.0) {
          EXPECT_EQ(swarm.x_t1[i], before[i]) << name;
        }
      EXPECT_NE(swarm.x_t1, before) << name;
    }
}

TEST(Anchors, HeldParticlesGiveMotionAndTakeNone) {
  // A held particle that is driven into a free one: the same as a body that moves.
  for (const std::string& name : kCoulomb) {
    std::vector<Vec3> x_t0{{0, 0, kRest}, {0, 0, 0}}, x_t1{{0, 0, kRest}, {0, 0, 0.01}};
    const std::vector<double> mass{0.01, 0.01}, inv_mass{100.0, 0.0};
    const std::vector<Vec3> v(2, Vec3::Zero());
    const ContactPoint c{{0, 1, 1, 1}, {1, -1, 0, 0}, Vec3::UnitZ(), kRest, kRest, 0.0};
    const auto response = responses().at(name)({});
    response->begin({{x_t0, inv_mass, 2, kFrameStep}, mass, {}, v, v, false});
    response->add({&c, 1});
    response->correct(x_t1);
    EXPECT_EQ(x_t1[1], Vec3(0, 0, 0.01)) << name;
    EXPECT_NEAR(x_t1[0].z(), 0.01 + kRest, 1e-15) << name;
  }
}

TEST(Config, OutOfRangeIsRefusedWithItsNumber) {
  const auto refused = [](const std::string& option, double value, const std::string& number) {
    int takers = 0;
    for (const auto& [name, entry] : responses()) {
      const bool has = !known_options(entry.options(), {{option, value}}).empty();
      takers += has;
      try {
        entry({{option, value}});
        ADD_FAILURE() << name << " takes " << option << " " << number;
      } catch (const std::invalid_argument& error) {
        const std::string wanted = has ? number : "has no option \"" + option + "\"";
        EXPECT_NE(std::string(error.what()).find(wanted), std::string::npos) << error.what();
      }
    }
    EXPECT_GT(takers, 0) << option;
  };
  refused("stiffness", -3.0, "-3");
  refused("damping", -0.5, "-0.5");
  refused("restitution", 1.25, "1.25");
  refused("restitution", std::nan(""), "nan");
  refused("retention", -0.25, "-0.25");
  refused("slip_speed", 0.0, "greater than 0");
}

}  // namespace
}  // namespace selvedge::response_oracles_test
