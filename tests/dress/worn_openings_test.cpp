// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/dress/detail/skin_distance.h>
#include <selvedge/dress/detail/worn_openings.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace selvedge::worn_openings_test {
namespace {

namespace fs = std::filesystem;

/// A mannequin, its landmarks, and distances along its skin from head, hands and feet.
struct Person {
  TriangleMesh body;
  BodyLandmarks marks;
  std::vector<Vec3> normals;
  std::vector<double> from_head;
  std::array<std::vector<double>, 2> from_hand, from_foot;
};

TriangleMesh mannequin(const char* name = "mannequin_arms_out.ply") {
  return read_mesh(fs::path(SELVEDGE_SOURCE_DIR) / "data/bodies" / name);
}

Person person(const Mat3& turn = Mat3::Identity(), const TriangleMesh& body = mannequin()) {
  Person p;
  p.body = body;
  for (Vec3& x : p.body.vertices) x = turn * x;
  p.marks = find_landmarks(p.body);
  p.normals = vertex_normals(p.body.vertices, p.body.triangles);
  const detail::SkinDistance skin(p.body);
  const auto from = [&](const Vec3& tip) {
    const auto nearest = std::min_element(
        p.body.vertices.begin(), p.body.vertices.end(),
        [&](const Vec3& a, const Vec3& b) { return (a - tip).norm() < (b - tip).norm(); });
    const auto v = static_cast<std::int32_t>(nearest - p.body.vertices.begin());
    return skin.from(std::span(&v, 1));
  };
  p.from_head = from(p.marks.top);
  for (int k = 0; k < 2; ++k) {
    p.from_hand[k] = from(p.marks.arms[k].tip);
    p.from_foot[k] = from(p.marks.legs[k].tip);
  }
  return p;
}

/// A garment a centimetre outside of the part of the skin that `covers` chooses by its vertices;
/// `skin` gets the vertices of the body under it.
detail::Garment second_skin(const Person& p, const std::function<bool(std::size_t)>& covers,
                            std::vector<std::size_t>* skin = nullptr) {
  detail::Garment garment;
  std::map<std::int32_t, std::int32_t> number;
  for (const Triangle& t : p.body.triangles) {
    if (!std::all_of(t.begin(), t.end(), [&](std::int32_t v) { return covers(v); })) continue;
    Triangle& own = garment.surface.triangles.emplace_back(t);
    for (std::int32_t& v : own) {
      const auto [place, is_new] =
          number.try_emplace(v, static_cast<std::int32_t>(garment.surface.vertices.size()));
      if (is_new) {
        garment.surface.vertices.push_back(p.body.vertices[v] + 0.01 * p.normals[v]);
        if (skin) skin->push_back(v);
      }
      v = place->second;
    }
  }
  garment.flat = garment.surface;
  garment.corner.resize(garment.flat.vertices.size());
  std::iota(garment.corner.begin(), garment.corner.end(), 0);
  garment.panel_of_triangle.assign(garment.surface.triangles.size(), 0);
  return garment;
}

DressResult measured(const detail::Garment& start, const detail::Garment& worn, const Person& p,
                     std::vector<std::string> names = {"shell"}) {
  DressResult r;
  r.clean = r.sewn = r.at_rest = true;
  r.strain_limit = 0.8;
  r.wearable_stretch = 0.3;
  r.largest_drop = 0.2;
  r.panel_names = std::move(names);
  r.panel_drop.assign(r.panel_names.size(), 0.0);
  r.panel_folded = r.panel_drop;
  detail::measure_openings(start, worn, p.marks, r);
  return r;
}

using Parts = std::vector<std::string>;
std::multiset<Parts> parts_of(const DressResult& r) {
  std::multiset<Parts> all;
  for (const GarmentOpening& opening : r.openings) all.insert(opening.parts);
  return all;
}

/// Cuts of a suit, m along the skin from head, hands and feet.
struct Suit {
  double neck = 0.3;
  std::array<double, 2> cuffs = {0.4, 0.4}, legs = {0.5, 0.5};
  bool covers(const Person& p, std::size_t v) const {
    bool is_covered = p.from_head[v] > neck;
    for (int k = 0; k < 2; ++k)
      is_covered = is_covered && p.from_hand[k][v] > cuffs[k] && p.from_foot[k][v] > legs[k];
    return is_covered;
  }
};

Suit random_suit(std::mt19937& random) {
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  return {.neck = draw(0.26, 0.34),
          .cuffs = {draw(0.05, 0.5), draw(0.05, 0.5)},
          .legs = {draw(0.2, 0.8), draw(0.2, 0.8)}};
}

/// A smooth step from 0 at `from` to 1 at `to`.
double step(double at, double from, double to) {
  const double s = std::clamp((at - from) / (to - from), 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

TEST(WornOpenings, EachPartComesOutOfItsOwn) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(-3.0, 3.0);
  for (int seed = 0; seed < 6; ++seed) {
    const Mat3 turn =
        (Eigen::AngleAxisd(seed == 0 ? 0.0 : angle(random), Vec3(1.0, 2.0, 3.0).normalized()))
            .toRotationMatrix();
    const Person p = person(turn);
    const Suit suit = random_suit(random);
    const detail::Garment worn = second_skin(p, [&](std::size_t v) { return suit.covers(p, v); });
    const DressResult r = measured(worn, worn, p);
    EXPECT_EQ(parts_of(r), (std::multiset<Parts>{
                               {"head"}, {"left arm"}, {"right arm"}, {"left leg"}, {"right leg"}}))
        << seed;
    EXPECT_EQ(r.verdict(), "good") << seed;
    EXPECT_LT(r.panel_turned[0], 1e-6);
  }
}

TEST(WornOpenings, ASkirtHasTwo) {
  const Person p = person();
  std::mt19937 random(8);
  std::uniform_real_distribution<double> height(0.15, 0.25), hem(0.8, 0.95);
  for (int seed = 0; seed < 8; ++seed) {
    // Below the crotch the skin of each leg is a tube; the skirt is around both: a short one.
    const double low = hem(random), high = low + height(random);
    const detail::Garment worn = second_skin(p, [&](std::size_t v) {
      const double z = p.body.vertices[v].z();
      return z > low && z < high && std::abs(p.body.vertices[v].x()) < 0.25;
    });
    const DressResult r = measured(worn, worn, p);
    EXPECT_EQ(parts_of(r),
              (std::multiset<Parts>{{"head", "left arm", "right arm"}, {"left leg", "right leg"}}))
        << seed;
  }
}

/// The suit with one sleeve or leg beside its limb.
DressResult beside(const Person& p, const Suit& suit, const std::vector<double>& from_tip,
                   double root, const Vec3& by) {
  std::vector<std::size_t> skin;
  const detail::Garment start = second_skin(
      p, [&](std::size_t v) { return suit.covers(p, v); }, &skin);
  detail::Garment worn = start;
  for (std::size_t v = 0; v < skin.size(); ++v)
    worn.surface.vertices[v] += step(-from_tip[skin[v]], -root, 0.15 - root) * by;
  return measured(start, worn, p);
}

TEST(WornOpenings, ASleeveBesideItsArmIsNamed) {
  const Person p = person();
  std::mt19937 random(9);
  std::uniform_real_distribution<double> angle(-3.1, 3.1), way(0.25, 0.4);
  for (int seed = 0; seed < 20; ++seed) {
    const int side = seed % 2;
    const double turn = angle(random);
    const Vec3 by = way(random) * (std::cos(turn) * p.marks.up + std::sin(turn) * p.marks.forward);
    Suit suit = random_suit(random);
    suit.cuffs[side] = std::min(suit.cuffs[side], 0.35);
    const DressResult r = beside(p, suit, p.from_hand[side], 0.6, by);
    EXPECT_EQ(parts_of(r).count({}), 1u) << seed;
    EXPECT_NE(r.verdict().find("worn, but no head, arm or leg comes out of the opening of panel"),
              std::string::npos)
        << seed << " " << r.verdict();
  }
}

TEST(WornOpenings, ALegBesideItsTrouserLegIsNamed) {
  const Person p = person();
  std::mt19937 random(10);
  std::uniform_real_distribution<double> angle(-0.8, 0.8), way(0.25, 0.4);
  for (int seed = 0; seed < 20; ++seed) {
    const int side = seed % 2;
    const double turn = angle(random);  // not to the other leg
    const Vec3 by = way(random) * ((seed % 4 < 2 ? 1.0 : -1.0) * std::cos(turn) * p.marks.forward +
                                   std::sin(turn) * (side == 0 ? 1.0 : -1.0) * p.marks.left);
    Suit suit = random_suit(random);
    suit.legs[side] = std::min(suit.legs[side], 0.5);
    EXPECT_EQ(parts_of(beside(p, suit, p.from_foot[side], 0.8, by)).count({}), 1u) << seed;
  }
}

/// A suit without sleeves and legs. Where limbs leave it, it ends in planes close to the trunk,
/// tilted at random; those of the arms pass the armpit, which may be far above the bust.
TEST(WornOpenings, LimbsLeaveOpeningsCloseToTheTrunk) {
  std::mt19937 random(16);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int seed = 0; seed < 24; ++seed) {
    TriangleMesh body = mannequin(seed % 2 == 0 ? "mannequin_arms_out.ply" : "mannequin.ply");
    const double bust = draw(1.1, 1.22), full = draw(0.2, 0.4);
    for (Vec3& x : body.vertices)
      x.y() *= 1.0 + full * std::exp(-std::pow((x.z() - bust) / 0.06, 2.0));
    const Person p = person(Mat3::Identity(), body);
    const BodyLandmarks& m = p.marks;
    std::array<Vec3, 2> armhole, leg, from_armhole, from_leg;
    for (int k = 0; k < 2; ++k) {
      const Vec3 out = k == 0 ? m.left : Vec3(-m.left);
      armhole[k] = m.armpit[k] - draw(-0.01, 0.02) * out;
      from_armhole[k] = (out + draw(0.0, 0.2) * m.up + draw(-0.2, 0.2) * m.forward).normalized();
      leg[k] = m.crotch + draw(0.02, 0.04) * out;
      from_leg[k] = (out - draw(0.5, 1.5) * m.up + draw(-0.2, 0.2) * m.forward).normalized();
    }
    const detail::Garment worn = second_skin(p, [&](std::size_t v) {
      const Vec3& x = p.body.vertices[v];
      const int k = x.dot(m.left) > m.crotch.dot(m.left) ? 0 : 1;
      const bool is_by_arm = p.from_hand[k][v] < p.from_foot[k][v];
      if (p.from_head[v] < 0.27) return false;
      if (!is_by_arm) return from_leg[k].dot(x - leg[k]) < 0.0;
      const Vec3 from = x - m.armpit[k];
      const bool is_side = from.dot(m.up) < 0.0 && from.dot(m.left) * (k == 0 ? 1.0 : -1.0) < 0.02;
      return is_side || from_armhole[k].dot(x - armhole[k]) < 0.0;
    });
    const DressResult r = measured(worn, worn, p);
    EXPECT_EQ(parts_of(r), (std::multiset<Parts>{
                               {"head"}, {"left arm"}, {"right arm"}, {"left leg"}, {"right leg"}}))
        << seed;
    EXPECT_EQ(r.verdict(), "good") << seed;
  }
}

TEST(WornOpenings, AGarmentBesideTheBodyHasOnlyEmptyOnes) {
  const Person p = person();
  const Suit suit;
  const detail::Garment start = second_skin(p, [&](std::size_t v) { return suit.covers(p, v); });
  detail::Garment worn = start;
  for (Vec3& x : worn.surface.vertices) x += Vec3(0.0, 0.6, 0.0);
  EXPECT_EQ(parts_of(measured(start, worn, p)).count({}), 5u);
}

/// A hole in the cloth around a point of the trunk, which shows skin that belongs there.
TEST(WornOpenings, AKeyholeIsNoFault) {
  const Person p = person();
  std::mt19937 random(15);
  std::uniform_real_distribution<double> radius(0.045, 0.09), height(1.05, 1.3), angle(-3.1, 3.1);
  for (int seed = 0; seed < 16; ++seed) {
    const double z = height(random), turn = angle(random), size = radius(random);
    const Vec3 way(std::cos(turn), std::sin(turn), 0.0);
    std::size_t at = 0;
    const auto reach = [&](std::size_t v) {
      const Vec3& x = p.body.vertices[v];
      return std::abs(x.z() - z) < 0.03 && std::abs(x.x()) < 0.2 ? x.dot(way) : -1.0;
    };
    for (std::size_t v = 0; v < p.body.vertices.size(); ++v)
      if (reach(v) > reach(at)) at = v;
    const Vec3 middle = p.body.vertices[at];
    const bool is_open = seed % 4 == 3;  // in front, as a jacket
    const Suit suit;
    const detail::Garment worn = second_skin(p, [&](std::size_t v) {
      const Vec3& x = p.body.vertices[v];
      if (is_open && x.dot(p.marks.forward) > 0.0 && std::abs(x.x()) < 0.05) return false;
      return suit.covers(p, v) && (x - middle).norm() > size;
    });
    const DressResult r = measured(worn, worn, p);
    EXPECT_EQ(r.verdict(), "good") << seed;
    DressResult blind = r;
    for (GarmentOpening& opening : blind.openings) opening.is_hole = false;
    EXPECT_EQ(blind.verdict().find("no head, arm or leg") != std::string::npos,
              parts_of(r).contains({}))
        << seed;
    if (is_open && middle.dot(p.marks.forward) > 0.0) continue;
    EXPECT_EQ(std::count_if(r.openings.begin(), r.openings.end(),
                            [](const GarmentOpening& o) { return o.parts.empty(); }),
              1)
        << seed;
  }
}

TEST(WornOpenings, AHoodOffTheHeadIsNamed) {
  const Person p = person();
  const Vec3 head = 0.5 * (p.marks.top + p.marks.neck.middle);
  std::vector<std::size_t> skin;
  const auto covers = [&](std::size_t v) {
    const Vec3 from = p.body.vertices[v] - head;
    const bool is_face = from.norm() < 0.16 && from.normalized().dot(p.marks.forward) > 0.4;
    Suit suit;
    suit.neck = -1.0;
    return !is_face && suit.covers(p, v);
  };
  const detail::Garment start = second_skin(p, covers, &skin);
  EXPECT_EQ(measured(start, start, p).verdict(), "good");
  EXPECT_EQ(parts_of(measured(start, start, p)).count({"head"}), 1u);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> back(0.15, 0.25), down(0.15, 0.25);
  for (int seed = 0; seed < 10; ++seed) {
    detail::Garment worn = start;
    const Vec3 by = -back(random) * p.marks.forward - down(random) * p.marks.up;
    for (std::size_t v = 0; v < skin.size(); ++v)
      worn.surface.vertices[v] += step(-p.from_head[skin[v]], -0.3, -0.22) * by;
    const DressResult r = measured(start, worn, p, {"hood"});
    ASSERT_EQ(r.misworn.size(), 1u) << seed;
    EXPECT_EQ(r.misworn[0].kind, WornFault::Kind::hood) << seed;
    EXPECT_NE(r.verdict().find("panel \"hood\" does not cover the head"), std::string::npos)
        << r.verdict();
  }
}

TEST(WornOpenings, AHoodOverTheEyesIsWorn) {
  const Person p = person();
  std::mt19937 random(14);
  std::uniform_real_distribution<double> brow(0.5, 0.75);
  for (int seed = 0; seed < 10; ++seed) {
    // All of the face above the brow is covered, in shares of the way from the neck to the top.
    const double covered = brow(random);
    const auto covers = [&](std::size_t v) {
      const Vec3 from = p.body.vertices[v] - p.marks.neck.middle;
      const double share = from.dot(p.marks.up) / (p.marks.top - p.marks.neck.middle).norm();
      const bool is_face =
          share > 0.05 && share < covered && from.dot(p.marks.forward) > 0.3 * from.norm();
      Suit suit;
      suit.neck = -1.0;
      return !is_face && suit.covers(p, v);
    };
    const detail::Garment worn = second_skin(p, covers);
    const DressResult r = measured(worn, worn, p, {"hood"});
    EXPECT_EQ(r.verdict(), "good") << seed;
    EXPECT_EQ(parts_of(r).count({"head"}), 1u) << seed;
  }
}

TEST(WornOpenings, BackToFrontIsNamed) {
  const Person p = person(Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix());
  const Suit suit;
  detail::Garment worn = second_skin(p, [&](std::size_t v) { return suit.covers(p, v); });
  for (std::size_t i = 0; i < worn.surface.triangles.size(); ++i) {
    const Triangle& t = worn.surface.triangles[i];
    const std::vector<Vec3>& x = worn.surface.vertices;
    const Vec3 normal = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
    worn.panel_of_triangle[i] = normal.dot(p.marks.forward) > 0.0 ? 0 : 1;
  }
  EXPECT_EQ(measured(worn, worn, p, {"front", "back"}).verdict(), "good");
  EXPECT_EQ(measured(worn, worn, p, {"back", "front"}).verdict(),
            "worn, but panel \"back\" lies in front; panel \"front\" lies at the back");
}

TEST(WornOpenings, FacingsThatShowTheBodyTheirOuterSidesLieWhereTheyAre) {
  const Person p = person(Eigen::AngleAxisd(-0.4, Vec3::UnitZ()).toRotationMatrix());
  for (const double end : {0.4, 0.5, 0.6}) {
    detail::Garment worn =
        second_skin(p, [&](std::size_t v) { return Suit().covers(p, v) && p.from_head[v] < end; });
    for (std::size_t i = 0; i < worn.surface.triangles.size(); ++i) {
      Triangle& t = worn.surface.triangles[i];
      const std::vector<Vec3>& x = worn.surface.vertices;
      const Vec3 normal = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
      worn.panel_of_triangle[i] = normal.dot(p.marks.forward) > 0.0 ? 0 : 1;
      std::swap(t[1], t[2]);
    }
    worn.flat.triangles = worn.surface.triangles;
    EXPECT_TRUE(measured(worn, worn, p, {"facing_front", "facing_back"}).misworn.empty()) << end;
    EXPECT_EQ(measured(worn, worn, p, {"facing_back", "facing_front"}).misworn.size(), 2u) << end;
  }
}

TEST(WornOpenings, ATurnedPanelIsNamed) {
  const Person p = person();
  const Suit suit;
  const detail::Garment worn = second_skin(p, [&](std::size_t v) { return suit.covers(p, v); });
  std::mt19937 random(12);
  std::uniform_real_distribution<double> angle(0.0, 3.1);
  for (int seed = 0; seed < 10; ++seed) {
    const double turn = angle(random);
    detail::Garment start = worn;
    const Mat3 rotation = Eigen::AngleAxisd(turn, Vec3::UnitZ()).toRotationMatrix();
    for (Vec3& x : start.surface.vertices) x = rotation * x;
    const DressResult r = measured(start, worn, p);
    EXPECT_NEAR(r.panel_turned[0], turn, 1e-6) << seed;
    EXPECT_EQ(r.verdict().find("is turned by") != std::string::npos, turn > 1.75) << seed;
  }
}

TEST(BorderLoops, ThoseThatMeetInAVertexStayApart) {
  // Two squares with one common corner in a sheet: a hole of two parts that touch in it.
  TriangleMesh sheet;
  constexpr int kSide = 6;
  for (int i = 0; i <= kSide; ++i)
    for (int k = 0; k <= kSide; ++k) sheet.vertices.emplace_back(i, k, 0.0);
  for (int i = 0; i < kSide; ++i)
    for (int k = 0; k < kSide; ++k) {
      if ((i == 2 && k == 2) || (i == 3 && k == 3)) continue;
      const int a = i * (kSide + 1) + k;
      sheet.triangles.push_back({a, a + kSide + 1, a + kSide + 2});
      sheet.triangles.push_back({a, a + kSide + 2, a + 1});
    }
  std::vector<std::size_t> lengths;
  for (const detail::BorderLoop& loop : detail::border_loops(sheet.triangles))
    lengths.push_back(loop.size());
  std::sort(lengths.begin(), lengths.end());
  // Around a corner with two sheets, each loop follows its own sheet.
  EXPECT_EQ(std::accumulate(lengths.begin(), lengths.end(), 0u), 4u * kSide + 8u);
  EXPECT_EQ(lengths.back(), 4u * kSide);
}

TEST(BorderLoops, MeshesWithoutConsistentOrientationEnd) {
  std::mt19937 random(13);
  for (int seed = 0; seed < 500; ++seed) {
    std::uniform_int_distribution<std::int32_t> vertex(0, 4 + seed % 9);
    std::vector<Triangle> triangles;
    while (triangles.size() < static_cast<std::size_t>(1 + seed % 17)) {
      const Triangle t = {vertex(random), vertex(random), vertex(random)};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    std::size_t edges = 0;
    for (const detail::BorderLoop& loop : detail::border_loops(triangles)) edges += loop.size();
    EXPECT_LE(edges, 3 * triangles.size()) << seed;
  }
}

}  // namespace
}  // namespace selvedge::worn_openings_test
