// SPDX-License-Identifier: MIT
#include "command_measure.h"

#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/files.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/run/result_pictures.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <selvedge/lab/measure_pictures.h>
#include <selvedge/scene/methods.h>

namespace {

using namespace selvedge;
using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct MeasureOptions {
  std::string result, out;
  int frame = -1;
  double support = 0.0;
  std::vector<double> centre;
  bool json = false, no_picture = false;
};

void write_text(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

/// One frame of a result.
struct FrameState {
  std::vector<Vec3> x, v;
  std::vector<double> mass;
  double time = 0.0;

  ForceState view() const { return {x, v, mass, time}; }
};

/// Velocities, m/s, as a frame has them.
std::vector<Vec3> velocities_of(const std::vector<NamedValues>& values, std::size_t vertices) {
  std::vector<Vec3> v(vertices, Vec3::Zero());
  const std::string names[] = {"vx", "vy", "vz"};
  for (const NamedValues& named : values)
    for (int axis = 0; axis < 3; ++axis)
      if (named.name == names[axis])
        for (std::size_t i = 0; i < vertices; ++i) v[i][axis] = named.values[i];
  return v;
}

class Measurement {
 public:
  explicit Measurement(const MeasureOptions& o)
      : o_(o), folder_(o.result), scene_(read_scene_of(folder_)), built_(build_scene(scene_)) {
    while (fs::exists(frame_file(frames_))) ++frames_;
    if (frames_ == 0)
      throw std::invalid_argument(folder_.string() + ": has no frames; run the scene first");
    frame_ = o.frame < 0 ? frames_ - 1 : o.frame;
    if (frame_ >= frames_)
      throw std::invalid_argument(
          fmt::format("{}: has no frame {}; the last one is {}", o.result, frame_, frames_ - 1));
    state_ = read_frame(frame_);
    strains_ = triangle_strains(state_.x, built_.cloth.surface.triangles, built_.rest);
    support_ = support();
    if (support_) drape_ = measure_drape(built_, state_.x, *support_);
  }

  void run() {
    const fs::path out = o_.out.empty() ? folder_ / "measures" : fs::path(o_.out);
    std::error_code error;
    fs::create_directories(out, error);
    if (error) throw std::invalid_argument(out.string() + ": cannot be made: " + error.message());
    write_tables(out);
    if (!o_.no_picture) draw(out);
    const std::string text = summary().dump(2, ' ', false, Json::error_handler_t::replace);
    write_text(out / "measures.json", text + "\n");
    if (o_.json)
      fmt::print("{}\n", text);
    else
      print_report(out);
  }

 private:
  static Scene read_scene_of(const fs::path& folder) {
    const fs::path file = folder / "scene.json";
    if (!fs::exists(file))
      throw std::invalid_argument(folder.string() +
                                  ": holds no scene.json; name the result folder of a run");
    return read_scene(file, {}, methods_of_this_build());
  }

  fs::path frame_file(int frame) const {
    return numbered(folder_ / "frames", "cloth", frame, kFrameFileDigits, ".ply");
  }

  FrameState read_frame(int frame) const {
    std::vector<NamedValues> values;
    const fs::path file = frame_file(frame);
    FrameState state;
    state.x = read_ply(file, values).vertices;
    state.v = velocities_of(values, state.x.size());
    state.mass = built_.cloth.mass;
    state.time = frame / scene_.time.fps;
    if (state.x.size() != state.mass.size())
      throw std::invalid_argument(fmt::format("{}: has {} vertices, but the scene has {}",
                                              file.string(), state.x.size(), state.mass.size()));
    for (const NamedValues& named : values)
      if (named.name == "water")
        for (std::size_t i = 0; i < state.mass.size(); ++i) state.mass[i] += named.values[i];
    return state;
  }

  std::optional<DrapeSupport> support() const {
    std::optional<DrapeSupport> found = drape_support(scene_);
    if (o_.support > 0.0) {
      if (!found) found.emplace();
      found->radius = o_.support;
    }
    if (!o_.centre.empty()) {
      if (!found)
        throw std::invalid_argument(
            "measure: --centre needs --support, because the scene has no upright cylinder");
      found->centre = Vec3(o_.centre[0], o_.centre[1], 0.0);
    }
    return found;
  }

  void write_tables(const fs::path& out) const {
    std::string strain = "triangle,larger,smaller,area_m2\n";
    for (std::size_t i = 0; i < strains_.size(); ++i)
      strain += fmt::format("{},{:.9g},{:.9g},{:.9g}\n", i, strains_[i].larger, strains_[i].smaller,
                            strains_[i].area);
    write_text(out / "strain.csv", strain);
    write_text(out / "springs.csv", spring_table());
    write_text(out / "energy.csv", energy_table());
    if (!drape_) return;
    const RimProfile& rim = drape_->rim;
    std::string text = "angle_deg,radius_m,height_m\n";
    for (std::size_t k = 0; k < rim.radius.size(); ++k)
      text += fmt::format("{:.6g},{:.9g},{:.9g}\n", 360.0 * k / rim.radius.size(), rim.radius[k],
                          rim.height[k]);
    write_text(out / "rim.csv", text);
    text = "order,amplitude_m\n";
    for (std::size_t n = 0; n < rim.amplitude.size(); ++n)
      text += fmt::format("{},{:.9g}\n", n, rim.amplitude[n]);
    write_text(out / "spectrum.csv", text);
  }

  std::string spring_table() const {
    std::string text = "a,b,strain\n";
    for (const Spring& s : built_.cloth.springs)
      text += fmt::format("{},{},{:.9g}\n", s.a, s.b,
                          (state_.x[s.b] - state_.x[s.a]).norm() / s.rest_length - 1.0);
    return text;
  }

  std::string energy_table() const {
    std::string text;
    for (int frame = 0; frame < frames_; ++frame) {
      const FrameState state = read_frame(frame);
      const auto joules = energies(scene_, built_, state.view());
      if (text.empty()) {
        text = "time_s";
        for (const auto& [part, value] : joules) text += "," + part + "_J";
        text += ",strain_mean,area_growth\n";
      }
      text += fmt::format("{:.6g}", state.time);
      for (const auto& [part, value] : joules) text += fmt::format(",{:.9g}", value);
      text += face_strain(state);
    }
    return text;
  }

  /// [Ji2006]: mean strain of the springs and growth of the summed area, its "face strain".
  std::string face_strain(const FrameState& state) const {
    const double rest = surface_area(built_.rest.vertices, built_.rest.triangles);
    return fmt::format(",{:.9g},{:.9g}\n", spring_strains(built_.cloth.springs, state.x).mean,
                       surface_area(state.x, built_.cloth.surface.triangles) / rest - 1.0);
  }

  double strain_range() const {
    const StrainSummary sum = summary_of(strains_);
    constexpr double least = 1e-4, sigmas = 2.0;
    return std::max(least, sigmas * sum.rms);
  }

  void draw(const fs::path& out) const {
    ResultPictures pictures(folder_);
    const std::vector<int> shown = {frame_};
    const Camera camera = pictures.camera({}, shown);
    std::vector<RenderSurface> bodies;
    TriangleMesh body;
    fs::path file = numbered(folder_ / "frames", "bodies", frame_, kFrameFileDigits, ".ply");
    if (!fs::exists(file))
      file = numbered(folder_ / "frames", "bodies", 0, kFrameFileDigits, ".ply");
    if (fs::exists(file)) {
      body = read_mesh(file);
      RenderSurface surface{body.vertices, body.triangles};
      surface.front = surface.back = Vec3(0.35, 0.36, 0.38);
      surface.crease = 40.0;
      bodies.push_back(surface);
    }
    write_png(out / "strain.png", draw_strain(camera, {state_.x, built_.cloth.surface.triangles,
                                                       strains_, bodies, strain_range()}));
    if (!drape_) return;
    write_png(out / "shadow.png",
              draw_shadow(state_.x, built_.cloth.surface.triangles, *drape_, *support_));
    write_png(out / "spectrum.png", draw_spectrum(drape_->rim));
  }

  Json summary() const {
    const StrainSummary sheet = summary_of(strains_),
                        springs = spring_strains(built_.cloth.springs, state_.x);
    const auto strain = [](const StrainSummary& s) {
      return Json{{"max", s.max}, {"min", s.min}, {"rms", s.rms}, {"mean", s.mean}};
    };
    Json json = {{"scene", scene_.name},
                 {"frame", frame_},
                 {"strain", strain(sheet)},
                 {"spring_strain", strain(springs)},
                 {"strain_picture_range", strain_range()},
                 {"energy_J", energies(scene_, built_, state_.view())}};
    if (!drape_) return json;
    json["drape"] = {{"shadow_m2", drape_->shadow},
                     {"specimen_m2", drape_->specimen},
                     {"support_m2", drape_->support},
                     {"drape_coefficient", drape_->drape_coefficient},
                     {"folds", drape_->rim.folds},
                     {"fold_maxima", drape_->rim.maxima},
                     {"fold_amplitude_m", drape_->rim.amplitude[drape_->rim.folds]},
                     {"rim_mean_m", drape_->rim.amplitude[0]}};
    return json;
  }

  void print_report(const fs::path& out) const {
    const StrainSummary sheet = summary_of(strains_),
                        springs = spring_strains(built_.cloth.springs, state_.x);
    fmt::print("{}, frame {}; tables and pictures in {}\n", scene_.name, frame_, out.string());
    fmt::print("  strain of triangles  {:.3f} to {:.3f} %, rms {:.3f} %\n", 100.0 * sheet.min,
               100.0 * sheet.max, 100.0 * sheet.rms);
    fmt::print("  strain of springs    {:.3f} to {:.3f} %, rms {:.3f} %\n", 100.0 * springs.min,
               100.0 * springs.max, 100.0 * springs.rms);
    for (const auto& [part, joules] : energies(scene_, built_, state_.view()))
      fmt::print("  energy, {:<17} {:.6g} J\n", part, joules);
    if (!drape_) {
      fmt::print("  no drape coefficient: {}\n",
                 support_ ? "the rim does not go around the support"
                          : "no upright cylinder in the scene; give --support");
      return;
    }
    fmt::print(
        "  drape coefficient    {:.2f} %   (shadow {:.2f} cm2, specimen {:.2f} cm2, support "
        "{:.2f} cm2)\n",
        drape_->drape_coefficient, 1e4 * drape_->shadow, 1e4 * drape_->specimen,
        1e4 * drape_->support);
    fmt::print("  folds                {} (strongest order of the rim, {:.2f} mm), {} maxima\n",
               drape_->rim.folds, 1e3 * drape_->rim.amplitude[drape_->rim.folds],
               drape_->rim.maxima);
  }

  const MeasureOptions& o_;
  fs::path folder_;
  Scene scene_;
  BuiltScene built_;
  int frames_ = 0, frame_ = 0;
  FrameState state_;
  std::vector<TriangleStrain> strains_;
  std::optional<DrapeSupport> support_;
  std::optional<DrapeMeasures> drape_;
};

}  // namespace

void add_command_measure(const Command& app) {
  const auto o = std::make_shared<MeasureOptions>();
  const Command command =
      app.subcommand("measure",
                     "Measure drape coefficient, folds, strains and energies of a result; "
                     "write tables and pictures");
  command.option("RESULT", o->result, "Result folder of a run").required();
  command.option("--frame", o->frame, "Number of the frame (default: the last one)")
      .range(0, 99999);
  command
      .option("--support", o->support,
              "Radius of the support, m (default: that of the scene's first upright "
              "cylinder)")
      .positive();
  command.option("--centre", o->centre, "Centre of the support, x and y, m").words(2);
  command.option("--out", o->out, "Folder for tables and pictures (default: RESULT/measures)");
  command.flag("--no-picture", o->no_picture, "Draw no pictures");
  command.flag("--json", o->json, "Print measures.json");
  command.action([o] {
    Measurement(*o).run();
    return 0;
  });
}
