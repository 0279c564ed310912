// SPDX-License-Identifier: MIT
// Static friction over time: cloth that sticks stays, cloth that slides does so as Coulomb says,
// and both do so however the scene lies in the axes. `bench rest creep` prints the same for longer
// runs.
#include <gtest/gtest.h>
#include <selvedge/response/detail/contact_memory.h>
#include <selvedge/scene/build.h>
#include <selvedge/simulation/simulation.h>
#include <selvedge/simulation/simulation_state.h>
#include <selvedge/simulation/step_report.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>

namespace selvedge::friction_test {
namespace {

using namespace detail;

constexpr double kGravity = 9.81;  // m/s²
constexpr double kFrame = 1.0 / 60.0;
constexpr int kReleased = 36;  // frame in which the strip in the jaws is let go
constexpr int kAlong = 12, kAcross = 4;
constexpr int kRow = kAcross + 1;
constexpr double kStrip = 0.2 * 0.04 * 0.12;  // kg

/// Height of the lower edge of the jaws, m: at a row of the strip, or between two, so that a strip
/// that gives way a little keeps all rows in the jaws.
constexpr double kAtRow = 0.03, kBetweenRows = 0.025;

BodySpec jaw(double side, double friction, double edge) {
  BodySpec body;
  body.name = side > 0.0 ? "front" : "back";
  body.shape = BodyShape{Box{{0.06, 0.02, 0.03}}, 3};
  body.friction = friction;
  body.placement.translation = Vec3(0.0, side * 0.016, edge + 0.015);
  Keyframe closed;
  closed.time = 0.4;
  closed.translation = Vec3(0.0, side * -0.0048, 0.0);
  body.motion = {Keyframe{}, closed};
  return body;
}

/// A strip that hangs with a load between two jaws, which close to 0.6 rest gaps on each side. Its
/// upper edge is held until then.
Scene jaws(double load, double friction, double edge) {
  Scene scene;
  scene.name = "jaws";
  Material& m = scene.materials["default"];
  m.density = 0.2;
  m.stretch_stiffness = 3000.0;
  m.bending_stiffness = 1e-5;
  m.spring_damping = m.bending_damping = 0.02;
  ClothSpec& strip = scene.cloths.emplace_back();
  strip.name = "strip";
  strip.shape = ClothGrid{"rectangular", {0.04, 0.12, kAcross, kAlong}};
  strip.placement.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX());
  HandleSpec& top = scene.handles.emplace_back();
  top.name = "top";
  top.geometry = strip.name;
  top.release = kReleased * kFrame;
  // It hands the load over to the jaws: let go at once, the load would bounce and slip.
  Keyframe held, lowered;
  held.time = 0.4;
  lowered.time = *top.release;
  lowered.translation = Vec3(0.0, 0.0, -0.001);
  top.motion = {Keyframe{}, held, lowered};
  WeightSpec& weight = scene.weights.emplace_back();
  weight.name = "load";
  weight.geometry = strip.name;
  weight.mass = load / kRow;
  for (std::int32_t i = 0; i < kRow; ++i) {
    top.vertices.push_back(kAlong * kRow + i);
    weight.vertices.push_back(i);
  }
  scene.bodies = {jaw(1.0, friction, edge), jaw(-1.0, friction, edge)};
  return scene;
}

/// Σ μN over the contacts of the last step, N.
double friction_limit(const Simulation& simulation) {
  double sum = 0.0;
  for (const StepContact& c : simulation.contacts())
    sum += c.point.friction * c.point.normal.dot(c.impulse);
  return sum / simulation.last_step().lengths.back();
}

/// The load with which the strip pulls at this share of what friction can hold, kg.
double load_at(double share, double friction, double edge) {
  const Scene scene = jaws(0.0, friction, edge);
  Simulation simulation(scene);
  simulation.advance_to_frame(kReleased + 24);
  return share * friction_limit(simulation) / kGravity - kStrip;
}

/// Largest distance along the jaws, m.
double largest_slip(const std::vector<Vec3>& a, const std::vector<Vec3>& b,
                    const std::vector<std::int32_t>& of) {
  double largest = 0.0;
  for (const std::int32_t i : of)
    largest = std::max(largest, std::hypot(a[i].x() - b[i].x(), a[i].z() - b[i].z()));
  return largest;
}

/// The particles that contacts press.
std::vector<std::int32_t> touching(const Simulation& simulation) {
  std::vector<std::int32_t> list;
  const auto n = static_cast<std::int32_t>(simulation.positions().size());
  for (const StepContact& c : simulation.contacts())
    for (const std::int32_t i : c.point.vertex)
      if (i < n && !c.impulse.isZero(0.0)) list.push_back(i);
  return list;
}

TEST(StaticFriction, AStripInJawsDoesNotSinkBelow95PercentOfItsLimit) {
  std::mt19937 random(20261128);
  std::uniform_real_distribution<double> shares(0.2, 0.94), frictions(0.2, 0.8);
  for (int draw = 0; draw < 6; ++draw) {
    const double share = shares(random), friction = frictions(random);
    Simulation simulation(jaws(load_at(share, friction, kBetweenRows), friction, kBetweenRows));
    simulation.advance_to_frame(180);
    const std::vector<Vec3> start = simulation.state().x;
    const std::vector<std::int32_t> gripped = touching(simulation);
    ASSERT_GE(gripped.size(), 10u);
    const int seconds = draw == 0 ? 60 : 6;
    simulation.advance_to_frame(180 + 60 * seconds);
    EXPECT_LT(largest_slip(simulation.state().x, start, gripped), seconds * 1e-7)
        << share << " of the limit, friction " << friction;
  }
}

TEST(StaticFriction, AStripThatSlidesOutOfJawsIsBrakedAsCoulombSays) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shares(1.2, 3.0), frictions(0.2, 0.8);
  for (int draw = 0; draw < 4; ++draw) {
    const double share = shares(random), friction = frictions(random);
    const Scene scene = jaws(load_at(share, friction, kAtRow), friction, kAtRow);
    BuiltScene built = build_scene(scene);
    const std::vector<double> mass = built.cloth.mass;
    Simulation simulation(scene, std::move(built));
    const auto momentum = [&] {
      double sum = 0.0;
      for (std::size_t i = 0; i < mass.size(); ++i) sum += mass[i] * simulation.state().v[i].z();
      return sum;
    };
    simulation.advance_to_frame(kReleased + 2);  // its stretch lets go first
    const double before = momentum(),
                 weight = kGravity * std::accumulate(mass.begin(), mass.end(), 0.0);
    double time = 0.0, braking = 0.0;  // s, N·s
    simulation.advance_to_frame(kReleased + 5, [&](double) {
      const double h = simulation.last_step().lengths.back();
      time += h;
      braking += h * friction_limit(simulation);
    });
    ASSERT_GT(braking, 0.2 * weight * time / share);
    EXPECT_NEAR(momentum() - before, braking - weight * time, 0.01 * braking)
        << share << " of the limit, friction " << friction;
  }
}

TEST(StaticFriction, ARunThatContinuesHasTheSameBits) {
  const Scene scene = jaws(0.01, 0.5, kAtRow);
  Simulation whole(scene);
  whole.advance_to_frame(60);
  const SimulationState middle = whole.state();
  EXPECT_FALSE(middle.contact_memory.empty());
  whole.advance_to_frame(90);
  Simulation resumed(scene);
  resumed.restore(middle);
  resumed.advance_to_frame(90);
  EXPECT_EQ(state_hash(resumed.state()), state_hash(whole.state()));
  EXPECT_EQ(resumed.state().contact_memory, whole.state().contact_memory);
  SimulationState other = middle;
  other.contact_memory.pop_back();
  EXPECT_THROW(resumed.restore(other), std::invalid_argument);
  other = middle;
  other.contact_memory[0] = 1e6;  // no vertex
  EXPECT_THROW(resumed.restore(other), std::invalid_argument);
}

TEST(ContactMemory, FindsAPointOverTheNextTriangleButNotOnAnotherSide) {
  constexpr std::size_t kParticles = 10;
  ContactMemory memory;
  memory.add({ContactKind::point_triangle,
              {3, 10, 11, 12},
              Vec3::UnitZ(),
              Vec3(1.0, 0.0, 0.0),
              5.0,
              true});
  memory.add({ContactKind::point_triangle,
              {3, 10, 12, 13},
              Vec3::UnitX(),
              Vec3(0.0, 2.0, 0.0),
              6.0,
              true});
  const auto load = [&](ContactKind kind, const std::array<std::int32_t, 4>& vertex,
                        const Vec3& normal) {
    const ContactPoint contact{
        .vertex = vertex, .weight = {1, -1, 0, 0}, .normal = normal, .kind = kind};
    const ContactMemory::Past* found = memory.find(contact, kParticles);
    return found == nullptr ? 0.0 : found->load;
  };
  const ContactKind point = ContactKind::point_triangle;
  EXPECT_EQ(load(point, {3, 10, 11, 12}, Vec3::UnitZ()), 5.0);
  EXPECT_EQ(load(point, {3, 12, 13, 14}, Vec3(0.2, 0.0, 1.0).normalized()), 5.0);
  EXPECT_EQ(load(point, {3, 12, 13, 14}, Vec3::UnitX()), 6.0);
  EXPECT_EQ(load(point, {3, 12, 13, 14}, -Vec3::UnitZ()), 0.0);
  EXPECT_EQ(load(point, {4, 10, 11, 12}, Vec3::UnitZ()), 0.0);
  EXPECT_EQ(load(point, {3, 5, 6, 7}, Vec3::UnitZ()), 0.0);  // on the cloth itself
  memory.add({ContactKind::edge_edge, {3, 4, 12, 13}, Vec3::UnitZ(), Vec3::Zero(), 7.0, false});
  EXPECT_EQ(load(ContactKind::edge_edge, {3, 4, 12, 13}, Vec3::UnitZ()), 7.0);
  EXPECT_EQ(load(ContactKind::edge_edge, {3, 4, 12, 14}, Vec3::UnitZ()), 0.0);
  std::vector<double> saved;
  memory.save(saved);
  ContactMemory copy;
  copy.restore(saved, 14);
  std::vector<double> again;
  copy.save(again);
  EXPECT_EQ(again, saved);
  EXPECT_THROW(copy.restore(saved, 13), std::invalid_argument);
  memory.clear();
  EXPECT_EQ(load(point, {3, 10, 11, 12}, Vec3::UnitZ()), 0.0);
}

// -- the axes -------------------------------------------------------------------------------------

enum class Below { box, cylinder, ball };

AnalyticShape shape_of(Below below) {
  if (below == Below::box) return Box{{0.2, 0.16, 0.1}};
  if (below == Below::cylinder) return Cylinder{0.09, 0.1};
  return Sphere{0.1};
}

/// A sheet that falls on a body, all turned by `turn`; the sheet starts `beside` its place, m.
Scene fallen(Below below, const Eigen::Quaterniond& turn, double beside = 0.0) {
  Scene scene;
  scene.name = "fallen";
  scene.materials["default"] = Material{};
  scene.gravity = turn * Vec3(0.0, 0.0, -kGravity);
  ClothSpec& cloth = scene.cloths.emplace_back();
  cloth.name = "cloth";
  cloth.shape = ClothGrid{"rectangular", {0.4, 0.4, 16, 16}};
  const double height = below == Below::ball ? 0.105 : 0.055;
  cloth.placement.translation = turn * Vec3(0.013 + beside, 0.017, height);
  cloth.placement.rotation = turn;
  BodySpec& body = scene.bodies.emplace_back();
  body.name = "body";
  body.shape = BodyShape{shape_of(below), below == Below::box ? 3 : 16};
  body.friction = 0.3;
  body.placement.rotation = turn;
  return scene;
}

/// Largest distance between two scenes in the first second, the second one turned back, m.
double apart(const Scene& scene, const Scene& other, const Eigen::Quaterniond& turn) {
  Simulation straight(scene), turned(other);
  double worst = 0.0;
  for (int frame = 1; frame <= 60; ++frame) {
    straight.advance_to_frame(frame);
    turned.advance_to_frame(frame);
    for (std::size_t i = 0; i < straight.positions().size(); ++i)
      worst = std::max(worst,
                       (turn.inverse() * turned.positions()[i] - straight.positions()[i]).norm());
  }
  return worst;
}

const std::array<Vec3, 3> kAxes{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};

Eigen::Quaterniond quarter_turn(const Vec3& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi, axis));
}

Scene damped(Scene scene) {
  scene.solver.integrator = "implicit_euler";
  return scene;
}

const Eigen::Quaterniond kAsItIs = Eigen::Quaterniond::Identity();

// The arithmetic knows no axes: in motion that is damped, rounding decides nothing that is visible.
// Before the solver turned with the cloth, 7 mm.
TEST(StaticFriction, ASceneThatIsTurnedWithItsBodiesEndsTheSame) {
  const Scene scene = damped(fallen(Below::cylinder, kAsItIs));
  for (const Vec3& axis : kAxes) {
    const Eigen::Quaterniond turn = quarter_turn(axis);
    EXPECT_LT(apart(scene, damped(fallen(Below::cylinder, turn)), turn), 1e-3) << axis.transpose();
  }
}

// Cloth that falls freely onto a body moves so that differences grow: a turned scene, which rounds
// otherwise, ends elsewhere, as one does that starts a hair beside. So does cloth that slides off
// the edges of a box, damped or not. Prints both (docs/response.md).
TEST(StaticFriction, FallingClothIsAsSensitiveToATurnAsToAHair) {
  struct Case {
    Below below;
    bool damps;
    const char* name;
  };
  for (const Case& c :
       {Case{Below::ball, false, "ball"}, Case{Below::box, false, "box"},
        Case{Below::cylinder, false, "cylinder"}, Case{Below::box, true, "box, damped"}}) {
    const auto scene = [&c](const Eigen::Quaterniond& turn, double beside) {
      const Scene falls = fallen(c.below, turn, beside);
      return c.damps ? damped(falls) : falls;
    };
    double turned = 0.0, beside = 0.0;
    for (const Vec3& axis : kAxes) {
      const Eigen::Quaterniond turn = quarter_turn(axis);
      turned = std::max(turned, apart(scene(kAsItIs, 0.0), scene(turn, 0.0), turn));
    }
    for (const double hair : {1e-13, 2e-12, 1e-9})
      beside = std::max(beside, apart(scene(kAsItIs, 0.0), scene(kAsItIs, hair), kAsItIs));
    std::printf("%s: turned by 90 degrees %.2f mm elsewhere, a hair beside %.2f mm\n", c.name,
                1e3 * turned, 1e3 * beside);
    EXPECT_LT(turned, 10.0 * beside) << c.name;
  }
}

}  // namespace
}  // namespace selvedge::friction_test
