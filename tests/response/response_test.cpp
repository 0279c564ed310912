// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/response/detail/contact_force.h>
#include <selvedge/response/detail/contact_sweeps.h>
#include <selvedge/response/detail/impact_zone.h>
#include <selvedge/response/detail/impulse.h>
#include <selvedge/tests/dense_algebra.h>

#include <Eigen/LU>
#include <random>

namespace selvedge::response_test {
namespace {

using namespace detail;

constexpr double kStep = 1.0 / 120.0;

// Four free particles of different mass whose point goes through the triangle during the step.
struct PointThroughTriangle {
  std::vector<Vec3> x_t0{{0.25, 0.25, 0.1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  std::vector<Vec3> x_t1{{0.45, 0.25, -0.2}, {0, 0, 0.02}, {1, 0, 0}, {0, 1, 0}};
  std::vector<double> mass{1.0, 2.0, 3.0, 4.0};
  std::vector<double> inv_mass{1.0, 0.5, 1.0 / 3.0, 0.25};
  ContactPoint contact{{0, 1, 2, 3}, {1.0, -0.5, -0.25, -0.25}, Vec3::UnitZ(), 0.1, 0.01, 0.0};

  ContactMotion motion() const { return {x_t0, inv_mass, 4, kStep}; }
  Vec3 momentum() const {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 4; ++i) sum += mass[i] * (x_t1[i] - x_t0[i]);
    return sum;
  }
  Vec3 angular_momentum() const {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 4; ++i) sum += mass[i] * x_t0[i].cross(x_t1[i] - x_t0[i]);
    return sum;
  }
  double energy() const {
    double sum = 0.0;
    for (int i = 0; i < 4; ++i) sum += 0.5 * mass[i] * (x_t1[i] - x_t0[i]).squaredNorm();
    return sum;
  }
};

TEST(Impulse, SeparatesTheContactAndKeepsMomentum) {
  PointThroughTriangle scene;
  scene.contact.friction = 0.4;
  const Vec3 before = scene.momentum();
  const double energy = scene.energy();
  apply_impulses(scene.motion(), {&scene.contact, 1}, {}, scene.x_t1);
  EXPECT_GE(scene.contact.normal.dot(relative(scene.contact, scene.x_t1)), 0.1 * 0.01 - 1e-15);
  EXPECT_LT((scene.momentum() - before).norm(), 1e-14);
  EXPECT_LT(scene.energy(), energy);
}

TEST(Impulse, FrictionIsCoulombs) {
  for (const double mu : {0.0, 0.1, 0.3, 100.0}) {
    PointThroughTriangle scene;
    scene.contact.friction = mu;
    const Vec3 u0 = relative(scene.contact, scene.x_t1) - relative(scene.contact, scene.x_t0);
    apply_impulses(scene.motion(), {&scene.contact, 1}, {.sweeps = 1}, scene.x_t1);
    const Vec3 u1 = relative(scene.contact, scene.x_t1) - relative(scene.contact, scene.x_t0);
    const double normal_change = u1.z() - u0.z();
    const double expected = std::max(0.0, u0.head<2>().norm() - mu * normal_change);
    EXPECT_NEAR(u1.head<2>().norm(), expected, 1e-14) << "mu = " << mu;
  }
}

TEST(Impulse, LeavesBodiesAndSeparatedContactsAlone) {
  PointThroughTriangle scene;
  scene.inv_mass = {1.0, 0.0, 0.0, 0.0};
  const auto before = scene.x_t1;
  apply_impulses(scene.motion(), {&scene.contact, 1}, {}, scene.x_t1);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(scene.x_t1[i], before[i]);
  EXPECT_NE(scene.x_t1[0], before[0]);
  scene.x_t1[0].z() = 0.5;
  const auto apart = scene.x_t1;
  apply_impulses(scene.motion(), {&scene.contact, 1}, {}, scene.x_t1);
  EXPECT_EQ(scene.x_t1, apart);
}

TEST(ImpactZone, KeepsBothMomentaAndNeverGainsEnergy) {
  PointThroughTriangle scene;
  scene.x_t1[1].y() = 0.1;
  const Vec3 linear = scene.momentum(), angular = scene.angular_momentum();
  const double energy = scene.energy();
  ImpactZones zones;
  zones.begin(scene.motion());
  zones.merge({&scene.contact, 1});
  ASSERT_TRUE(zones.apply(scene.mass, scene.x_t1));
  EXPECT_EQ(zones.members(), 4u);
  EXPECT_LT((scene.momentum() - linear).norm(), 1e-14);
  EXPECT_LT((scene.angular_momentum() - angular).norm(), 1e-14);
  EXPECT_LT(scene.energy(), energy);
  // Rigid up to the square of the turn, which is below 0.1 here.
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) {
      const double before = (scene.x_t0[i] - scene.x_t0[j]).norm();
      EXPECT_NEAR((scene.x_t1[i] - scene.x_t1[j]).norm(), before, 0.005 * before);
    }
}

TEST(ImpactZone, CountsItsRoundsAndTheMostParticlesInZones) {
  PointThroughTriangle scene;
  ImpactZones zones;
  zones.begin(scene.motion());
  std::map<std::string, double> counters;
  ASSERT_TRUE(zones.grow({&scene.contact, 1}, scene.mass, scene.x_t1, counters));
  EXPECT_EQ(counters, (std::map<std::string, double>{{"max_zone", 4.0}, {"zone_rounds", 1.0}}));
  zones.begin(scene.motion());
  ASSERT_TRUE(zones.grow({}, scene.mass, scene.x_t1, counters));
  EXPECT_EQ(counters, (std::map<std::string, double>{{"max_zone", 4.0}, {"zone_rounds", 2.0}}));
}

TEST(ContactForce, AContactOutsideTheSolveGetsTheFrictionOfItsLoad) {
  PointThroughTriangle scene;
  scene.contact.friction = 0.2;
  ResponseStep step;
  step.motion = scene.motion();
  step.mass = scene.mass;
  const std::vector<Vec3> rest(4, Vec3::Zero());
  step.v = step.v_predicted = rest;
  ContactForce force;
  force.begin(step);
  force.add({&scene.contact, 1});
  ASSERT_TRUE(force.terms().empty()) << "the point is far from the triangle and rests";
  std::vector<Vec3> v;
  for (int i = 0; i < 4; ++i) v.push_back((scene.x_t1[i] - scene.x_t0[i]) / kStep);
  const Vec3 u = relative(scene.contact, v) * kStep;
  ASSERT_TRUE(force.update(v));
  ASSERT_EQ(force.terms().size(), 1u);
  const Vec3& rhs = force.terms()[0].rhs;
  const double violation = scene.contact.rest_gap - scene.contact.gap - u.z();
  const double stopping = violation / compliance(scene.contact, scene.inv_mass) / kStep;
  const double ratio = ContactForceConfig{}.normal_ratio;
  EXPECT_NEAR(std::hypot(rhs.x(), rhs.y()), 0.2 * stopping * ratio / (1.0 + ratio),
              1e-9 * stopping);
}

TEST(ContactSweeps, TakeFrictionBackWhereTheLoadIsGone) {
  PointThroughTriangle scene;
  SweptContact contact;
  contact.point = scene.contact;
  contact.m_eff = 1.0 / compliance(scene.contact, scene.inv_mass);
  contact.friction = 0.5;
  contact.target = -1.0;  // it separates as it is
  contact.tangential = Vec3(0.3, 0.0, 0.0);
  std::vector<Vec3> u(4, Vec3::Zero());
  sweep_contacts(scene.inv_mass, {&contact, 1}, {}, u);
  EXPECT_EQ(contact.tangential, Vec3(Vec3::Zero()));
  EXPECT_LT((u[0] - Vec3(-0.3, 0.0, 0.0)).norm(), 1e-15);
}

TEST(ContactSweeps, TheSmallestImpulseHasItsFriction) {
  PointThroughTriangle scene;
  SweptContact contact;
  contact.point = scene.contact;
  contact.m_eff = 1.0 / compliance(scene.contact, scene.inv_mass);
  contact.friction = 0.25;
  std::vector<Vec3> u(4, Vec3::Zero());
  u[0] = Vec3(1e-3, 0.0, -1e-3);
  sweep_contacts(scene.inv_mass, {&contact, 1}, {}, u);
  EXPECT_NEAR(contact.normal, 1e-3 * contact.m_eff, 1e-15);
  EXPECT_NEAR(contact.tangential.x(), -0.25 * contact.normal, 1e-15);
}

TEST(ContactSweeps, EndAtOnceWhereNothingChangesAnyMore) {
  PointThroughTriangle scene;
  SweptContact contact;
  contact.point = scene.contact;
  contact.m_eff = 1.0 / compliance(scene.contact, scene.inv_mass);
  std::vector<Vec3> u(4, Vec3::Zero());
  u[0] = Vec3(0.0, 0.0, -1.0);
  EXPECT_LE(sweep_contacts(scene.inv_mass, {&contact, 1}, {}, u), 3);
}

TEST(ContactAnswer, AnImpulseOfFrictionAloneIsKept) {
  PointThroughTriangle scene;
  ResponseStep step;
  step.motion = scene.motion();
  step.mass = scene.mass;
  ContactAnswer answer;
  answer.begin(step);
  answer.add({&scene.contact, 1});
  answer.contacts()[0].tangential = Vec3(0.5, 0.0, 0.0);
  answer.keep_impulses(2.0);
  std::vector<ContactImpulse> impulses;
  answer.impulses(impulses);
  ASSERT_EQ(impulses.size(), 1u);
  EXPECT_EQ(impulses[0].impulse, Vec3(0.25, 0.0, 0.0));
}

TEST(ContactAnswer, BodiesOfWhichNoDisplacementIsGivenRest) {
  PointThroughTriangle scene;
  scene.inv_mass = {1.0, 0.0, 0.0, 0.0};
  ResponseStep step;
  step.motion = scene.motion();
  step.motion.particles = 1;
  step.mass = std::span(scene.mass).first(1);
  const std::vector<Vec3> v(1, Vec3::Zero());
  step.v = step.v_predicted = v;
  ContactAnswer answer;
  answer.begin(step);
  answer.add({&scene.contact, 1});
  answer.take(std::span(scene.x_t1).first(1), 0.0);
  ASSERT_EQ(answer.displacement().size(), 4u);
  EXPECT_EQ(answer.displacement()[0], Vec3(scene.x_t1[0] - scene.x_t0[0]));
  for (int i = 1; i < 4; ++i) EXPECT_EQ(answer.displacement()[i], Vec3(Vec3::Zero())) << i;
}

TEST(ImpactZone, OfFreeParticlesThatTurnsTooFarAsksForAShorterStep) {
  PointThroughTriangle scene;
  for (int i = 0; i < 4; ++i) scene.x_t1[i] = Eigen::AngleAxisd(0.5, Vec3::UnitZ()) * scene.x_t0[i];
  ImpactZones zones;
  zones.begin(scene.motion());
  zones.merge({&scene.contact, 1});
  EXPECT_FALSE(zones.apply(scene.mass, scene.x_t1));
  EXPECT_NE(zones.failure_reason().find("rotates too far"), std::string::npos);
}

TEST(ImpactZone, StaysBitForBitAtAStaticBody) {
  PointThroughTriangle scene;
  scene.inv_mass = {1.0, 0.5, 0.0, 0.0};
  scene.x_t1[2] = scene.x_t0[2];
  scene.x_t1[3] = scene.x_t0[3];
  ImpactZones zones;
  zones.begin(scene.motion());
  zones.merge({&scene.contact, 1});
  ASSERT_TRUE(zones.apply(scene.mass, scene.x_t1));
  EXPECT_EQ(scene.x_t1, scene.x_t0);
}

TEST(ImpactZone, FollowsABodyThatTurns) {
  PointThroughTriangle scene;
  scene.inv_mass = {1.0, 0.0, 0.0, 0.0};
  const Mat3 turn = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  for (int i = 1; i < 4; ++i) scene.x_t1[i] = turn * scene.x_t0[i] + Vec3(0.1, 0.2, 0.3);
  ImpactZones zones;
  zones.begin(scene.motion());
  zones.merge({&scene.contact, 1});
  ASSERT_TRUE(zones.apply(scene.mass, scene.x_t1));
  EXPECT_LT((scene.x_t1[0] - (turn * scene.x_t0[0] + Vec3(0.1, 0.2, 0.3))).norm(), 1e-14);
}

TEST(ImpactZone, SaysWhenItsBodiesDoNotMoveAsOne) {
  PointThroughTriangle scene;
  scene.inv_mass = {1.0, 0.0, 0.0, 0.0};
  scene.x_t1[3] = scene.x_t0[3] + Vec3(0.3, 0.3, 0.3);
  ImpactZones zones;
  zones.begin(scene.motion());
  zones.merge({&scene.contact, 1});
  EXPECT_FALSE(zones.apply(scene.mass, scene.x_t1));
  EXPECT_NE(zones.failure_reason().find("jammed: 1 particle (0) between held particle"),
            std::string::npos)
      << zones.failure_reason();
}

TEST(ImpactZone, JoinsContactsThatShareAParticleInAnyOrder) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vec3> x_t0(12), x_t1(12);
  for (std::size_t i = 0; i < x_t0.size(); ++i) {
    x_t0[i] = Vec3(normal(random), normal(random), normal(random));
    x_t1[i] = x_t0[i] + 0.01 * Vec3(normal(random), normal(random), normal(random));
  }
  const std::vector<double> mass(12, 1.0), inv_mass(12, 1.0);
  std::vector<ContactPoint> contacts(3);
  contacts[0].vertex = {0, 1, 2, 3};
  contacts[1].vertex = {3, 4, 5, 6};
  contacts[2].vertex = {8, 9, 10, 11};
  const ContactMotion motion{x_t0, inv_mass, 12, kStep};
  std::vector<std::vector<Vec3>> ends;
  for (const auto& order : {std::array{0, 1, 2}, std::array{2, 1, 0}}) {
    ImpactZones zones;
    zones.begin(motion);
    for (const int k : order) zones.merge({&contacts[k], 1});
    ends.push_back(x_t1);
    ASSERT_TRUE(zones.apply(mass, ends.back()));
  }
  EXPECT_EQ(ends[0], ends[1]);
  const auto& end = ends[0];
  EXPECT_NEAR((end[0] - end[6]).norm(), (x_t0[0] - x_t0[6]).norm(), 2e-4);
  EXPECT_GT(std::abs((end[0] - end[8]).norm() - (x_t0[0] - x_t0[8]).norm()), 1e-3);
  EXPECT_EQ(end[7], x_t1[7]);
}

// One particle on a plane through the origin, solved as the simulation does it, without a matrix:
// its own mass and the contact's term make a 3x3 system.
class Block {
 public:
  /// `pull`: a force downwards beside the weight, N.
  Block(double incline, double mu, double pull = 0.0) : mu_(mu), pull_(pull) {
    normal_ = Vec3(-std::sin(incline), 0.0, std::cos(incline));
    x_ = rest_gap_ * normal_;
  }

  void run(double seconds) {
    for (int k = 0; k < std::lround(seconds / kStep); ++k) step();
  }
  void lower(double depth) { x_ -= depth * normal_; }
  const Vec3& position() const { return x_; }
  Vec3& velocity() { return v_; }
  double gap() const { return normal_.dot(x_); }
  int solves() const { return solves_; }

 private:
  void step() {
    const Vec3 gravity(0, 0, -9.81), all = gravity - pull_ / mass_ * Vec3::UnitZ();
    const std::vector<Vec3> x_t0{x_, Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    const std::vector<double> inv_mass{1.0 / mass_, 0.0, 0.0, 0.0};
    const std::vector<Vec3> body_step(3, Vec3::Zero()), v{v_}, predicted{v_ + kStep * gravity};
    const std::vector<Vec3> unbalanced{mass_ * kStep * all};
    ContactPoint contact{{0, 1, 2, 3}, {1.0, -1.0, 0.0, 0.0}, normal_, gap(), rest_gap_, mu_};
    ContactForce force;
    ResponseStep step{{x_t0, inv_mass, 1, kStep}, {&mass_, 1}, body_step, v, predicted};
    if (pull_ > 0.0) step.unbalanced = unbalanced;
    force.begin(step);
    force.add({&contact, 1});
    std::vector<Vec3> end{v_};
    for (int solve = 0; solve < 8; ++solve) {
      ++solves_;
      Mat3 a = mass_ * Mat3::Identity();
      Vec3 b = mass_ * (v_ + kStep * all);
      for (const ImplicitTerm& t : force.terms()) {
        a += t.matrix;
        b += t.rhs;
      }
      end[0] = a.inverse() * b;
      if (!force.update(end)) break;
    }
    v_ = end[0];
    x_ += kStep * v_;
  }

  double mu_, pull_, mass_ = 0.01, rest_gap_ = 0.002;
  Vec3 normal_, x_, v_ = Vec3::Zero();
  int solves_ = 0;
};

constexpr double kIncline = 30.0 * 3.14159265358979323846 / 180.0;

TEST(ContactForce, SticksOnTheInclineWhenFrictionExceedsTheSlope) {
  Block block(kIncline, 0.6);  // tan 30° = 0.577
  const Vec3 start = block.position();
  block.run(10.0);
  EXPECT_LT((block.position() - start).head<2>().norm(), 1e-6);
  EXPECT_NEAR(block.gap(), 0.002, 3e-6);  // yields by g cos θ h²/normal_ratio = 2e-6 m
}

TEST(ContactForce, SlidesDownTheInclineWithCoulombsAcceleration) {
  Block block(kIncline, 0.3);  // a = g (sin θ - μ cos θ) = 2.35629 m/s²
  const Vec3 start = block.position();
  block.run(1.0);
  EXPECT_NEAR(block.velocity().norm(), 2.35629, 0.002 * 2.35629);
  EXPECT_NEAR((block.position() - start).norm(), 1.17814, 0.02 * 1.17814);  // O(h)
}

TEST(ContactForce, StopsASlidingBlockWhereCoulombSays) {
  Block block(0.0, 0.3);
  block.velocity() = Vec3(1, 0, 0);
  block.run(1.0);
  EXPECT_NEAR(block.position().x(), 0.16990, 0.03 * 0.16990);  // O(h)
  EXPECT_LT(block.velocity().norm(), 1e-6);
}

TEST(ContactForce, RestsWithOneSolveAStep) {
  Block block(0.0, 0.3);
  block.run(1.0);
  EXPECT_LE(block.solves(), 121);
}

// If the target followed the gap whatever the load, both would sink through the plane.
TEST(ContactForce, BearsHundredsOfTimesItsWeight) {
  for (const double times : {400.0, 2000.0}) {
    Block block(0.0, 0.3, (times - 1.0) * 0.01 * 9.81);
    // It yields by g h²/300 for each of its weights, but by at most a tenth of its rest gap.
    const double yield = std::min(times * 9.81 * kStep * kStep / 300.0, 0.0002);
    block.lower(0.9 * yield);
    block.run(1.0);
    EXPECT_NEAR(block.gap(), 0.002 - yield, 0.01 * yield) << times;
    EXPECT_LT(block.velocity().norm(), 1e-9) << times;
    EXPECT_LE(block.solves(), 121) << times;
  }
}

// Stiffness in proportion to load over rest gap without a limit would exceed single precision.
TEST(ContactForce, ATinyRestGapDoesNotMakeAContactStiffWithoutLimit) {
  const std::vector<Vec3> x_t0{Vec3::Zero(), Vec3::Zero()}, rest(1, Vec3::Zero());
  const std::vector<double> mass{0.01}, inv_mass{100.0, 0.0};
  const std::vector<Vec3> unbalanced{Vec3(0.0, 0.0, -1e-4)};
  const ContactPoint contact{{0, 1, 1, 1}, {1.0, -1.0, 0.0, 0.0}, Vec3::UnitZ(), 1e-12, 1e-12, 0.0};
  ResponseStep step{{x_t0, inv_mass, 1, kStep}, mass, rest, rest, rest};
  step.unbalanced = unbalanced;
  ContactForce force;
  force.begin(step);
  force.add({&contact, 1});
  ASSERT_EQ(force.terms().size(), 1u);
  EXPECT_NEAR(force.terms()[0].matrix(2, 2), 1e4 * 300.0 * 0.01, 1e-6);
}

// An edge of a free and a held particle between two bodies, nearer to the first than the rest gap.
TEST(ContactForce, BesideAHeldParticleAFreeOneRecoversItsShare) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> power(-8.0, 0.0);
  for (int draw = 0; draw < 100; ++draw) {
    const double w = std::pow(10.0, power(random)), gap = 4e-4, rest_gap = 2e-3, mass_0 = 5e-6;
    SCOPED_TRACE(w);
    const std::vector<Vec3> x_t0{Vec3::Zero(), Vec3::UnitX(), Vec3::Zero(), Vec3::UnitY()};
    const std::vector<double> mass{mass_0, mass_0}, inv_mass{1.0 / mass_0, 0.0, 0.0, 0.0};
    const std::vector<Vec3> body_step(2, Vec3(0.0, 0.0, 1e-4)), v(2, Vec3::Zero());
    const std::vector<Vec3> unbalanced(2, Vec3::Zero());
    const ContactPoint contact{{0, 1, 2, 3}, {w, 1.0 - w, -0.5, -0.5}, Vec3::UnitZ(), gap, rest_gap,
                               0.0,          ContactKind::edge_edge};
    ResponseStep step{{x_t0, inv_mass, 2, kStep}, mass, body_step, v, v};
    step.unbalanced = unbalanced;
    ContactForce force;
    force.begin(step);
    force.add({&contact, 1});
    std::vector<Vec3> end = v;
    for (int solve = 0; solve < 8; ++solve) {
      Mat3 a = mass_0 * Mat3::Identity();
      Vec3 b = Vec3::Zero();
      for (const ImplicitTerm& t : force.terms()) {
        a += w * w * t.matrix;
        b += w * t.rhs;
      }
      end[0] = a.inverse() * b;
      if (!force.update(end)) break;
    }
    const double moved = kStep * end[0].z();
    EXPECT_GE(moved, 0.0);
    EXPECT_LE(moved, 1.3 * (rest_gap - gap + 1e-4));
    if (w > 0.1) {
      EXPECT_GT(moved, 1e-5);
    }
  }
}

TEST(ContactForce, StopsAFastFallWithoutBounce) {
  Block block(0.0, 0.3);
  block.velocity() = Vec3(0, 0, -40.0);
  block.run(kStep);
  EXPECT_GT(block.gap(), 0.0);
  block.run(0.5);
  EXPECT_NEAR(block.gap(), 0.002, 1e-4);
  EXPECT_LT(block.velocity().norm(), 1e-3);
}

/// Particles in a narrow cage of random contacts without friction, and the solves of one step.
class Cage {
 public:
  explicit Cage(unsigned seed) : random_(seed) {
    for (std::size_t i = 0; i < kParticles; ++i) {
      v_start_.push_back(vector(0.1));
      predicted_.push_back(v_start_.back() + vector(std::pow(10.0, 2.0 * uniform_(random_))));
      mass_.push_back(std::pow(10.0, uniform_(random_)));
      inv_mass_.push_back(1.0 / mass_.back());
    }
    for (int c = 0; c < kContacts; ++c) {
      ContactPoint point{{}, {0.5, 0.5, -0.3, -0.7}, vector(1.0).normalized(), 0.0, 0.002, 0.0};
      for (auto& i : point.vertex) i = static_cast<std::int32_t>(random_() % kParticles);
      point.gap = 0.0015 + 0.001 * std::abs(uniform_(random_));
      contacts_.push_back(point);
    }
    force_.begin({{x_, inv_mass_, kParticles, kStep}, mass_, {}, v_start_, predicted_});
    force_.add(contacts_);
  }

  /// One solve. Returns false if the contacts need no other one.
  bool solve() {
    constexpr auto n = static_cast<Eigen::Index>(3 * kParticles);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    for (std::size_t i = 0; i < kParticles; ++i) {
      a.diagonal().segment<3>(3 * i).setConstant(mass_[i]);
      b.segment<3>(3 * i) = mass_[i] * predicted_[i];
    }
    for (const ImplicitTerm& t : force_.terms())
      for (int k = 0; k < 4; ++k) {
        b.segment<3>(3 * t.particle[k]) += t.weight[k] * t.rhs;
        for (int l = 0; l < 4; ++l)
          a.block<3, 3>(3 * t.particle[k], 3 * t.particle[l]) +=
              t.weight[k] * t.weight[l] * t.matrix;
      }
    const Eigen::VectorXd solution = testing::solve_dense(a, b);
    before = v;
    solved.resize(kParticles);
    for (std::size_t i = 0; i < kParticles; ++i) solved[i] = solution.segment<3>(3 * i);
    v = solved;
    return force_.update(v);
  }

  /// Derivative of the energy of the step at `at`, on the way of the last solve: that of inertia,
  /// ½ m |v - predicted|², and of the contacts, ½ k violation².
  double slope(const std::vector<Vec3>& at) const {
    const ContactForceConfig config;
    double sum = 0.0;
    for (std::size_t i = 0; i < kParticles; ++i)
      sum += mass_[i] * (at[i] - predicted_[i]).dot(solved[i] - before[i]);
    for (const ContactPoint& c : contacts_) {
      Vec3 u = Vec3::Zero(), way = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        u += c.weight[k] * kStep * at[c.vertex[k]];
        way += c.weight[k] * kStep * (solved[c.vertex[k]] - before[c.vertex[k]]);
      }
      const double target = std::min(c.rest_gap, c.gap + config.recovery * c.rest_gap);
      const double violation = std::max(0.0, target - c.gap - c.normal.dot(u));
      const double stiffness = config.normal_ratio / compliance(c, inv_mass_) / (kStep * kStep);
      sum -= stiffness * violation * c.normal.dot(way);
    }
    return sum;
  }

  std::vector<Vec3> before, solved, v;  ///< the last solve began, ended, and was pulled back to

 private:
  static constexpr std::size_t kParticles = 6;
  static constexpr int kContacts = 24;

  Vec3 vector(double size) {
    return size * Vec3(uniform_(random_), uniform_(random_), uniform_(random_));
  }

  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
  std::vector<Vec3> x_ = std::vector<Vec3>(kParticles, Vec3::Zero()), v_start_, predicted_;
  std::vector<double> mass_, inv_mass_;
  std::vector<ContactPoint> contacts_;
  ContactForce force_;
};

TEST(ContactForce, ASolveEndsWhereTheEnergyOnItsWayIsLeast) {
  int pulled_back = 0;
  for (unsigned seed = 0; seed < 500; ++seed) {
    Cage cage(seed);
    cage.solve();
    for (int solve = 1; solve < 12 && cage.solve(); ++solve) {
      const double start = cage.slope(cage.before), end = cage.slope(cage.v);
      if (cage.v == cage.solved) {
        EXPECT_LE(end, std::max(0.0, -0.0501 * start)) << seed << ", " << solve;
      } else {
        ++pulled_back;
        EXPECT_LE(std::abs(end), 0.0501 * std::abs(start)) << seed << ", " << solve;
      }
    }
  }
  EXPECT_GT(pulled_back, 500);
}

}  // namespace
}  // namespace selvedge::response_test
