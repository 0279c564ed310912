// SPDX-License-Identifier: MIT
//
// What is said about a dressed garment.
#include <fmt/format.h>
#include <selvedge/dress/dress.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace selvedge {
namespace {

constexpr double kFolded = 0.02;    // share of the area that may lie folded over
constexpr double kOneSided = 0.01;  // m, by which the sides of a symmetric pattern may differ
constexpr double kTurned = 1.75;    // rad, 100 degrees; narrow fronts of a jacket turn by 75
constexpr double kExplains = 0.1;   // of the strain, by which a ring that explains it is too short
constexpr double kAsTight = 0.8;    // of the largest strain, where its reason may lie
constexpr double kNoticeable = 5e-3;  // share of the area below which tightness is local

std::string panel_name(const DressResult& r, std::int32_t panel) {
  return fmt::format("panel \"{}\"", r.panel_names[static_cast<std::size_t>(panel)]);
}

std::string girths(double cloth, double body) {
  return fmt::format("cloth {:.2f} m around, body {:.2f} m", cloth, body);
}

/// Whether the ring through the most stretched place is so short that it says why it is.
bool is_short(const TightPlace& tight) {
  return tight.cloth > 0.0 && tight.body - tight.cloth >= kExplains * tight.strain * tight.cloth;
}

/// The zone with the least ease of those that are stretched as much as the most stretched place.
const FitZone* tight_zone(const DressResult& r) {
  const FitZone* least = nullptr;
  for (const FitZone& zone : r.fit)
    if (zone.is_closed && zone.ease() < 0.0 && zone.strain_max > kAsTight * r.tight.strain &&
        (!least || zone.ease() / zone.body < least->ease() / least->body))
      least = &zone;
  return least;
}

/// Where the garment is too small, with its measures there; empty: nowhere.
std::string too_small(const DressResult& r) {
  const TightPlace& tight = r.tight;
  if (std::max(r.max_stretch, tight.strain) <= r.wearable_stretch || tight.panel < 0) return "";
  const FitZone* named = is_short(tight) ? nullptr : tight_zone(r);
  const std::string measures =
      is_short(tight) ? " (" + girths(tight.cloth, tight.body) + ")"
      : named         ? fmt::format(" ({}: {})", named->name, girths(named->cloth, named->body))
                      : "";
  std::string text = fmt::format(
      "{} at {}{}: stretched by {:.0f} %, {:.1f} % of the garment by more than {:.0f} %",
      tight.area_share > kNoticeable ? "too small" : "tight in a small place",
      panel_name(r, tight.panel), measures, 100.0 * std::max(r.max_stretch, tight.strain),
      100.0 * tight.area_share, 100.0 * r.wearable_stretch);
  for (const FitZone& zone : r.fit)
    if (zone.is_closed && zone.ease() < 0.0 && zone.strain_max > r.wearable_stretch &&
        &zone != named)
      text += fmt::format(", also at the {} ({})", zone.name, girths(zone.cloth, zone.body));
  return text;
}

/// The seam with the largest opening.
std::string open_seam(const DressResult& r) {
  const auto widest = std::max_element(
      r.seams.begin(), r.seams.end(),
      [](const SeamReport& a, const SeamReport& b) { return a.opening_end < b.opening_end; });
  const std::string name = widest == r.seams.end() ? "a seam" : widest->name;
  return fmt::format("{} is open by {:.2f} mm", name, 1e3 * r.largest_opening);
}

/// The first panel that is not where the pattern places it.
std::string misplaced(const DressResult& r) {
  for (std::size_t p = 0; p < r.panel_drop.size(); ++p)
    if (std::abs(r.panel_drop[p]) > r.largest_drop)
      return fmt::format("panel \"{}\" lies {:.2f} m {} than the pattern places it",
                         r.panel_names[p], std::abs(r.panel_drop[p]),
                         r.panel_drop[p] > 0.0 ? "lower" : "higher");
  return "";
}

/// The openings through which nothing leads: an arm that is not in its sleeve.
std::string empty_opening(const DressResult& r) {
  std::string all;
  for (const GarmentOpening& opening : r.openings)
    if (opening.parts.empty() && !opening.is_hole)
      all += fmt::format("{}{} ({:.2f} m around)", all.empty() ? "" : " and of ",
                         panel_name(r, opening.panel), opening.length);
  if (all.empty()) return "";
  return "no head, arm or leg comes out of the opening of " + all;
}

std::string upside_down(const DressResult& r) {
  return r.is_upside_down ? "upside down, as the pattern places it" : "";
}

/// Panels that lie elsewhere than their names say.
std::string elsewhere(const DressResult& r) {
  std::string all;
  for (const WornFault& fault : r.misworn) {
    const char* what = fault.kind == WornFault::Kind::hood      ? "does not cover the head"
                       : fault.kind == WornFault::Kind::at_back ? "lies at the back"
                                                                : "lies in front";
    all += fmt::format("{}{} {}", all.empty() ? "" : "; ", panel_name(r, fault.panel), what);
  }
  return all;
}

/// The panel that has turned most.
std::string turned(const DressResult& r) {
  const auto most = std::max_element(r.panel_turned.begin(), r.panel_turned.end());
  if (most == r.panel_turned.end() || *most <= kTurned) return "";
  return fmt::format("{} is turned by {:.0f} degrees from where the pattern places it",
                     panel_name(r, static_cast<std::int32_t>(most - r.panel_turned.begin())),
                     *most * 180.0 / std::numbers::pi);
}

std::string folded_over(const DressResult& r) {
  if (r.folded <= kFolded) return "";
  const auto most = std::max_element(r.panel_folded.begin(), r.panel_folded.end());
  return fmt::format(
      "folded over itself on {:.1f} % of its area, most of all {} ({:.0f} %)", 100.0 * r.folded,
      panel_name(r, static_cast<std::int32_t>(most - r.panel_folded.begin())), 100.0 * *most);
}

std::string one_sided(const DressResult& r) {
  if (r.asymmetry <= kOneSided) return "";
  return fmt::format(
      "one-sided: the corners of {} differ by {:.1f} cm from those of its mirror image",
      panel_name(r, r.asymmetric_panel), 100.0 * r.asymmetry);
}

std::string too_stretched(const DressResult& r) {
  if (r.max_stretch <= r.strain_limit) return "";
  return fmt::format("stretched by {:.1f} %, the fabric allows {:.1f} %", 100.0 * r.max_stretch,
                     100.0 * r.strain_limit);
}

/// The first garment below that is not as wanted.
std::string under_reservation(const DressResult& r) {
  for (const UnderReport& under : r.under) {
    const double limit = under.garment.fabric.strain_limit;
    if (under.drop > r.largest_drop)
      return fmt::format("the garment below, \"{}\", lies {:.2f} m lower than before",
                         under.garment.name, under.drop);
    if (under.max_stretch > limit)
      return fmt::format(
          "the garment below, \"{}\", is stretched by {:.1f} %, its fabric allows "
          "{:.1f} %",
          under.garment.name, 100.0 * under.max_stretch, 100.0 * limit);
  }
  return "";
}

/// The first pose at which the garment is not as wanted.
std::string pose_reservation(const DressResult& r) {
  for (std::size_t k = 0; k < r.poses.size(); ++k) {
    const PoseReport& pose = r.poses[k];
    if (pose.drop > r.largest_drop)
      return fmt::format("at pose {}, it lies {:.2f} m lower on the body than before", k,
                         pose.drop);
    if (pose.max_stretch > r.strain_limit)
      return fmt::format("stretched by {:.1f} % at pose {}, the fabric allows {:.1f} %",
                         100.0 * pose.max_stretch, k, 100.0 * r.strain_limit);
  }
  return "";
}

}  // namespace

std::size_t DressResult::open_pairs() const {
  std::size_t open = 0;
  for (const SeamReport& seam : seams) open += seam.pairs - seam.merged;
  return open;
}

std::string DressResult::fault() const {
  if (!clean) return "something passed through something";
  if (body_crossings > 0)
    return fmt::format("{} pairs of triangles of garment and body meet", body_crossings);
  if (!sewn) {
    const std::string small = too_small(*this);
    return small.empty() ? open_seam(*this) : small + "; " + open_seam(*this);
  }
  if (!at_rest)
    return fmt::format("not at rest: root mean square speed {:.1f} mm/s, at most {:.0f} mm/s",
                       1e3 * rms_speed, 1e3 * max_speed);
  return motion_fault;
}

std::string DressResult::reservation() const {
  std::string all;
  for (const auto& reason :
       {upside_down, empty_opening, elsewhere, turned, too_small, misplaced, folded_over, one_sided,
        too_stretched, under_reservation, pose_reservation})
    if (const std::string sentence = reason(*this); !sentence.empty())
      all += (all.empty() ? "" : "; ") + sentence;
  return all;
}

std::string DressResult::verdict() const {
  if (!worn()) return fault();
  return good() ? "good" : "worn, but " + reservation();
}

}  // namespace selvedge
