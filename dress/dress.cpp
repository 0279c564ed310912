// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/detail/fit.h>
#include <selvedge/dress/detail/origin.h>
#include <selvedge/dress/detail/worn_measures.h>
#include <selvedge/dress/detail/worn_openings.h>
#include <selvedge/dress/dress.h>
#include <selvedge/scene/fabric_file.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace selvedge {
namespace {

void require_positive(const char* name, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(fmt::format("dress: {} is {:g}; it must be positive", name, value));
}

void check(const DressConfig& c) {
  require_positive("edge_length", c.edge_length);
  require_positive("sewing_edge_length", c.sewing_edge_length);
  require_positive("rest_gap", c.rest_gap);
  require_positive("pull", c.pull);
  require_positive("largest_pull", c.largest_pull);
  require_positive("sew_time", c.sew_time);
  require_positive("settle_time", c.settle_time);
  require_positive("fps", c.fps);
  if (!(c.budget > 0.0)) throw std::invalid_argument("dress: budget must be positive");
  if (c.steps_per_frame < 1)
    throw std::invalid_argument("dress: steps_per_frame must be at least 1");
  if (!(c.hold_time >= 0.0)) throw std::invalid_argument("dress: hold_time must be at least 0");
  require_positive("motion.rate", c.motion.rate);
  require_positive("motion.lead", c.motion.lead);
}

void check_fabrics(const SewingPattern& pattern, const DressConfig& config) {
  for (const PatternPanel& panel : pattern.panels)
    if (!panel.fabric.empty() && !config.fabrics.contains(panel.fabric))
      throw std::invalid_argument(fmt::format(
          "panel \"{}\" is of the fabric \"{}\", which is not given", panel.name, panel.fabric));
}

void check_poses(const TriangleMesh& body, const std::vector<TriangleMesh>& poses) {
  for (std::size_t k = 0; k < poses.size(); ++k) {
    validate(poses[k], fmt::format("pose {}", k));
    if (poses[k].vertices.size() != body.vertices.size() || poses[k].triangles != body.triangles)
      throw std::invalid_argument(fmt::format(
          "pose {} has other vertices or triangles than the body; every pose must be the same mesh "
          "with moved vertices",
          k));
  }
}

/// Garments below lie free around the body and around each other.
void check_under(const std::vector<WornGarment>& under, const TriangleMesh& body) {
  const auto crosses = [](const TriangleMesh& a, const TriangleMesh& b) {
    return !find_meetings({a.vertices, a.triangles}, {b.vertices, b.triangles}).empty();
  };
  for (std::size_t k = 0; k < under.size(); ++k) {
    const WornGarment& worn = under[k];
    validate(worn.surface, "garment \"" + worn.name + "\"");
    if (crosses(worn.surface, body))
      throw std::invalid_argument(fmt::format(
          "garment \"{}\" crosses or touches the body; give the body on which it was put on",
          worn.name));
    if (!find_meetings(worn.surface.vertices, worn.surface.triangles).empty())
      throw std::invalid_argument(fmt::format(
          "garment \"{}\" crosses or touches itself; only a clean garment can be worn below",
          worn.name));
    for (std::size_t inner = 0; inner < k; ++inner)
      if (crosses(worn.surface, under[inner].surface))
        throw std::invalid_argument(
            fmt::format("garments \"{}\" and \"{}\" cross or touch; give them as "
                        "they lie on the body together",
                        under[inner].name, worn.name));
  }
}

/// The garments below as they lie at the end. Their stretch is known since they settled.
void report_under(const detail::Garment& garment, DressResult& result) {
  for (std::size_t k = 0; k < result.under.size(); ++k) {
    UnderReport& report = result.under[k];
    report.garment.surface.vertices = garment.under[k].x;
    report.drop = detail::mean_height(garment.under[k].worn->surface.vertices, {}) -
                  detail::mean_height(garment.under[k].x, {});
  }
}

/// The number of splits that make triangles of `edge_length`, and the length before them.
struct Levels {
  int splits = 0;
  double edge_length = 0.0;  // m
};
Levels levels_of(const DressConfig& config) {
  Levels levels{0, config.edge_length};
  constexpr double rounding = 1e-9;
  while (2.0 * levels.edge_length <= (1.0 + rounding) * config.sewing_edge_length) {
    levels.edge_length *= 2.0;
    ++levels.splits;
  }
  return levels;
}

void start_report(const GarmentMesh& mesh, DressResult& result) {
  result.clean = true;
  result.panel_names = mesh.panel_names;
  result.notes = mesh.notes;
  for (const GarmentMesh::Stitch& stitch : mesh.stitches)
    result.seams.push_back({.name = stitch.name,
                            .length_a = stitch.length_a,
                            .length_b = stitch.length_b,
                            .closure = stitch.closure});
}

/// Length of the first side of a stitch as it lies, m.
double worn_length(const detail::Garment& garment, const detail::Stitching& stitch) {
  const auto x = [&](std::size_t i) -> const Vec3& {
    return garment.surface.vertices[garment.corner[stitch.a[i]]];
  };
  double length = 0.0;
  for (std::size_t i = 1; i < stitch.a.size(); ++i) length += (x(i) - x(i - 1)).norm();
  return length;
}

/// Mean height of each panel, by area of the flat pattern, m.
std::vector<double> panel_heights(const detail::Garment& garment, std::size_t panels) {
  std::vector<double> height(panels, 0.0), area(panels, 0.0);
  for (std::size_t i = 0; i < garment.flat.triangles.size(); ++i) {
    const Triangle &t = garment.surface.triangles[i], &f = garment.flat.triangles[i];
    const std::vector<Vec3>&x = garment.surface.vertices, &u = garment.flat.vertices;
    const double a = (u[f[1]] - u[f[0]]).cross(u[f[2]] - u[f[0]]).norm();
    const auto p = static_cast<std::size_t>(garment.panel_of_triangle[i]);
    height[p] += a * (x[t[0]].z() + x[t[1]].z() + x[t[2]].z()) / 3.0;
    area[p] += a;
  }
  for (std::size_t p = 0; p < panels; ++p) height[p] /= area[p];
  return height;
}

void report_seams(const detail::Garment& garment, const DressConfig& config, DressResult& result) {
  for (std::size_t s = 0; s < result.seams.size(); ++s) {
    SeamReport& report = result.seams[s];
    report.pairs = garment.pairs(s);
    report.merged = report.pairs - garment.open_pairs(s).size();
    report.opening_end = garment.opening(s);
    report.length_end = worn_length(garment, garment.stitches[s]);
  }
  result.largest_opening = garment.largest_opening();
  result.sewn = result.largest_opening <= detail::closed_opening(config);
}

/// Lengths of rows along the cloth, flat and as it lies.
void report_elastics(const detail::Garment& garment, DressResult& result) {
  for (const detail::DividedElastic& elastic : garment.elastics) {
    ElasticReport& report = result.elastics.emplace_back();
    report.name = elastic.name;
    for (std::size_t i = 1; i < elastic.vertices.size(); ++i) {
      const std::int32_t u = elastic.vertices[i - 1], v = elastic.vertices[i];
      report.length += (garment.flat.vertices[v] - garment.flat.vertices[u]).norm();
      report.worn += (garment.surface.vertices[garment.corner[v]] -
                      garment.surface.vertices[garment.corner[u]])
                         .norm();
    }
    report.rest = elastic.elastic.ratio * report.length;
  }
}

void report_drops(const detail::Garment& start, const detail::Garment& garment,
                  const std::vector<detail::PanelPlace>& places, DressResult& result) {
  const std::size_t panels = result.panel_names.size();
  const std::vector<double> placed = panel_heights(start, panels),
                            worn = panel_heights(garment, panels);
  for (std::size_t p = 0; p < panels; ++p)
    result.panel_drop.push_back(placed[p] + places[p].shift.z() - worn[p]);
}

/// The meshes, and what lies between them.
void report_garment(const detail::Garment& garment, const TriangleMesh& body, DressResult& result) {
  result.garment = garment.surface;
  result.flat = garment.flat;
  result.velocity = garment.velocity;
  result.panel_of_triangle = garment.panel_of_triangle;
  detail::report_skin(body, result);
  const TriangleMeetings meetings =
      find_meetings({garment.surface.vertices, garment.surface.triangles},
                    {result.body.vertices, result.body.triangles});
  result.body_crossings = static_cast<std::int64_t>(meetings.all().size());
}

/// m; infinity if the neck was not found.
double neck_height(const std::vector<detail::BodyZone>& zones) {
  for (const detail::BodyZone& zone : zones)
    if (zone.name == "neck") return zone.plane.point().z();
  return std::numeric_limits<double>::infinity();
}

/// Adds the seconds since construction to a phase of a result.
class PhaseTime {
 public:
  PhaseTime(DressResult& result, const char* phase) : result_(result), phase_(phase) {}
  ~PhaseTime() { result_.seconds[phase_] += watch_.seconds(); }
  PhaseTime(const PhaseTime&) = delete;
  PhaseTime& operator=(const PhaseTime&) = delete;

 private:
  DressResult& result_;
  const char* phase_;
  Stopwatch watch_;
};

/// The landmarks of a person; none of a bust, a leg or a table.
std::optional<BodyLandmarks> landmarks_of(const TriangleMesh& body) {
  try {
    return find_landmarks(body);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

/// The x that parts left from right, m.
double middle_of(const BodyLandmarks& landmarks) {
  return (landmarks.bust.middle.x() + landmarks.waist.middle.x() + landmarks.hips.middle.x()) / 3.0;
}

/// Refuses a pattern beside the body, or moves it to its place.
void find_origin(GarmentMesh& panels, bool is_fitted, DressResult& result) {
  const detail::OriginFit fit = detail::fit_origin(panels, result.body);
  if (!fit.is_beside()) return;
  if (!is_fitted || fit.origin.empty()) throw DressFailed(fit.fault());
  for (Vec3& x : panels.placed) x += fit.by;
  result.origin_moved = fit.by;
}

constexpr double kHeightOff = 0.06;   // m, from which a pattern is for a body of another height
constexpr double kSleevesOff = 0.06;  // m, from which it is for arms at another angle

/// Moves a pattern for a taller or shorter person up or down, and arranges one for arms at another
/// angle; or says so.
void find_stand(SewingPattern pattern, const BodyLandmarks& landmarks, bool is_fitted,
                const PanelMeshConfig& mesh, GarmentMesh& panels, DressResult& result) {
  for (PatternPanel& panel : pattern.panels) panel.translation += result.origin_moved;
  const detail::PatternStand stand = detail::stand_of(pattern, result.body, landmarks);
  const auto note = [&](const std::string& what) { result.notes.push_back("the pattern " + what); };
  if (std::abs(stand.height) > kHeightOff && !is_fitted)
    note(fmt::format("stands {:.2f} m {} its place on this body; --fit-origin moves it",
                     std::abs(stand.height), stand.height > 0.0 ? "below" : "above"));
  if (stand.sleeves > kSleevesOff && !is_fitted)
    note("is drawn for arms at another angle; --arrange places its sleeves along the arms");
  result.is_upside_down = stand.is_upside_down && !is_fitted;
  if (result.is_upside_down) note("is placed upside down; --arrange places it anew");
  if (!is_fitted) return;
  if (stand.is_upside_down || stand.sleeves > kSleevesOff) {
    note(stand.is_upside_down
             ? "is placed upside down: its panels were arranged anew"
             : "is drawn for arms at another angle: its panels were arranged anew");
    panels = mesh_garment(stand.arranged, mesh);
    result.origin_moved = Vec3::Zero();
  } else if (std::abs(stand.height) > kHeightOff) {
    for (Vec3& x : panels.placed) x.z() += stand.height;
    result.origin_moved.z() += stand.height;
  }
}

void leave_room(const TriangleMesh& body, double room, DressResult& result) {
  const PhaseTime time(result, "start");
  BodyRoom made = make_room(body, room);
  result.body = std::move(made.body);
  result.body_moved = made.vertices;
  result.body_moved_by = made.largest;
}

detail::Garment make_start(const SewingPattern& pattern, const DressConfig& config,
                           const std::optional<BodyLandmarks>& landmarks,
                           const detail::Deadline& deadline, DressResult& result) {
  const PhaseTime time(result, "start");
  deadline.check();
  PanelMeshConfig mesh;
  mesh.edge_length = levels_of(config).edge_length;
  mesh.limits = config.limits;
  GarmentMesh panels = mesh_garment(pattern, mesh);
  start_report(panels, result);
  find_origin(panels, config.fit_origin, result);
  if (landmarks) find_stand(pattern, *landmarks, config.fit_origin, mesh, panels, result);
  result.moved = find_free_start(panels, result.body, config.largest_move, config.under,
                                 [&] { deadline.check(); });
  return detail::start_garment(panels, config.under, config.held_labels);
}

/// Tried in this order. Stiff panels do not fold into the seams as soft ones may, but a stiff
/// bodice may close below the shoulders: they come second. Seams that span the body come before a
/// waist seam that could pull the shoulders down, and gathered seams before the others, while their
/// folds still have space. A garment without gathers may have sleeves that start between front and
/// back: they come out only if each half is joined before the halves are.
std::vector<detail::SewAttempt> sew_attempts(const detail::Garment& garment) {
  using detail::SeamChoice;
  const bool is_gathered =
      std::any_of(garment.stitches.begin(), garment.stitches.end(),
                  [](const detail::Stitching& stitch) { return stitch.is_gathered(); });
  const detail::SewAttempt second =
      is_gathered
          ? detail::SewAttempt{0.35, {SeamChoice::gathered, SeamChoice::spanning, SeamChoice::all}}
          : detail::SewAttempt{0.2, {SeamChoice::halves, SeamChoice::all}};
  const detail::SewAttempt first{0.35,
                                 {SeamChoice::spanning, SeamChoice::gathered, SeamChoice::all}};
  detail::SewAttempt soft = first, stiff = first;
  soft.gives_up = stiff.is_stiff = true;
  return {soft, stiff, second, {0.2, {SeamChoice::all}}};
}

/// A failure with what the mesh says about the pattern, which may be its cause.
std::string with_notes(std::string failure, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) failure += "; note: " + note;
  return failure;
}

/// The garment with all seams closed, by the first attempt that closes them. If none does, the one
/// with the smallest opening of those that are nearly closed, which goes on with an open seam.
detail::Garment sewn(const detail::Garment& start, const detail::Dressing& dressing,
                     DressResult& result) {
  const PhaseTime time(result, "sew");
  std::optional<detail::Garment> nearly_closed;
  std::string failure;
  int best = 0;
  for (const detail::SewAttempt& attempt : sew_attempts(start)) {
    detail::Garment garment = start;
    if (result.attempts > 0 && dressing.observer.restart) dressing.observer.restart();
    ++result.attempts;
    try {
      detail::sew(garment, dressing, DressPhase::sew, attempt, result);
      const double opening = garment.largest_opening();
      if (opening <= detail::closed_opening(dressing.config)) return garment;
      if (!nearly_closed || opening < nearly_closed->largest_opening()) {
        nearly_closed = std::move(garment);
        best = result.attempts;
      }
    } catch (const DressOverBudget& over) {
      const std::size_t s = garment.widest_seam();
      throw DressOverBudget(fmt::format("{}; {} is still open by {:.1f} mm", over.what(),
                                        result.seams[s].name, 1e3 * garment.opening(s)));
    } catch (const DressFailed& failed) {
      failure = failed.what();
    }
  }
  if (!nearly_closed) throw DressFailed(with_notes(failure, result.notes));
  if (best != result.attempts && dressing.observer.restart) dressing.observer.restart();
  return std::move(*nearly_closed);
}

/// Closes zips and buttons.
void close_up(detail::Garment& garment, const detail::Dressing& dressing, DressResult& result) {
  garment.is_closing = true;
  const auto closes_last = [](const detail::Stitching& stitch) { return stitch.closes_last; };
  if (std::none_of(garment.stitches.begin(), garment.stitches.end(), closes_last)) return;
  const PhaseTime time(result, "close");
  detail::sew(garment, dressing, DressPhase::close, {0.35, {detail::SeamChoice::all}}, result);
}

/// Share of the area that lies folded over itself, and the panels with most of it.
double folded_share(const detail::Garment& garment, const TriangleMesh& body, std::size_t panels) {
  const std::vector<double> shares =
      detail::folded_areas(garment.surface, garment.panel_of_triangle, body, panels);
  double folded = 0.0, all = 0.0;
  for (std::size_t i = 0; i < garment.flat.triangles.size(); ++i) {
    const double area = detail::deformation(garment.surface, garment.flat, i).area;
    folded += shares[static_cast<std::size_t>(garment.panel_of_triangle[i])] * area;
    all += area;
  }
  return all > 0.0 ? folded / all : 0.0;
}

constexpr double kDrawAgain =
    0.01;                          // share of the area that is folded, from which hands pull again
constexpr double kStronger = 3.0;  // factor of their pull, each time
constexpr int kMostDraws = 3;

/// Draws the garment into place and lets it come to rest.
void draw_and_settle(detail::Garment& garment, const detail::Garment& start,
                     const std::vector<detail::PanelPlace>& places,
                     const detail::Dressing& dressing, DressResult& result) {
  {
    const PhaseTime time(result, "draw");
    detail::draw_into_place(garment, start, places, dressing, result);
  }
  const PhaseTime time(result, "settle");
  detail::settle(garment, dressing, DressPhase::settle, result);
}

/// The same again, with more strength each time, while cloth lies folded over itself.
void draw_folds_out(detail::Garment& garment, const detail::Garment& start,
                    std::vector<detail::PanelPlace> places, const detail::Dressing& dressing,
                    DressResult& result) {
  double before = std::numeric_limits<double>::infinity();
  for (int draw = 1; draw < kMostDraws; ++draw) {
    const double folded = folded_share(garment, result.body, result.panel_names.size());
    if (folded < kDrawAgain || folded > 0.8 * before) return;
    before = folded;
    for (detail::PanelPlace& place : places) place.strength *= kStronger;
    draw_and_settle(garment, start, places, dressing, result);
  }
}

}  // namespace

const char* phase_name(DressPhase phase) {
  switch (phase) {
    case DressPhase::sew:
      return "sew";
    case DressPhase::close:
      return "close";
    case DressPhase::draw:
      return "draw";
    case DressPhase::settle:
      return "settle";
    case DressPhase::refine:
      return "refine";
    case DressPhase::move:
      break;
  }
  return "move";
}

double SeamReport::ease() const {
  return std::max(length_a, length_b) / std::min(length_a, length_b) - 1.0;
}

void find_fabrics(const SewingPattern& pattern, const std::filesystem::path& folder,
                  DressConfig& config) {
  for (const PatternPanel& panel : pattern.panels)
    if (!panel.fabric.empty() && !config.fabrics.contains(panel.fabric))
      config.fabrics[panel.fabric] = find_fabric(panel.fabric, folder).material;
}

SewingPattern turned_upright(SewingPattern pattern, UpAxis up) {
  Mat3 turn = Mat3::Identity();
  if (up == UpAxis::x) turn << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  if (up == UpAxis::y) turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (PatternPanel& panel : pattern.panels) {
    panel.rotation = turn * panel.rotation;
    panel.translation = turn * panel.translation;
  }
  return pattern;
}

DressResult dress(const SewingPattern& pattern, const TriangleMesh& body, const DressConfig& config,
                  const Methods& methods, const DressObserver& observer) {
  check(config);
  check_poses(body, config.motion.poses);
  const detail::Deadline deadline(config.budget);
  DressResult result;
  check_fabrics(pattern, config);
  result.strain_limit = config.fabric.strain_limit;
  for (const PatternPanel& panel : pattern.panels)
    if (!panel.fabric.empty())
      result.strain_limit =
          std::max(result.strain_limit, config.fabrics.at(panel.fabric).strain_limit);
  result.fabric_name = config.fabric_name;
  result.body_friction = config.body_friction;
  result.largest_drop = config.largest_drop;
  result.wearable_stretch = config.wearable_stretch;
  leave_room(body, config.body_room, result);
  check_under(config.under, result.body);
  for (const WornGarment& worn : config.under) result.under.push_back({.garment = worn});
  const Levels levels = levels_of(config);
  const std::optional<BodyLandmarks> landmarks = landmarks_of(body);
  const detail::Garment start = make_start(pattern, config, landmarks, deadline, result);
  const std::vector<detail::BodyZone> zones = detail::body_zones(result.body);
  const std::vector<detail::PanelPlace> places =
      detail::panel_places(start, result.panel_names.size(), neck_height(zones));
  const std::optional<double> middle =
      landmarks ? std::optional(middle_of(*landmarks)) : std::nullopt;
  const detail::Dressing dressing{result.body, config, methods, observer, deadline, middle};
  detail::Garment garment = sewn(start, dressing, result);
  close_up(garment, dressing, result);
  draw_and_settle(garment, start, places, dressing, result);
  // A cone or a table may lose what hands pull that hard.
  if (landmarks) draw_folds_out(garment, start, places, dressing, result);
  if (result.body_moved > 0) {
    const PhaseTime time(result, "skin");
    detail::return_skin(garment, dressing, body, result.body, result);
    if (levels.splits == 0) detail::settle(garment, dressing, DressPhase::settle, result);
  }
  for (int level = 0; level < levels.splits; ++level) {
    const PhaseTime time(result, "refine");
    detail::split_garment(pattern, garment);
    detail::settle(garment, dressing, DressPhase::refine, result);
  }
  report_seams(garment, config, result);
  report_elastics(garment, result);
  report_under(garment, result);
  report_drops(start, garment, places, result);
  report_garment(garment, body, result);
  detail::measure_worn(start, garment, middle, result);
  if (landmarks) detail::measure_openings(start, garment, *landmarks, result);
  detail::measure_fit(zones, result);
  if (!config.motion.poses.empty()) {
    const PhaseTime time(result, "move");
    detail::follow_poses(garment, dressing, body, result);
  }
  return result;
}

}  // namespace selvedge
