// SPDX-License-Identifier: MIT
//
// result.json of a dressed garment.
#include <fmt/format.h>
#include <selvedge/dress/detail/colour_scales.h>
#include <selvedge/dress/dress_result.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace selvedge {
namespace {

using Json = nlohmann::ordered_json;
using detail::pressure_scale, detail::strain_scale;

Json seam_json(const SeamReport& seam) {
  constexpr std::array closures = {"seam", "zip", "buttons"};
  return {{"name", seam.name},
          {"closure", closures.at(static_cast<std::size_t>(seam.closure))},
          {"length_a_m", seam.length_a},
          {"length_b_m", seam.length_b},
          {"ease", seam.ease()},
          {"length_worn_m", seam.length_end},
          {"pairs", seam.pairs},
          {"merged_pairs", seam.merged},
          {"opening_start_m", seam.opening_start},
          {"opening_at_merge_m", seam.opening_at_merge},
          {"opening_end_m", seam.opening_end}};
}

Json panel_json(const DressResult& result, std::size_t p) {
  Vec3 by = Vec3::Zero();
  for (const MovedPanel& moved : result.moved)
    if (moved.panel == static_cast<std::int32_t>(p)) by = moved.by;
  Json json = {{"name", result.panel_names[p]},
               {"moved_at_start_m", by.norm()},
               {"drop_m", result.panel_drop[p]},
               {"folded_share", result.panel_folded[p]}};
  if (!result.panel_turned.empty()) json["turned_rad"] = result.panel_turned[p];
  return json;
}

/// The openings; places are in metres, z up, as in frames/.
Json openings_json(const DressResult& r) {
  Json list = Json::array();
  for (const GarmentOpening& opening : r.openings)
    list.push_back({{"panel", r.panel_names[static_cast<std::size_t>(opening.panel)]},
                    {"at_m", {opening.at.x(), opening.at.y(), opening.at.z()}},
                    {"around_m", opening.length},
                    {"parts", opening.parts},
                    {"hole", opening.is_hole}});
  return list;
}

Json under_json(const DressResult& result) {
  Json list = Json::array();
  for (std::size_t k = 0; k < result.under.size(); ++k) {
    const UnderReport& under = result.under[k];
    const WornGarment& worn = under.garment;
    list.push_back({{"name", worn.name},
                    {"file", fmt::format("under/{}.obj", k)},
                    {"fabric", worn.fabric_name},
                    {"strain_limit", worn.fabric.strain_limit},
                    {"max_stretch", under.max_stretch},
                    {"drop_m", under.drop},
                    {"body_friction", worn.body_friction},
                    {"outer_friction", worn.outer_friction}});
  }
  return list;
}

Json motion_json(const DressResult& result) {
  Json poses = Json::array();
  for (const PoseReport& pose : result.poses)
    poses.push_back({{"time_s", pose.time},
                     {"max_stretch", pose.max_stretch},
                     {"drop_m", pose.drop},
                     {"flagged_vertices", pose.flagged}});
  return {{"poses", poses}, {"fault", result.motion_fault}, {"jams", result.jams}};
}

/// The sums of "sew/solve" and the like by phase of a step.
Json seconds_json(const DressResult& result) {
  Json seconds = Json::object();
  for (const auto& [phase, s] : result.seconds) seconds[phase] = s;
  return seconds;
}

/// The most stretched place; places are in metres, z up, as in frames/.
Json tight_json(const DressResult& r) {
  const TightPlace& tight = r.tight;
  if (tight.panel < 0) return nullptr;
  return {{"panel", r.panel_names[static_cast<std::size_t>(tight.panel)]},
          {"at_m", {tight.at.x(), tight.at.y(), tight.at.z()}},
          {"strain", tight.strain},
          {"area_share", tight.area_share},
          {"cloth_around_m", tight.cloth},
          {"body_around_m", tight.body}};
}

/// The fit report; places are in metres, z up, as in frames/.
Json fit_json(const DressResult& r) {
  Json list = Json::array();
  for (const FitZone& zone : r.fit) {
    Json json = {{"zone", zone.name},
                 {"at_m", {zone.at.x(), zone.at.y(), zone.at.z()}},
                 {"normal", {zone.normal.x(), zone.normal.y(), zone.normal.z()}},
                 {"body_girth_m", zone.body},
                 {"garment_girth_m", zone.cloth},
                 {"worn_girth_m", zone.worn},
                 {"closed", zone.is_closed},
                 {"strain", zone.strain},
                 {"largest_strain", zone.strain_max},
                 {"pressure_Pa", zone.pressure},
                 {"largest_pressure_Pa", zone.pressure_max}};
    if (zone.is_closed) json["ease_m"] = zone.ease();
    list.push_back(std::move(json));
  }
  return list;
}

Json elastics_json(const DressResult& r) {
  Json list = Json::array();
  for (const ElasticReport& elastic : r.elastics)
    list.push_back({{"name", elastic.name},
                    {"length_m", elastic.length},
                    {"rest_m", elastic.rest},
                    {"worn_m", elastic.worn}});
  return list;
}

Json result_json(const std::string& pattern, const DressResult& r, const std::string& body_name) {
  Json json = {{"dress", "finished"},
               {"pattern", pattern},
               {"body", body_name},
               {"verdict", r.verdict()},
               {"worn", r.worn()},
               {"good", r.good()},
               {"clean", r.clean},
               {"sewn", r.sewn},
               {"at_rest", r.at_rest},
               {"rms_speed_m_per_s", r.rms_speed},
               {"max_speed_m_per_s", r.max_speed},
               {"energy_share", r.energy_share},
               {"largest_opening_m", r.largest_opening},
               {"max_stretch", r.max_stretch},
               {"strain_limit", r.strain_limit},
               {"wearable_stretch", r.wearable_stretch},
               {"folded_share", r.folded},
               {"fabric", r.fabric_name},
               {"body_friction", r.body_friction},
               {"drop_m", r.drop},
               {"body_vertices_moved_back", r.body_moved},
               {"body_moved_back_m", r.body_moved_by},
               {"body_crossings", r.body_crossings},
               {"unmerged_pairs", r.open_pairs()},
               {"states_judged", r.states},
               {"sewing_attempts", r.attempts},
               {"flagged_vertices", std::count_if(r.flags.begin(), r.flags.end(),
                                                  [](std::uint8_t flag) { return flag != 0; })},
               {"vertices", r.garment.vertices.size()},
               {"triangles", r.garment.triangles.size()},
               {"simulated_sew_s", r.sew_time},
               {"simulated_settle_s", r.settle_time},
               {"held_vertices", r.held},
               {"held_s", r.held_time},
               {"state_hash", r.state_hash}};
  json["strain_scale_top"] = strain_scale(r).top;
  json["pressure_scale_top_Pa"] = pressure_scale(r).top;
  json["tight"] = tight_json(r);
  if (r.asymmetry >= 0.0) json["asymmetry_m"] = r.asymmetry;
  json["openings"] = openings_json(r);
  json["fit"] = fit_json(r);
  json["skin_back"] = Json::array();
  for (const SkinPlace& place : r.skin)
    json["skin_back"].push_back({{"at_m", {place.at.x(), place.at.y(), place.at.z()}},
                                 {"by_m", place.by},
                                 {"vertices", place.vertices}});
  json["pattern_moved_m"] = {r.origin_moved.x(), r.origin_moved.y(), r.origin_moved.z()};
  json["panels"] = Json::array();
  for (std::size_t p = 0; p < r.panel_names.size(); ++p) json["panels"].push_back(panel_json(r, p));
  json["seams"] = Json::array();
  for (const SeamReport& seam : r.seams) json["seams"].push_back(seam_json(seam));
  if (!r.elastics.empty()) json["elastics"] = elastics_json(r);
  if (!r.under.empty()) json["under"] = under_json(r);
  if (!r.poses.empty() || !r.motion_fault.empty()) json["motion"] = motion_json(r);
  json["seconds"] = seconds_json(r);
  json["notes"] = r.notes;
  return json;
}

}  // namespace

std::string dress_result_text(const std::string& pattern_name, const DressResult& result,
                              const std::string& body_name) {
  return result_json(pattern_name, result, body_name)
             .dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace selvedge
