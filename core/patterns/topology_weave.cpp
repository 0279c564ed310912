// SPDX-License-Identifier: MIT
//
// Cloth at the level of its yarns, which the survey (section 7.1.3) asks for: particles along the
// axes of warp and weft of a weave. The model is the saw-tooth of S. Kawabata, M. Niwa, H. Kawai,
// "The finite-deformation theory of plain-weave fabrics, part I: the biaxial-deformation theory",
// Journal of the Textile Institute 1973: yarns are straight from one crossing to the next, and a
// spring at each crossing resists compression. G. Leaf, K. Kandil, "The initial load-extension
// behaviour of plain-woven fabrics", Journal of the Textile Institute 1980, add the bending of the
// yarns between the crossings. The heights of the crimps follow F. Peirce, "The geometry of cloth
// structure", Journal of the Textile Institute 1937: crossing yarns touch, so h1 + h2 = d1 + d2.
//
// With the spacing p along a yarn, a part that interlaces has the length l = √(p² + h²), and one
// that floats the length p. Peirce's own axis winds around the other yarn in an arc; it has the
// crimp l/p - 1 = (9/16) (h/p)² instead of ½ (h/p)².
//
// Elements: springs EA/length and twisting springs EI/length along the yarns; at each crossing a
// spring between both axes, and three angles (force_crossing.cpp): between the yarns, and between
// each yarn and the link of the axes, as stiff against sliding as the contact is against
// compression. n links between two crossings bend by a factor 1 + 2/n² more than Leaf and Kandil's
// beam. The vertices of the surface are tied to a point between both yarns (force_tie.cpp) and have
// half of the mass of the crossing, so that contacts reach the yarns.
//
// Left out: sliding and friction of yarns, their twist, flattening other than by the contact
// spring, and contact between parallel yarns. Crossings are bonded: they also resist being pulled
// apart.
#include <selvedge/core/cloth/cloth_mesh.h>
#include <selvedge/core/cloth/detail/angles.h>
#include <selvedge/core/cloth/detail/topology.h>
#include <selvedge/core/patterns/cloth_pattern.h>
#include <selvedge/core/patterns/detail/yarn_pattern.h>
#include <selvedge/core/patterns/make_yarn_cloth.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace selvedge {

namespace {

void validate_weave(const WeaveConfig& w) {
  detail::validate_yarn("warp", w.warp);
  detail::validate_yarn("weft", w.weft);
  require(w.over >= 1, "over", w.over, "at least 1");
  require(w.under >= 1, "under", w.under, "at least 1");
  require(w.step >= 1, "step", w.step, "at least 1");
  if (std::gcd(w.step, w.over + w.under) != 1)
    throw std::invalid_argument(
        "weave: step " + std::to_string(w.step) +
        " has a common divisor with over + under = " + std::to_string(w.over + w.under) +
        ", so some yarns would not interlace; take another step");
  require(w.crimp_share > 0.0 && w.crimp_share < 1.0, "crimp_share", w.crimp_share,
          "between 0 and 1");
  detail::validate_meeting(w.contact, w.rotation, w.links);
}

/// Yarns that lie side by side must have room.
void validate_room(const char* which, const YarnConfig& yarn, double spacing) {
  if (yarn.diameter() < spacing) return;
  throw std::invalid_argument("weave: " + std::string(which) + " yarns of " +
                              std::to_string(1e3 * yarn.diameter()) +
                              " mm do not fit side by side at " + std::to_string(1e3 * spacing) +
                              " mm; take fewer cells or a finer yarn");
}

/// The weave as particles and elements, yarn by yarn.
class Weaver {
 public:
  Weaver(const GridConfig& grid, const WeaveConfig& weave, const Material& material)
      : grid_(grid),
        weave_(weave),
        material_(material),
        layout_(grid, weave),
        cloth_(detail::surface_of_yarns(grid)) {}

  ClothMesh make() {
    for (std::int32_t j = 0; j < layout_.warps; ++j) add_yarn(true, j);
    for (std::int32_t i = 0; i < layout_.wefts; ++i) add_yarn(false, i);
    for (std::int32_t j = 0; j < layout_.warps; ++j)
      for (std::int32_t i = 0; i < layout_.wefts; ++i) add_crossing(i, j);
    return std::move(cloth_);
  }

 private:
  /// Height of a yarn at a crossing, also beyond the swatch, where the weave goes on.
  double height(bool warp, std::int32_t yarn, std::int32_t crossing) const {
    const bool over = warp ? weave_.warp_over(crossing, yarn) : weave_.warp_over(yarn, crossing);
    const double crimp = warp ? weave_.warp_crimp() : weave_.weft_crimp();
    return 0.5 * crimp * (over == warp ? 1.0 : -1.0);
  }

  void add_yarn(bool warp, std::int32_t yarn) {
    const YarnConfig& rod = warp ? weave_.warp : weave_.weft;
    const std::int32_t n = weave_.links, count = warp ? layout_.on_warp() : layout_.on_weft();
    const auto first = static_cast<std::int32_t>(cloth_.surface.vertices.size());
    std::vector<Vec3>& x = cloth_.surface.vertices;
    for (std::int32_t k = 0; k < count; ++k) {
      const double place = (k - n / 2) / static_cast<double>(n);
      const std::int32_t before = (k + n / 2) / n - 1;
      const double low = height(warp, yarn, before), high = height(warp, yarn, before + 1);
      const double z = low + (place - before) * (high - low);
      x.push_back(warp ? detail::place_on(grid_, place, yarn)
                       : detail::place_on(grid_, yarn, place));
      x.back().z() = z;
      cloth_.mass.push_back(0.0);
    }
    detail::add_yarn_springs(cloth_, first, count, rod, material_);
    for (std::int32_t k = 1; k + 1 < count; ++k) add_bend(first + k, rod, is_kink(warp, yarn, k));
  }

  /// True if the yarn turns at its particle k at rest: at a crossing where it interlaces.
  bool is_kink(bool warp, std::int32_t yarn, std::int32_t k) const {
    const std::int32_t n = weave_.links;
    if ((k + n / 2) % n != 0) return false;
    const std::int32_t crossing = (k - n / 2) / n;
    const double z = height(warp, yarn, crossing);
    return height(warp, yarn, crossing - 1) != z || height(warp, yarn, crossing + 1) != z;
  }

  void add_bend(std::int32_t k, const YarnConfig& rod, bool kink) {
    const std::vector<Vec3>& x = cloth_.surface.vertices;
    const double angle = kink ? detail::angle_between(x[k] - x[k - 1], x[k + 1] - x[k]) : 0.0;
    detail::add_yarn_bend(cloth_, k, angle, rod, material_);
  }

  void add_crossing(std::int32_t i, std::int32_t j) {
    const std::int32_t warp = layout_.warp(j, layout_.at(i)), weft = layout_.weft(i, layout_.at(j));
    const std::int32_t middle = layout_.middle(i, j);
    const double stiff = weave_.contact;
    detail::add_yarn_crossing(cloth_, warp, weft, {stiff, stiff, weave_.rotation}, material_);
    // Both yarns lie on either side of the surface in proportion to their crimps.
    detail::add_yarn_tie(cloth_, middle, warp, weft, 1.0 - weave_.crimp_share, stiff, material_);
    for (const std::int32_t yarn : {warp, weft}) {
      cloth_.mass[middle] += 0.5 * cloth_.mass[yarn];
      cloth_.mass[yarn] *= 0.5;
    }
  }

  const GridConfig& grid_;
  const WeaveConfig& weave_;
  const Material& material_;
  WeaveLayout layout_;
  ClothMesh cloth_;
};

}  // namespace

bool WeaveConfig::warp_over(std::int32_t i, std::int32_t j) const {
  const std::int32_t repeat = over + under, place = (i + step * j) % repeat;
  return (place + repeat) % repeat < over;
}

double WeaveConfig::warp_crimp() const { return crimp_share * (warp.diameter() + weft.diameter()); }

double WeaveConfig::weft_crimp() const {
  return (1.0 - crimp_share) * (warp.diameter() + weft.diameter());
}

ClothMesh make_weave(const GridConfig& grid, const WeaveConfig& weave, const Material& material) {
  detail::validate_grid(grid);
  detail::validate_material(material);
  validate_weave(weave);
  validate_room("warp", weave.warp, grid.size_y / grid.cells_y);
  validate_room("weft", weave.weft, grid.size_x / grid.cells_x);
  return Weaver(grid, weave, material).make();
}

namespace {

WeaveConfig weave_of(const MethodOptions& o) {
  return {.over = o.whole("over"),
          .under = o.whole("under"),
          .step = o.whole("step"),
          .warp = detail::yarn_of(o, "warp_tex"),
          .weft = detail::yarn_of(o, "weft_tex"),
          .contact = o["contact"],
          .rotation = o["rotation"],
          .links = o.whole("links")};
}

}  // namespace

void register_weave(ClothPatternRegistry& registry) {
  using detail::positive_option;
  using detail::whole_option;
  const WeaveConfig w{};
  std::vector<MethodOption> options = detail::yarn_options(w.warp);
  options.insert(
      options.begin(),
      {whole_option("over", w.over, 1.0, "weft yarns that a warp yarn floats over"),
       whole_option("under", w.under, 1.0, "weft yarns that a warp yarn then passes under"),
       whole_option("step", w.step, 1.0,
                    "shift of this sequence from one warp yarn to the next; twill 1, satin of 5 2"),
       positive_option("warp_tex", w.warp.tex, "g/km", 1e4, "linear density of a warp yarn"),
       positive_option("weft_tex", w.weft.tex, "g/km", 1e4, "linear density of a weft yarn")});
  options.insert(
      options.end(),
      {positive_option("contact", w.contact, "N/m", 1e9,
                       "stiffness of a crossing against compression; more needs smaller steps "
                       "of explicit integrators"),
       detail::rotation_option(w.rotation),
       whole_option("links", w.links, 2.0,
                    "links of a yarn between two crossings, even; more bend more exactly")});
  registry.add(
      "weave", std::move(options),
      [](const MethodOptions& o, const GridConfig& grid, const Material& material) {
        detail::refuse_laws_of_a_sheet("weave", material);
        return make_weave(grid, weave_of(o), material);
      },
      {.promise = "yarns that bend, stretch and press on each other, bonded where they cross; mass "
                  "from their tex",
       .source = "Kawabata, Niwa, Kawai, 1973; Leaf, Kandil, 1980; Peirce, 1937"});
}

}  // namespace selvedge
