// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/files.h>
#include <selvedge/core/measure.h>
#include <selvedge/core/resources.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/render/render.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/simulation/run_result.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kMarker = "dress";  // key of result.json by which the folder is recognized

// ---- axes ------------------------------------------------------------------------------------

/// The inverse of the rotation and scale of load_mesh.
Vec3 to_file(const Vec3& x, const LoadConfig& file) {
  const Vec3 y = x / file.unit;
  switch (file.up) {
    case UpAxis::x:
      return {y.z(), y.x(), y.y()};
    case UpAxis::y:
      return {y.x(), y.z(), -y.y()};
    case UpAxis::z:
      break;
  }
  return y;
}

std::vector<Vec3> to_file(std::span<const Vec3> x, const LoadConfig& file) {
  std::vector<Vec3> out;
  out.reserve(x.size());
  for (const Vec3& p : x) out.push_back(to_file(p, file));
  return out;
}

// ---- meshes ----------------------------------------------------------------------------------

void write_text_file(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

/// The garment with its vertices at `x`.
void write_garment_obj(const fs::path& file, const DressResult& result, std::span<const Vec3> x,
                       const LoadConfig& axes) {
  std::string text = "# flat pattern as texture coordinates, in metres\n";
  const auto out = std::back_inserter(text);
  for (const Vec3& p : to_file(x, axes))
    fmt::format_to(out, "v {:.17g} {:.17g} {:.17g}\n", p.x(), p.y(), p.z());
  for (const Vec3& u : result.flat.vertices)
    fmt::format_to(out, "vt {:.17g} {:.17g}\n", u.x(), u.y());
  std::int32_t panel = -1;
  for (std::size_t i = 0; i < result.garment.triangles.size(); ++i) {
    if (result.panel_of_triangle[i] != panel) {
      panel = result.panel_of_triangle[i];
      fmt::format_to(out, "g {}\n", result.panel_names[static_cast<std::size_t>(panel)]);
    }
    const Triangle &t = result.garment.triangles[i], &f = result.flat.triangles[i];
    fmt::format_to(out, "f {}/{} {}/{} {}/{}\n", t[0] + 1, f[0] + 1, t[1] + 1, f[1] + 1, t[2] + 1,
                   f[2] + 1);
  }
  write_text_file(file, text);
}

/// How a triangle is deformed: its area in the flat pattern (twice, m²), and the gradient of its
/// place over the pattern.
struct Deformation {
  double area = 0.0;
  Eigen::Matrix<double, 3, 2> gradient;
};
Deformation deformation(const DressResult& r, std::size_t triangle) {
  const Triangle &t = r.garment.triangles[triangle], &f = r.flat.triangles[triangle];
  Eigen::Matrix2d rest;
  Eigen::Matrix<double, 3, 2> now;
  for (int k = 0; k < 2; ++k) {
    rest.col(k) = (r.flat.vertices[f[k + 1]] - r.flat.vertices[f[0]]).head<2>();
    now.col(k) = r.garment.vertices[t[k + 1]] - r.garment.vertices[t[0]];
  }
  return {std::abs(rest.determinant()), now * rest.inverse()};
}

/// Strains along weft (x of the flat pattern) and warp (y) of each vertex: means over its
/// triangles, by area.
std::array<std::vector<double>, 2> weft_and_warp(const DressResult& r) {
  const std::size_t n = r.garment.vertices.size();
  std::array<std::vector<double>, 2> strain{std::vector<double>(n, 0.0),
                                            std::vector<double>(n, 0.0)};
  std::vector<double> area(n, 0.0);
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const auto [a, gradient] = deformation(r, i);
    for (const std::int32_t v : r.garment.triangles[i]) {
      for (int k = 0; k < 2; ++k) strain[k][v] += a * (gradient.col(k).norm() - 1.0);
      area[v] += a;
    }
  }
  for (std::size_t v = 0; v < n; ++v)
    for (std::vector<double>& s : strain) s[v] /= area[v];
  return strain;
}

void write_garment_ply(const fs::path& file, const DressResult& result, const LoadConfig& axes) {
  auto [weft, warp] = weft_and_warp(result);
  std::vector<NamedValues> values = {{"strain_warp", std::move(warp)},
                                     {"strain_weft", std::move(weft)},
                                     {"pressure", result.pressure},
                                     {"flag", {result.flags.begin(), result.flags.end()}, true}};
  write_ply(file, to_file(result.garment.vertices, axes), result.garment.triangles, values);
}

// ---- pictures --------------------------------------------------------------------------------

/// Largest principal strain of each triangle.
std::vector<double> largest_strains(const DressResult& r) {
  std::vector<double> strain;
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const auto gradient = deformation(r, i).gradient;
    const Eigen::Matrix2d c = gradient.transpose() * gradient;
    const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1));
    strain.push_back(std::sqrt(mean + std::hypot(half, c(0, 1))) - 1.0);
  }
  return strain;
}

/// Mean of the vertices of each triangle; empty without pressures.
std::vector<double> mean_pressures(const DressResult& r) {
  std::vector<double> mean;
  if (r.pressure.empty()) return mean;
  for (const Triangle& t : r.garment.triangles)
    mean.push_back((r.pressure[t[0]] + r.pressure[t[1]] + r.pressure[t[2]]) / 3.0);
  return mean;
}

/// Values of the triangles that a picture shows, from 0 to `top`; larger ones look like `top`.
struct ColourScale {
  std::vector<double> values;
  double top = 0.0;
};
/// Up to the value that 2 % of the triangles exceed, but at least `least`.
ColourScale scale_of(std::vector<double> values, double least) {
  if (values.empty()) return {{}, least};
  std::vector<double> sorted = values;
  const auto place =
      sorted.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(sorted.size() - 1));
  std::nth_element(sorted.begin(), place, sorted.end());
  return {std::move(values), std::max(least, *place)};
}
constexpr double kLeastStrain = 0.01, kLeastPressure = 10.0;  // -, Pa: the shortest scales

ColourScale strain_scale(const DressResult& r) {
  return scale_of(largest_strains(r), kLeastStrain);
}
ColourScale pressure_scale(const DressResult& r) {
  return scale_of(mean_pressures(r), kLeastPressure);
}

struct PanelDye {
  Vec3 front, back;  // linear RGB; the back is the inner side
};
constexpr double kPictureGrid = 0.05;  // m

const std::array<PanelDye, 4>& panel_dyes() {
  static const std::array<PanelDye, 4> list = {{{{0.045, 0.21, 0.27}, {0.62, 0.34, 0.050}},
                                                {{0.10, 0.27, 0.33}, {0.62, 0.34, 0.050}},
                                                {{0.03, 0.16, 0.22}, {0.62, 0.34, 0.050}},
                                                {{0.07, 0.24, 0.24}, {0.62, 0.34, 0.050}}}};
  return list;
}

/// The garment cut open along its seams, so that the grid of each panel is that of its pattern.
struct CutGarment {
  std::vector<Vec3> x;
  std::vector<Eigen::Vector2d> material;
  std::vector<std::vector<Triangle>> panels;
};

CutGarment cut(const DressResult& r, std::span<const Vec3> x) {
  CutGarment out;
  out.x.assign(r.flat.vertices.size(), Vec3::Zero());
  for (const Vec3& u : r.flat.vertices) out.material.emplace_back(u.x(), u.y());
  for (std::size_t i = 0; i < r.flat.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) out.x[r.flat.triangles[i][k]] = x[r.garment.triangles[i][k]];
    const auto panel = static_cast<std::size_t>(r.panel_of_triangle[i]);
    if (panel >= out.panels.size()) out.panels.resize(panel + 1);
    out.panels[panel].push_back(r.flat.triangles[i]);
  }
  return out;
}

std::pair<Vec3, Vec3> box_of(std::span<const Vec3> x) {
  Vec3 low = x.front(), high = x.front();
  for (const Vec3& p : x) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {low, high};
}

/// A garment and its body in one pose.
struct Worn {
  std::span<const Vec3> garment, body;
};

void draw(const fs::path& file, const DressResult& result, const Worn& worn,
          const std::vector<RenderSurface>& cloth, double side) {
  std::vector<RenderSurface> surfaces;
  RenderSurface skin;
  skin.x = worn.body;
  skin.triangles = result.body.triangles;
  skin.front = skin.back = Vec3(0.47, 0.475, 0.485);
  surfaces.push_back(skin);
  surfaces.insert(surfaces.end(), cloth.begin(), cloth.end());
  const auto [body_low, body_high] = box_of(worn.body);
  const auto [cloth_low, cloth_high] = box_of(worn.garment);
  const Vec3 low = body_low.cwiseMin(cloth_low), high = body_high.cwiseMax(cloth_high);
  const Vec3 centre = 0.5 * (low + high);
  Camera camera;
  camera.target = centre;
  camera.eye = centre + Vec3(0.5, side * -2.5, 0.4);
  camera.field_of_view = 30.0;
  camera.width = 720;
  camera.height = 720;
  write_png(file, render(framed(camera, low, high), surfaces));
}

/// NAMEfront.png and NAMEback.png.
void draw_both(const fs::path& folder, const std::string& name, const DressResult& result,
               const Worn& worn, const std::vector<RenderSurface>& cloth) {
  draw(folder / (name + "front.png"), result, worn, cloth, 1.0);
  draw(folder / (name + "back.png"), result, worn, cloth, -1.0);
}

void draw_dressed(const fs::path& folder, const std::string& name, const DressResult& result,
                  const Worn& worn) {
  const CutGarment garment = cut(result, worn.garment);
  std::vector<RenderSurface> panels;
  for (std::size_t p = 0; p < garment.panels.size(); ++p) {
    RenderSurface panel;
    panel.x = garment.x;
    panel.triangles = garment.panels[p];
    panel.front = panel_dyes()[p % panel_dyes().size()].front;
    panel.back = panel_dyes()[p % panel_dyes().size()].back;
    panel.material = garment.material;
    panel.grid = kPictureGrid;
    panel.sheen = 0.4;
    panels.push_back(panel);
  }
  draw_both(folder, name, result, worn, panels);
}

/// From dark blue over teal and green to yellow, linear RGB; `share` in [0,1].
Vec3 scale_colour(double share) {
  static const std::array<Vec3, 4> stops = {
      {{0.03, 0.05, 0.25}, {0.02, 0.30, 0.42}, {0.22, 0.55, 0.16}, {0.95, 0.75, 0.06}}};
  const double place = std::clamp(share, 0.0, 1.0) * 3.0;
  const auto k = std::min<std::size_t>(2, static_cast<std::size_t>(place));
  const double w = place - static_cast<double>(k);
  return (1.0 - w) * stops[k] + w * stops[k + 1];
}

/// The garment in colours of a scale, in steps: all triangles of a step are one surface.
void draw_scale(const fs::path& folder, const std::string& name, const DressResult& result,
                const ColourScale& scale) {
  constexpr std::size_t steps = 24;
  std::vector<std::vector<Triangle>> triangles(steps);
  for (std::size_t i = 0; i < scale.values.size(); ++i) {
    const double share = std::clamp(scale.values[i] / scale.top, 0.0, 1.0);
    triangles[static_cast<std::size_t>(share * (steps - 1) + 0.5)].push_back(
        result.garment.triangles[i]);
  }
  std::vector<RenderSurface> surfaces;
  for (std::size_t k = 0; k < steps; ++k) {
    if (triangles[k].empty()) continue;
    RenderSurface surface;
    surface.x = result.garment.vertices;
    surface.triangles = triangles[k];
    surface.front = surface.back = scale_colour(static_cast<double>(k) / (steps - 1));
    surfaces.push_back(surface);
  }
  draw_both(folder, name, result, {result.garment.vertices, result.body.vertices}, surfaces);
}

// ---- the folder ------------------------------------------------------------------------------

bool holds_dress_result(const fs::path& folder) {
  try {
    std::error_code ignored;
    const fs::path file = folder / "result.json";
    if (!fs::exists(file, ignored)) return false;
    std::FILE* in = std::fopen(file.c_str(), "rb");
    if (in == nullptr) return false;
    const Json json = Json::parse(in, nullptr, false);
    std::fclose(in);
    return json.is_object() && json.contains(kMarker);
  } catch (const std::exception&) {
    return false;
  }
}

void check_out(const fs::path& out) {
  std::error_code error;
  if (out.empty()) throw std::invalid_argument("dress: the result needs a folder; give --out");
  if (fs::exists(out, error) && !fs::is_directory(out, error))
    throw std::invalid_argument(out.string() + ": is a file; --out needs a folder");
  const bool is_used = fs::exists(out, error) && !fs::is_empty(out, error);
  if (is_used && !holds_dress_result(out))
    throw std::invalid_argument(out.string() +
                                ": holds other files; give --out an empty or new folder");
}

void make(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw std::invalid_argument(folder.string() + ": cannot be made: " + error.message());
}

class DressFolder {
 public:
  DressFolder(const DressFolderConfig& config) : config_(config) {
    check_out(config.out);
    make(config.out);
    lock_.emplace(config.out, "dress");
    for (const char* part : {"frames", "steps", "motion", "poses", "pictures", "garment.obj",
                             "garment.ply", "view.html"})
      fs::remove_all(config.out / part);
    write_text_file(config.out / "result.json", Json{{kMarker, "unfinished"}}.dump(2) + "\n");
    open(dressing_, config.out);
  }

  DressObserver observer() {
    DressObserver observer;
    observer.frame = [this](const Simulation& now, DressPhase phase, double time) {
      write_frame(series_of(phase), now, time);
    };
    if (config_.every_step)
      observer.accepted = [this](const Simulation& now, DressPhase phase) {
        write_step(series_of(phase), now);
      };
    observer.restart = [this] {
      dressing_ = {};
      for (const char* part : {"frames", "steps"}) fs::remove_all(config_.out / part);
      open(dressing_, config_.out);
    };
    observer.pose = [this](const Simulation& now, std::size_t) {
      poses_.emplace_back(now.positions().begin(), now.positions().end());
      last_body_ = now.body_positions();
    };
    return observer;
  }

  const std::vector<std::vector<Vec3>>& poses() const { return poses_; }  ///< m, of the garment
  const std::vector<Vec3>& last_body() const { return last_body_; }       ///< m, in the last pose

 private:
  /// Frames and steps of one folder.
  struct StateSeries {
    std::unique_ptr<FrameWriter> frames, steps;
    int frame = 0, step = 0;
  };

  void open(StateSeries& series, const fs::path& folder) {
    make(folder / "frames");
    series.frames = make_ply_writer(folder / "frames", kFrameFileDigits);
    if (!config_.every_step) return;
    make(folder / "steps");
    series.steps = make_ply_writer(folder / "steps", kStepFileDigits);
  }

  StateSeries& series_of(DressPhase phase) {
    if (phase != DressPhase::move) return dressing_;
    if (!motion_.frames) open(motion_, config_.out / "motion");
    return motion_;
  }

  void write_frame(StateSeries& series, const Simulation& now, double time) {
    write(*series.frames, now, series.frame++, time);
  }
  void write_step(StateSeries& series, const Simulation& now) {
    write(*series.steps, now, series.step++, now.time());
  }

  static void write(FrameWriter& writer, const Simulation& now, int number, double time) {
    const auto flags = now.flags();
    std::vector<NamedValues> values = {{"vx", {}}, {"vy", {}}, {"vz", {}}, {"flag", {}, true}};
    for (const Vec3& v : now.velocities())
      for (int k = 0; k < 3; ++k) values[static_cast<std::size_t>(k)].values.push_back(v[k]);
    values.back().values.assign(flags.begin(), flags.end());
    Frame frame{.number = number,
                .time = time,
                .x = now.positions(),
                .v = now.velocities(),
                .triangles = now.cloth_triangles(),
                .values = values,
                .bodies = {},
                .body_triangles = now.body_triangles()};
    if (number == 0 || now.bodies_move()) frame.bodies = now.body_positions();
    writer.write(frame);
  }

  const DressFolderConfig& config_;
  std::optional<FolderLock> lock_;
  StateSeries dressing_, motion_;
  std::vector<std::vector<Vec3>> poses_;
  std::vector<Vec3> last_body_;
};

std::string pose_name(const DressFolderConfig& folder, std::size_t pose) {
  return pose < folder.pose_names.size() ? folder.pose_names[pose] : fmt::format("{:04}", pose);
}

Json seam_json(const SeamReport& seam) {
  return {{"name", seam.name},
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
  return {{"name", result.panel_names[p]},
          {"moved_at_start_m", by.norm()},
          {"drop_m", result.panel_drop[p]}};
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

Json result_json(const std::string& pattern, const DressResult& r, const std::string& body_name) {
  Json json = {{kMarker, "finished"},
               {"pattern", pattern},
               {"body", body_name},
               {"verdict", r.good() ? "good" : r.fault()},
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
               {"drop_m", r.drop},
               {"body_vertices_moved_back", r.body_moved},
               {"body_moved_back_m", r.body_moved_by},
               {"states_judged", r.states},
               {"sewing_attempts", r.attempts},
               {"vertices", r.garment.vertices.size()},
               {"triangles", r.garment.triangles.size()},
               {"simulated_sew_s", r.sew_time},
               {"simulated_settle_s", r.settle_time},
               {"state_hash", r.state_hash}};
  json["strain_scale_top"] = strain_scale(r).top;
  json["pressure_scale_top_Pa"] = pressure_scale(r).top;
  json["panels"] = Json::array();
  for (std::size_t p = 0; p < r.panel_names.size(); ++p) json["panels"].push_back(panel_json(r, p));
  json["seams"] = Json::array();
  for (const SeamReport& seam : r.seams) json["seams"].push_back(seam_json(seam));
  if (!r.poses.empty() || !r.motion_fault.empty()) json["motion"] = motion_json(r);
  json["seconds"] = seconds_json(r);
  json["notes"] = r.notes;
  return json;
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_failure(const fs::path& out, const std::string& pattern, const std::string& body_name,
                   const std::string& why) {
  const Json json = {{kMarker, "failed"},
                     {"pattern", pattern},
                     {"body", body_name},
                     {"verdict", why},
                     {"good", false}};
  write_text_file(out / "result.json", text_of(json));
}

void write_pictures(const fs::path& folder, const DressResult& result, const DressFolder& files) {
  make(folder);
  draw_dressed(folder, "", result, {result.garment.vertices, result.body.vertices});
  draw_scale(folder, "strain_", result, strain_scale(result));
  draw_scale(folder, "pressure_", result, pressure_scale(result));
  if (!files.poses().empty())
    draw_dressed(folder, "last_pose_", result, {files.poses().back(), files.last_body()});
}

void write_poses(const DressFolderConfig& folder, const DressResult& result,
                 const DressFolder& files) {
  if (files.poses().empty()) return;
  make(folder.out / "poses");
  for (std::size_t k = 0; k < files.poses().size(); ++k)
    write_garment_obj(folder.out / "poses" / (pose_name(folder, k) + ".obj"), result,
                      files.poses()[k], folder.body_file);
}

}  // namespace

std::string dress_result_text(const std::string& pattern_name, const DressResult& result,
                              const std::string& body_name) {
  return text_of(result_json(pattern_name, result, body_name));
}

DressResult dress_into_folder(const SewingPattern& pattern, const TriangleMesh& body,
                              const DressConfig& config, const DressFolderConfig& folder,
                              const Methods& methods) {
  DressFolder files(folder);
  try {
    DressResult result = dress(pattern, body, config, methods, files.observer());
    const Stopwatch output;
    write_garment_obj(folder.out / "garment.obj", result, result.garment.vertices,
                      folder.body_file);
    write_garment_ply(folder.out / "garment.ply", result, folder.body_file);
    write_poses(folder, result, files);
    if (folder.pictures) write_pictures(folder.out / "pictures", result, files);
    result.seconds["output"] = output.seconds();
    write_text_file(folder.out / "result.json",
                    dress_result_text(pattern.name, result, folder.body_name));
    return result;
  } catch (const DressFailed& failure) {
    write_failure(folder.out, pattern.name, folder.body_name, failure.what());
    throw;
  }
}

}  // namespace selvedge
