// SPDX-License-Identifier: MIT
//
// Seams of pieces whose file names none: by the outlines that fronts, backs, sleeves, skirts, legs
// and bands have.
#include <fmt/format.h>
#include <selvedge/core/base/internal/elementary.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/garment/internal/drawn_pattern.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

namespace selvedge {
namespace {

using Part = PanelRole::Part;
using Side = PanelRole::Side;
using Face = PanelRole::Face;
using EdgeRun = std::vector<std::int32_t>;

constexpr double kRunCorner = 25.0 * std::numbers::pi / 180.0;  // from which a turn ends a run
constexpr double kSeamEase = 1.35;  // ratio of lengths up to which two runs are sewn

/// The runs of a panel by what they are. Left and right are those of the viewer, who sees the outer
/// side.
struct NamedRuns {
  EdgeRun hem, top, centre;                                // top: the neck, or the waist
  std::array<EdgeRun, 2> side, armhole, shoulder, inseam;  // left, right
  EdgeRun cap;
};

class RunFinder {
 public:
  RunFinder(const PatternPanel& panel, const PanelRole& role) : panel_(panel), role_(role) {
    const auto n = static_cast<std::int32_t>(panel.edges.size());
    // Runs begin where the outline turns.
    std::int32_t first = 0;
    for (std::int32_t e = 0; e < n; ++e)
      if (is_corner(e)) first = e;
    for (std::int32_t k = 0; k < n; ++k) {
      const std::int32_t e = (first + k) % n;
      if (runs_.empty() || is_corner(e)) runs_.emplace_back();
      runs_.back().push_back(e);
    }
  }

  /// The part that an outline shows whose name gives only front or back: a bodice has a neck and
  /// armholes, a leg has a fork.
  Part part() const {
    if (role_.part != Part::unknown || role_.face == Face::none) return role_.part;
    const std::size_t bodice = role_.side == Side::none ? 8 : 6;
    if (runs_.size() >= bodice) return Part::torso;
    return role_.side == Side::none ? Part::skirt : Part::leg;
  }

  /// Nothing: the outline is not one of this part.
  std::optional<NamedRuns> find() {
    if (runs_.size() < 4) return std::nullopt;
    rotate_to_hem();
    switch (role_.part) {
      case Part::torso:
        return torso();
      case Part::sleeve:
        return sleeve();
      case Part::skirt:
        return skirt();
      case Part::leg:
        return leg();
      default:
        return std::nullopt;
    }
  }

  /// A band: its lower and upper long runs, and its ends.
  std::optional<NamedRuns> band() {
    if (runs_.size() != 4) return std::nullopt;
    rotate_to_hem();
    NamedRuns named;
    named.hem = runs_[0];
    named.side[1] = runs_[1];
    named.top = runs_[2];
    named.side[0] = runs_[3];
    return named;
  }

 private:
  Vec2 direction(std::int32_t e, bool at_end) const {
    const double t = at_end ? 0.97 : 0.0;
    return edge_point(panel_, e, t + 0.03) - edge_point(panel_, e, t);
  }
  /// Whether the outline turns where edge e starts.
  bool is_corner(std::int32_t e) const {
    const auto n = static_cast<std::int32_t>(panel_.edges.size());
    return std::abs(turn(e == 0 ? n - 1 : e - 1, e)) > kRunCorner;
  }
  double turn(std::int32_t before, std::int32_t after) const {
    const Vec2 u = direction(before, true), v = direction(after, false);
    return elementary::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v));
  }

  Vec2 start(const EdgeRun& run) const { return edge_point(panel_, run.front(), 0.0); }
  Vec2 end(const EdgeRun& run) const { return edge_point(panel_, run.back(), 1.0); }
  double length(const EdgeRun& run) const {
    double sum = 0.0;
    for (const std::int32_t e : run) sum += edge_length(panel_, e);
    return sum;
  }
  double mean_height(const EdgeRun& run) const {
    double sum = 0.0, weight = 0.0;
    for (const std::int32_t e : run) {
      sum += edge_length(panel_, e) * edge_point(panel_, e, 0.5).y();
      weight += edge_length(panel_, e);
    }
    return sum / weight;
  }

  /// The hem is the lowest run that leads from left to right.
  void rotate_to_hem() {
    std::size_t best = 0;
    double least = 1e300;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const Vec2 along = end(runs_[i]) - start(runs_[i]);
      if (along.x() > std::abs(along.y()) && mean_height(runs_[i]) < least)
        least = mean_height(runs_[i]), best = i;
    }
    std::rotate(runs_.begin(), runs_.begin() + static_cast<std::ptrdiff_t>(best), runs_.end());
  }

  EdgeRun joined(std::size_t first, std::size_t last) const {
    EdgeRun all;
    for (std::size_t i = first; i < last; ++i)
      all.insert(all.end(), runs_[i].begin(), runs_[i].end());
    return all;
  }

  /// The start of the run at which the corner turns most between two runs.
  std::size_t sharpest(std::size_t first, std::size_t last) const {
    std::size_t best = first + 1;
    double most = -1e300;
    for (std::size_t i = first + 1; i < last; ++i)
      if (const double t = turn(runs_[i - 1].back(), runs_[i].front()); t > most)
        most = t, best = i;
    return best;
  }

  /// Counter-clockwise from the hem: side, armhole, shoulder, neck, shoulder, armhole, side. Halves
  /// have a centre instead of one of the two.
  std::optional<NamedRuns> torso() const {
    NamedRuns named;
    named.hem = runs_[0];
    const std::size_t n = runs_.size();
    const bool is_half = role_.side != Side::none;
    // The wearer's left is on the viewer's right in front.
    const bool outer_right = (role_.side == Side::left) == (role_.face == Face::front);
    double high_right = -1e300, high_left = -1e300;
    std::size_t right = 0, left = 0;  // run that ends, or begins, at the neck
    Vec2 low = start(runs_[0]), high = low;
    for (const EdgeRun& run : runs_)
      low = low.cwiseMin(start(run)), high = high.cwiseMax(start(run));
    const double middle = 0.5 * (low.x() + high.x());
    for (std::size_t i = 1; i < n; ++i) {
      const Vec2 p = end(runs_[i]);
      if ((is_half ? outer_right : p.x() > middle) && p.y() > high_right)
        high_right = p.y(), right = i;
      const Vec2 q = start(runs_[i]);
      if ((is_half ? !outer_right : q.x() < middle) && q.y() > high_left)
        high_left = q.y(), left = i;
    }
    const double top = std::max(high_right, high_left);
    if (!is_half || outer_right) {
      // The highest corner may be the tip of the shoulder of a run that leads to the neck.
      if (right < 3 || top - high_right > 0.1) return std::nullopt;
      const std::size_t corner = sharpest(1, right);
      named.side[1] = joined(1, corner);
      named.armhole[1] = joined(corner, right);
      named.shoulder[1] = runs_[right];
    }
    if (!is_half || !outer_right) {
      if (left == 0 || left + 3 > n) return std::nullopt;
      const std::size_t corner = sharpest(left + 1, n);
      named.shoulder[0] = runs_[left];
      named.armhole[0] = joined(left + 1, corner);
      named.side[0] = joined(corner, n);
    }
    if (!is_half)
      named.top = joined(right + 1, left);
    else if (outer_right)
      named.centre = runs_.back(), named.top = joined(right + 1, n - 1);
    else
      named.centre = runs_[1], named.top = joined(2, left);
    return named;
  }

  std::optional<NamedRuns> sleeve() const {
    NamedRuns named;
    named.hem = runs_[0];
    named.side[1] = runs_[1];
    named.cap = joined(2, runs_.size() - 1);
    named.side[0] = runs_.back();
    if (role_.face != Face::none) return named;
    if (length(named.side[0]) > kSeamEase * length(named.side[1]) ||
        length(named.side[1]) > kSeamEase * length(named.side[0]))
      return std::nullopt;
    return named;
  }

  /// Between the hem and the highest run.
  std::size_t waist() const {
    std::size_t best = 2;
    for (std::size_t i = 2; i + 1 < runs_.size(); ++i) {
      const Vec2 along = end(runs_[i]) - start(runs_[i]);
      if (-along.x() > std::abs(along.y()) && mean_height(runs_[i]) > mean_height(runs_[best]))
        best = i;
    }
    return best;
  }

  std::optional<NamedRuns> skirt() const {
    const std::size_t top = waist();
    NamedRuns named;
    named.hem = runs_[0];
    named.side[1] = joined(1, top);
    named.top = runs_[top];
    named.side[0] = joined(top + 1, runs_.size());
    return named;
  }

  /// The inner side has the corner of the crotch.
  std::optional<NamedRuns> leg() const {
    const std::size_t top = waist(), n = runs_.size();
    NamedRuns named;
    named.hem = runs_[0];
    named.top = runs_[top];
    const bool outer_right = (role_.side == Side::left) == (role_.face == Face::front);
    const std::size_t first = outer_right ? top + 1 : 1, last = outer_right ? n : top;
    if (last - first < 2) return std::nullopt;
    // The fork is the innermost corner.
    std::size_t fork = first + 1;
    for (std::size_t i = first + 1; i < last; ++i)
      if (outer_right ? start(runs_[i]).x() < start(runs_[fork]).x()
                      : start(runs_[i]).x() > start(runs_[fork]).x())
        fork = i;
    if (outer_right) {
      named.side[1] = joined(1, top);
      named.centre = joined(first, fork);
      named.inseam[0] = joined(fork, last);
    } else {
      named.side[0] = joined(top + 1, n);
      named.inseam[1] = joined(first, fork);
      named.centre = joined(fork, last);
    }
    return named;
  }

  const PatternPanel& panel_;
  const PanelRole& role_;
  std::vector<EdgeRun> runs_;
};

class SeamGuesser {
 public:
  SeamGuesser(const SewingPattern& pattern, std::vector<PanelRole> roles,
              std::vector<std::string>& notes)
      : pattern_(pattern), roles_(std::move(roles)), notes_(notes) {
    drawn_.name = pattern.name;
    for (const PatternPanel& panel : pattern.panels) drawn_.panels.push_back({.panel = panel});
  }

  SewingPattern run() {
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      roles_[p].part = RunFinder(pattern_.panels[p], roles_[p]).part();
      RunFinder finder(pattern_.panels[p], roles_[p]);
      const bool is_band = roles_[p].part == Part::waistband;
      auto named = is_band ? finder.band() : finder.find();
      if (named)
        runs_[static_cast<std::int32_t>(p)] = std::move(*named);
      else
        notes_.push_back(
            fmt::format("panel \"{}\": its outline is not that of {}, so no seam of it is "
                        "guessed; name the seams in the file",
                        pattern_.panels[p].name, roles_[p].text()));
    }
    for (const int wearer : {0, 1}) sew_sides(wearer);
    sew_centres();
    for (const auto& [p, named] : runs_) {
      if (roles_[p].part == Part::sleeve) sew_sleeve(p, named);
      if (roles_[p].part != Part::waistband) continue;
      if (roles_[p].face == Face::none)
        sew_band(p, named);
      else
        sew_half_band(p, named);
    }
    return as_sewn(drawn_);
  }

 private:
  /// The viewer's side on which the wearer's left (0) or right (1) of a panel is.
  int viewer_side(std::int32_t p, int wearer) const {
    const bool is_front = roles_[p].face != Face::back;
    return (wearer == 0) == is_front ? 1 : 0;
  }

  /// The panel of a part and face that reaches to this side of the wearer; -1: none.
  std::int32_t panel_at(Part part, Face face, int wearer) const {
    const Side side = wearer == 0 ? Side::left : Side::right;
    for (const auto& [p, named] : runs_)
      if (roles_[p].part == part && roles_[p].face == face &&
          (roles_[p].side == Side::none || roles_[p].side == side))
        return p;
    return -1;
  }

  double length(std::int32_t p, const EdgeRun& run) const {
    double sum = 0.0;
    for (const std::int32_t e : run) sum += edge_length(pattern_.panels[p], e);
    return sum;
  }

  struct RunOfPanel {
    std::int32_t panel;
    const EdgeRun* run;
    std::string name;
  };

  void sew(const std::vector<RunOfPanel>& a, const std::vector<RunOfPanel>& b) {
    DrawnStitch stitch;
    double length_a = 0.0, length_b = 0.0;
    std::string name_a, name_b;
    const auto add = [&](const std::vector<RunOfPanel>& list, DrawnChain& chain, double& sum,
                         std::string& name) {
      for (const RunOfPanel& r : list) {
        if (r.panel < 0 || r.run->empty()) return false;
        chain.push_back({r.panel, *r.run, false});
        sum += length(r.panel, *r.run);
        name += (name.empty() ? "" : " and ") + r.name + " of " + pattern_.panels[r.panel].name;
      }
      return !chain.empty();
    };
    if (!add(a, stitch.a, length_a, name_a) || !add(b, stitch.b, length_b, name_b)) return;
    if (std::max(length_a, length_b) > kSeamEase * std::min(length_a, length_b)) {
      notes_.push_back(
          fmt::format("{} ({:.3f} m) and {} ({:.3f} m) are not sewn: their lengths "
                      "differ too much",
                      name_a, length_a, name_b, length_b));
      return;
    }
    notes_.push_back(
        fmt::format("seam: {} ({:.3f} m) to {} ({:.3f} m)", name_a, length_a, name_b, length_b));
    drawn_.stitches.push_back(std::move(stitch));
  }

  void sew_sides(int wearer) {
    for (const Part part : {Part::torso, Part::skirt, Part::leg}) {
      const std::int32_t f = panel_at(part, Face::front, wearer),
                         b = panel_at(part, Face::back, wearer);
      if (f < 0 || b < 0) continue;
      const NamedRuns &front = runs_.at(f), &back = runs_.at(b);
      const int i = viewer_side(f, wearer), j = viewer_side(b, wearer);
      sew({{f, &front.side[i], "side"}}, {{b, &back.side[j], "side"}});
      sew({{f, &front.shoulder[i], "shoulder"}}, {{b, &back.shoulder[j], "shoulder"}});
      sew({{f, &front.inseam[1 - i], "inseam"}}, {{b, &back.inseam[1 - j], "inseam"}});
    }
  }

  /// Halves meet at the back, and legs in front, too. The front of a bodice may open there.
  void sew_centres() {
    for (const Part part : {Part::torso, Part::leg})
      for (const Face face : {Face::front, Face::back}) {
        const std::int32_t l = panel_at(part, face, 0), r = panel_at(part, face, 1);
        if (l < 0 || r < 0 || l == r) continue;
        if (part == Part::torso && face == Face::front) {
          notes_.push_back(
              "the fronts are left open, because nothing says that they are sewn together");
          continue;
        }
        sew({{l, &runs_.at(l).centre, "centre"}}, {{r, &runs_.at(r).centre, "centre"}});
      }
  }

  void sew_sleeve(std::int32_t p, const NamedRuns& sleeve) {
    int wearer = roles_[p].side == Side::right ? 1 : 0;
    if (roles_[p].side == Side::none)
      for (const auto& [q, other] : runs_)
        if (q < p && roles_[q].part == Part::sleeve) wearer = 1;
    const std::int32_t f = panel_at(Part::torso, Face::front, wearer),
                       b = panel_at(Part::torso, Face::back, wearer);
    if (roles_[p].face != Face::none) {
      sew_half_sleeve(p, sleeve, wearer, roles_[p].face == Face::front ? f : b);
      return;
    }
    sew({{p, &sleeve.side[1], "seam"}}, {{p, &sleeve.side[0], "seam"}});
    if (f < 0 || b < 0) return;
    const RunOfPanel front{f, &runs_.at(f).armhole[viewer_side(f, wearer)], "armhole"},
        back{b, &runs_.at(b).armhole[viewer_side(b, wearer)], "armhole"};
    // The cap runs from the viewer's right to the left; the front of a left sleeve is on the left.
    const RunOfPanel cap{p, &sleeve.cap, "cap"};
    if (wearer == 0)
      sew({cap}, {front, back});
    else
      sew({cap}, {back, front});
  }

  /// A front half meets the back half at both of its sides.
  void sew_half_sleeve(std::int32_t p, const NamedRuns& sleeve, int wearer, std::int32_t torso) {
    if (torso >= 0)
      sew({{p, &sleeve.cap, "cap"}},
          {{torso, &runs_.at(torso).armhole[viewer_side(torso, wearer)], "armhole"}});
    if (roles_[p].face != Face::front) return;
    for (const auto& [q, other] : runs_)
      if (roles_[q].part == Part::sleeve && roles_[q].face == Face::back &&
          roles_[q].side == roles_[p].side)
        for (const int side : {0, 1})
          sew({{p, &sleeve.side[side], "side"}}, {{q, &other.side[1 - side], "side"}});
  }

  /// Half a band meets the waist of its face, and the other half at both ends.
  void sew_half_band(std::int32_t p, const NamedRuns& band) {
    for (const Part part : {Part::skirt, Part::leg, Part::torso}) {
      const std::int32_t q = panel_at(part, roles_[p].face, 0);
      if (q < 0 || roles_[q].side != Side::none) continue;
      if (part == Part::torso)
        sew({{p, &band.top, "edge"}}, {{q, &runs_.at(q).hem, "waist"}});
      else
        sew({{p, &band.hem, "edge"}}, {{q, &runs_.at(q).top, "waist"}});
    }
    if (roles_[p].face != Face::front) return;
    for (const auto& [q, other] : runs_)
      if (roles_[q].part == Part::waistband && roles_[q].face == Face::back)
        for (const int side : {0, 1})
          sew({{p, &band.side[side], "end"}}, {{q, &other.side[1 - side], "end"}});
  }

  /// A band goes around from one side seam; its ends meet.
  void sew_band(std::int32_t p, const NamedRuns& band) {
    for (const Part part : {Part::skirt, Part::leg, Part::torso}) {
      const std::int32_t fl = panel_at(part, Face::front, 0), fr = panel_at(part, Face::front, 1),
                         bl = panel_at(part, Face::back, 0), br = panel_at(part, Face::back, 1);
      if (fl < 0 || bl < 0) continue;
      const auto top = [&](std::int32_t q) {
        return RunOfPanel{q, part == Part::torso ? &runs_.at(q).hem : &runs_.at(q).top, "waist"};
      };
      std::vector<RunOfPanel> around = {top(br)};
      if (bl != br) around.push_back(top(bl));
      around.push_back(top(fl));
      if (fl != fr) around.push_back(top(fr));
      sew({{p, part == Part::torso ? &band.top : &band.hem, "edge"}}, around);
      break;
    }
    sew({{p, &band.side[1], "end"}}, {{p, &band.side[0], "end"}});
  }

  const SewingPattern& pattern_;
  std::vector<PanelRole> roles_;
  std::vector<std::string>& notes_;
  DrawnPattern drawn_;
  std::map<std::int32_t, NamedRuns> runs_;
};

}  // namespace

SewingPattern guess_seams(const SewingPattern& pattern, const std::vector<PanelRole>& roles,
                          std::vector<std::string>& notes) {
  return SeamGuesser(pattern, roles, notes).run();
}

}  // namespace selvedge
