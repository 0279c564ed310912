// SPDX-License-Identifier: MIT
//
// Knitted cloth at the level of its yarn: particles along the loops of a weft knit, which the
// survey misses (section 7.1.3: knits are simulated with the mesh of a weave): jersey, rib and
// interlock.
//
// The plan of a loop is that of F. Peirce, "Geometrical principles applicable to the design of
// functional fabrics", Textile Research Journal 1947: arcs of radius R for head and sinker, joined
// by straight legs that touch both. The head of a loop and the sinker of the next course have their
// centres at one height, half of the wale spacing w apart, so with the course spacing c the centres
// of a head and its own sinker are D = √(w²/4 + c²) apart. From the top of the head the arc turns
// by
//   φ = π - atan(w/2c) - acos(2R/D),  and the leg has the length  T = √(D² - 4R²),
// so the loop is 4 R φ + 2 T long. With Peirce's closest loops, w = 4 d, c = 2√3 d and R = 3/2 d,
// all yarns touch and the length is 16.66 d, his number. Other spacings keep R = 3w/8.
//
// The height over the plan is the cosine of G. Leaf, A. Glaskin, "The geometry of a plain knitted
// loop", Journal of the Textile Institute 1955, over the whole of a leg: heads and sinkers at the
// back, legs in front. It is as large as needed to put axes one diameter apart where yarns cross.
//
// Each half of a loop crosses the next course twice: its head passes behind a leg of that course,
// and its leg before the sinker. Both crossings are the same but for half a turn about the point
// between both centres.
//
// Elements: springs EA/length and twisting springs EI/length along the yarn, as in the weave
// (topology_weave.cpp), and at each interlock a spring between both axes and three angles
// (force_crossing.cpp), softer against sliding than against compression. The yarn is set: its loops
// are its shape at rest, as after washing. A twisting spring knows the size of a bend, not its
// plane, and without resistance against twist a bent rod turns out of its plane for nothing. So
// each link of a loop also keeps its angle to the nearest interlock, with the stiffness GJ/s of the
// yarn between them, shared by the links of a side. The surface follows the middles of the two legs
// and has half of the mass.
//
// A rib has wales to the front and to the back by turns: those to the back are mirrored at the
// plane of the bottoms of the sinkers, so that the yarn goes on from one side to the other without
// a step and all crossings stay one diameter wide. It is as open as on the needles; a real one
// draws together, until its wales to the front hide the others. The interlock of the survey's
// Figure 49 c is two 1 x 1 ribs in one another: the second yarn has a loop to the back where the
// first has one to the front, half a course above it. The sides then stand three quarters of a
// diameter further apart, which the sinkers cross, so that no yarns of the two ribs are nearer than
// their diameter. Between two wales the sinkers of both ribs pass from side to side in opposite
// directions; there they are bound like an interlock, for nothing else keeps the ribs together.
//
// Left out: friction, sliding beyond its spring, and contact between yarns apart from the
// interlocks, which also resist being pulled apart.
#include <selvedge/core/base/internal/check.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/detail/yarn_pattern.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace selvedge {
namespace {

constexpr double kArcOfWale = 0.375;  // radius of the arcs over the wale spacing: 3/2 d over 4 d

void validate_knit(const KnitConfig& k) {
  detail::validate_yarn("yarn", k.yarn);
  detail::validate_meeting(k.contact, k.rotation, k.links);
  require(std::isfinite(k.sliding) && k.sliding > 0.0, "sliding", k.sliding, "positive and finite");
  require(std::isfinite(k.twist) && k.twist > 0.0, "twist", k.twist, "positive and finite");
  require(k.wales >= 1, "wales", k.wales, "at least 1");
}

// Distance of the two sides of an interlock beyond that of a rib, in diameters.
constexpr double kMoreOfInterlock = 0.75;

std::string millimetres(double metres) { return std::to_string(1e3 * metres) + " mm"; }

[[noreturn]] void refuse_loop(double wale, double course, double diameter, const char* fault) {
  throw std::invalid_argument("knit: a yarn of " + millimetres(diameter) +
                              " has no loop with wales " + millimetres(wale) + " and courses " +
                              millimetres(course) + " apart, since " + fault);
}

/// Loops as particles and elements, course by course.
class Knitter {
 public:
  Knitter(const GridConfig& grid, const KnitConfig& knit, const Material& material)
      : grid_(grid),
        knit_(knit),
        material_(material),
        layout_(grid, knit),
        loop_(grid.size_x / grid.cells_x, grid.size_y / grid.cells_y, knit.yarn.diameter()),
        middle_(-loop_.height - (knit.structure == KnitStructure::interlock
                                     ? 0.5 * kMoreOfInterlock * knit.yarn.diameter()
                                     : 0.0)),
        cloth_(detail::surface_of_yarns(grid)) {}

  ClothMesh make() {
    for (std::int32_t j = 0; j < layout_.courses; ++j)
      for (std::int32_t i = 0; i < layout_.wales; ++i)
        if (is_back(i, 0)) cloth_.surface.vertices[layout_.middle(i, j)].z() = 2.0 * middle_;
    for (std::int32_t row = 0; row < layout_.rows(); ++row) add_row(row);
    for (std::int32_t row = 0; row + layout_.yarns < layout_.rows(); ++row)
      for (std::int32_t i = 0; i < layout_.wales; ++i) add_interlocks(i, row);
    for (std::int32_t row = 0; row < layout_.rows(); ++row)
      for (std::int32_t i = 0; i < layout_.wales; ++i) add_twist(i, row);
    for (std::int32_t j = 0; j < layout_.courses; ++j)
      for (std::int32_t i = 0; i < layout_.wales; ++i) add_tie(i, j);
    if (layout_.yarns > 1)
      for (std::int32_t row = 0; row + 1 < layout_.rows(); ++row)
        for (std::int32_t i = 1; i < layout_.wales; ++i) bind_ribs(i, row);
    return std::move(cloth_);
  }

 private:
  /// Length along the yarn from the top of the head to particle k of a half, so that particles lie
  /// on all four crossings.
  double along(std::int32_t k) const {
    const std::int32_t n = layout_.links;
    const double half = 0.5 * loop_.length();
    if (2 * k > 4 * n) return half - along(4 * n - k);
    const double s1 = loop_.head_crossing, s2 = loop_.leg_crossing;
    if (2 * k <= n) return s1 * (2.0 * k / n);
    if (2 * k <= 3 * n) return s1 + (s2 - s1) * (static_cast<double>(k) / n - 0.5);
    return s2 + (half - 2.0 * s2) * (static_cast<double>(k) / n - 1.5);
  }

  bool is_back(std::int32_t wale, std::int32_t row) const {
    if (knit_.structure == KnitStructure::jersey) return false;
    const std::int32_t repeat = knit_.structure == KnitStructure::rib ? knit_.wales : 1;
    return (wale / repeat + row % layout_.yarns) % 2 == 1;
  }

  /// How far the yarn of a loop to the front has gone towards the plane between both sides, m, when
  /// it has passed its last crossing: smoothly, and all of the way at the bottom of the sinker.
  double towards_middle(double along) const {
    const double half = 0.5 * loop_.length();
    const double t = std::max(0.0, (along - half) / loop_.head_crossing + 1.0);
    return (middle_ + loop_.height) * t * t * (3.0 - 2.0 * t);
  }

  /// Particle k of a loop, m from its middle.
  Vec3 place(std::int32_t k, bool back) const {
    const std::int32_t top = layout_.on_loop() / 2;
    const double s = along(std::abs(k - top));
    const Vec3 half = loop_.place(s);
    const double z = half.z() + towards_middle(s);
    return {k < top ? -half.x() : half.x(), half.y(), back ? 2.0 * middle_ - z : z};
  }

  void add_row(std::int32_t row) {
    const double course = row / layout_.yarns + 0.5 * (row % layout_.yarns);
    const auto first = static_cast<std::int32_t>(cloth_.surface.vertices.size());
    const std::int32_t count = layout_.on_course(), loop = layout_.on_loop();
    for (std::int32_t k = 0; k < count; ++k) {
      const std::int32_t i = std::min(k / loop, layout_.wales - 1);
      cloth_.surface.vertices.push_back(detail::place_on(grid_, i, course) +
                                        place(k - i * loop, is_back(i, row)));
      cloth_.mass.push_back(0.0);
    }
    detail::add_yarn_springs(cloth_, first, count, knit_.yarn, material_);
    for (std::int32_t k = 1; k + 1 < count; ++k)
      detail::add_yarn_bend(cloth_, first + k, set_angle(first + k), knit_.yarn, material_);
  }

  double set_angle(std::int32_t k) const {
    const std::vector<Vec3>& x = cloth_.surface.vertices;
    return detail::angle_between(x[k] - x[k - 1], x[k + 1] - x[k]);
  }

  /// The head and the legs of a loop with the loop of its yarn above it.
  void add_interlocks(std::int32_t i, std::int32_t row) {
    const detail::CrossingStiffness stiffness{knit_.contact, knit_.sliding, knit_.rotation};
    const std::int32_t n = layout_.links, loop = layout_.on_loop(), top = loop / 2;
    const auto cross = [&](std::int32_t below, std::int32_t above) {
      detail::add_yarn_crossing(cloth_, layout_.on(i, row, below),
                                layout_.on(i, row + layout_.yarns, above), stiffness, material_);
    };
    for (const std::int32_t side : {-1, 1}) {
      const std::int32_t sinker = side < 0 ? 0 : loop;
      cross(top + side * (n / 2), sinker - side * (3 * n / 2));
      cross(top + side * (3 * n / 2), sinker - side * (n / 2));
    }
  }

  /// The sinkers of both ribs before this wale, of one row and the next.
  void bind_ribs(std::int32_t i, std::int32_t row) {
    detail::add_yarn_crossing(cloth_, layout_.on(i, row, 0), layout_.on(i, row + 1, 0),
                              {knit_.contact, knit_.sliding, knit_.rotation}, material_);
  }

  /// The interlock nearest to link t of a half, counted from the head, or the one beside it if the
  /// link ends there: its particle on the half, and that of the other yarn.
  Edge interlock_of(std::int32_t i, std::int32_t row, std::int32_t side, std::int32_t t) const {
    const std::int32_t n = layout_.links, loop = layout_.on_loop(), top = loop / 2;
    std::int32_t which = t / n;
    if (row + layout_.yarns >= layout_.rows()) which = std::max(which, 2);
    if (row < layout_.yarns) which = std::min(which, 1);
    if (const std::int32_t k = n / 2 + which * n; t + 1 == k || t == k) which ^= 1;
    const std::int32_t k = n / 2 + which * n, other = 2 * n - k % (2 * n);
    const std::int32_t from = which < 2 ? (side < 0 ? 0 : loop) : top;
    return {k, layout_.on(i, which < 2 ? row + layout_.yarns : row - layout_.yarns,
                          which < 2 ? from - side * other : from + side * other)};
  }

  /// Keeps the links of a loop at their angles to the nearest interlock.
  void add_twist(std::int32_t i, std::int32_t row) {
    const std::int32_t n = layout_.links, top = layout_.on_loop() / 2;
    for (const std::int32_t side : {-1, 1})
      for (std::int32_t t = 0; t < 4 * n; ++t) {
        const auto [k, other] = interlock_of(i, row, side, t);
        const double reach = std::abs(along(t < k ? t : t + 1) - along(k));
        detail::add_yarn_angle(
            cloth_,
            {layout_.on(i, row, top + side * t), layout_.on(i, row, top + side * (t + 1)),
             layout_.on(i, row, top + side * k), other},
            2.0 * knit_.twist * knit_.yarn.bending() / (n * reach), material_);
      }
  }

  void add_tie(std::int32_t i, std::int32_t j) {
    const std::int32_t middle = layout_.middle(i, j), loop = layout_.on_loop();
    const std::int32_t row = j * layout_.yarns;
    const std::int32_t left = layout_.on(i, row, loop / 4),
                       right = layout_.on(i, row, 3 * loop / 4);
    detail::add_yarn_tie(cloth_, middle, left, right, 0.5, knit_.contact, material_);
    // The bottom of a sinker belongs to two loops, and to one at the end of the course.
    for (std::int32_t k = 0; k <= loop; ++k) {
      double& mass = cloth_.mass[layout_.on(i, row, k)];
      const bool is_taken = k == 0 && i > 0, is_shared = k == loop && i + 1 < layout_.wales;
      if (is_taken) continue;
      cloth_.mass[middle] += (is_shared ? 0.25 : 0.5) * mass;
      if (is_shared) cloth_.mass[middle + 1] += 0.25 * mass;
      mass *= 0.5;
    }
  }

  const GridConfig& grid_;
  const KnitConfig& knit_;
  const Material& material_;
  KnitLayout layout_;
  KnitLoop loop_;
  double middle_;  // m, height of the plane between front and back
  ClothMesh cloth_;
};

}  // namespace

KnitLoop::KnitLoop(double wale_spacing, double course_spacing, double diameter)
    : wale(wale_spacing), course(course_spacing), radius(kArcOfWale * wale_spacing) {
  constexpr double rounding = 1e-9;
  const double apart = elementary::hypot(0.5 * wale, course);  // head and sinker of a loop
  if (0.25 * wale < diameter * (1.0 - rounding))
    refuse_loop(wale, course, diameter, "wales must be four diameters apart");
  if (apart - 2.0 * radius < diameter * (1.0 - rounding))
    refuse_loop(wale, course, diameter, "heads would meet the sinkers of the course after next");
  leg = std::sqrt(apart * apart - 4.0 * radius * radius);
  arc = std::numbers::pi - elementary::atan2(0.5 * wale, course) -
        elementary::acos(2.0 * radius / apart);
  // From the centre of the head: the leg begins at t with the direction u, and leaves the circle of
  // the sinker of the next course, about (w/2, 0), at t + τu. The same place of that course is half
  // a turn about (w/4, 0) from there, on the head.
  const Vec3 t = radius * Vec3(elementary::sin(arc), elementary::cos(arc), 0.0);
  const Vec3 u(elementary::cos(arc), -elementary::sin(arc), 0.0),
      from = t - Vec3(0.5 * wale, 0.0, 0.0);
  const double middle = from.dot(u);
  const double root = middle * middle - from.squaredNorm() + radius * radius;
  const double reach = root > 0.0 ? std::sqrt(root) - middle : -1.0;
  if (!(reach > 0.0 && reach < 0.5 * leg))
    refuse_loop(wale, course, diameter, "its legs would not cross the next course side by side");
  const Vec3 other = Vec3(0.5 * wale, 0.0, 0.0) - (t + reach * u);
  head_crossing = radius * elementary::atan2(other.x(), other.y());
  leg_crossing = radius * arc + reach;
  const auto wave = [&](double s) {
    return elementary::cos(4.0 * std::numbers::pi * s / length());
  };
  height = 2.0 * diameter / (wave(head_crossing) - wave(leg_crossing));
}

Vec3 KnitLoop::place(double along) const {
  const double half = 0.5 * length(), bend = radius * arc;
  const double z = -0.5 * height * (1.0 + elementary::cos(2.0 * std::numbers::pi * along / half));
  const auto upper = [&](double s) {
    const double angle = std::min(s / radius, arc), straight = std::max(0.0, s - bend);
    return Vec3(radius * elementary::sin(angle) + straight * elementary::cos(arc),
                0.5 * course + radius * elementary::cos(angle) - straight * elementary::sin(arc),
                0.0);
  };
  Vec3 x =
      along <= 0.5 * half ? upper(along) : Vec3(Vec3(0.5 * wale, 0.0, 0.0) - upper(half - along));
  x.z() = z;
  return x;
}

ClothMesh make_knit(const GridConfig& grid, const KnitConfig& knit, const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  validate_knit(knit);
  return Knitter(grid, knit, material).make();
}

namespace {

KnitConfig knit_of(const MethodOptions& o, KnitStructure structure) {
  return {.yarn = detail::yarn_of(o, "tex"),
          .contact = o["contact"],
          .sliding = o["sliding"],
          .rotation = o["rotation"],
          .links = o.whole("links"),
          .structure = structure,
          .wales = structure == KnitStructure::rib ? o.whole("wales") : 1};
}

std::vector<MethodOption> options_of(KnitStructure structure) {
  using detail::positive_option;
  const KnitConfig k{};
  std::vector<MethodOption> options = detail::yarn_options(k.yarn);
  options.insert(options.begin(),
                 {positive_option("tex", k.yarn.tex, "g/km", 1e4, "linear density of the yarn")});
  options.insert(
      options.end(),
      {positive_option("contact", k.contact, "N/m", 1e9,
                       "stiffness of an interlock against compression; more needs smaller "
                       "steps of explicit integrators"),
       positive_option("sliding", k.sliding, "N/m", 1e9,
                       "stiffness of an interlock against sliding of one yarn on the other; "
                       "less makes the knit softer"),
       detail::rotation_option(k.rotation),
       detail::whole_option(
           "links", k.links, 2.0,
           "links of a leg between two interlocks, even; more bend more exactly")});
  if (structure == KnitStructure::rib)
    options.push_back(detail::whole_option("wales", k.wales, 1.0,
                                           "wales in a row on each side; 2 is a 2 x 2 rib"));
  return options;
}

}  // namespace

void register_knit(ClothPatternRegistry& registry) {
  const auto add = [&](const char* name, KnitStructure structure, const char* promise) {
    registry.add(name, options_of(structure),
                 [=](const MethodOptions& o, const GridConfig& grid, const Material& material) {
                   detail::refuse_laws_of_a_sheet(name, material);
                   return make_knit(grid, knit_of(o, structure), material);
                 },
                 {.promise = promise, .source = "Peirce, 1947; Leaf, Glaskin, 1955"});
  };
  add("knit", KnitStructure::jersey,
      "loops of a plain knit that bend, stretch and interlock; mass from the tex of the yarn");
  add("rib", KnitStructure::rib,
      "loops of a rib, to the front and to the back by turns; mass from the tex of the yarn");
  add("interlock", KnitStructure::interlock,
      "loops of two ribs in one another, the same on both sides; mass from the tex of the yarn");
}

}  // namespace selvedge
