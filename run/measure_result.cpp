// SPDX-License-Identifier: MIT
#include <selvedge/run/measure_result.h>

#include <fmt/format.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/result_folder.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace selvedge {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

/// One frame of a result.
struct FrameState {
  std::vector<Vec3> x, v;
  std::vector<double> mass;
  double time = 0.0;

  ForceState view() const { return {x, v, mass, time}; }
};

fs::path frame_file(const fs::path& result, const char* stem, int frame) {
  return numbered(result / "frames", stem, frame, kFrameFileDigits, ".ply");
}

/// The velocities of a frame, m/s.
std::vector<Vec3> velocities_of(const std::vector<NamedValues>& values, std::size_t vertices) {
  std::vector<Vec3> v(vertices, Vec3::Zero());
  const std::string names[] = {"vx", "vy", "vz"};
  for (const NamedValues& named : values)
    for (int axis = 0; axis < 3; ++axis)
      if (named.name == names[axis])
        for (std::size_t i = 0; i < vertices; ++i) v[i][axis] = named.values[i];
  return v;
}

Scene read_scene_of(const fs::path& result, const Methods& methods) {
  const fs::path file = result / "scene.json";
  if (!fs::exists(file))
    throw std::invalid_argument(result.string() +
                                ": holds no scene.json; name the result folder of a run");
  return read_scene(file, {}, methods);
}

/// Reads the frames of a result and measures them.
class Measurement {
 public:
  Measurement(const fs::path& result, const Methods& methods)
      : result_(result), scene_(read_scene_of(result, methods)), built_(build_scene(scene_)) {
    while (fs::exists(frame_file(result_, "cloth", frames_))) ++frames_;
    if (frames_ == 0)
      throw std::invalid_argument(result_.string() + ": has no frames; run the scene first");
  }

  ResultMeasures measure(const MeasureConfig& config) const {
    ResultMeasures m;
    m.scene = scene_.name;
    m.frame = config.frame < 0 ? frames_ - 1 : config.frame;
    if (m.frame >= frames_)
      throw std::invalid_argument(fmt::format("{}: has no frame {}; the last one is {}",
                                              result_.string(), m.frame, frames_ - 1));
    FrameState state = read_frame(m.frame);
    measure_strains(state, m);
    m.joule = energies(scene_, built_, state.view());
    for (int frame = 0; frame < frames_; ++frame) m.frames.push_back(energies_of(frame));
    m.support = support(config);
    if (m.support) m.drape = measure_drape(built_, state.x, *m.support);
    m.x = std::move(state.x);
    m.triangles = built_.cloth.surface.triangles;
    return m;
  }

 private:
  FrameState read_frame(int frame) const {
    std::vector<NamedValues> values;
    const fs::path file = frame_file(result_, "cloth", frame);
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

  void measure_strains(const FrameState& state, ResultMeasures& m) const {
    m.triangle_strains = triangle_strains(state.x, built_.cloth.surface.triangles, built_.rest);
    for (const Spring& s : built_.cloth.springs)
      m.spring_strains.push_back(
          {s.a, s.b, (state.x[s.b] - state.x[s.a]).norm() / s.rest_length - 1.0});
    m.sheet = summary_of(m.triangle_strains);
    m.springs = selvedge::spring_strains(built_.cloth.springs, state.x);
    constexpr double least = 1e-4, sigmas = 2.0;
    m.picture_range = std::max(least, sigmas * m.sheet.rms);
  }

  FrameEnergies energies_of(int frame) const {
    const FrameState state = read_frame(frame);
    const double rest = surface_area(built_.rest.vertices, built_.rest.triangles);
    return {.time = state.time,
            .joule = energies(scene_, built_, state.view()),
            .spring_strain = selvedge::spring_strains(built_.cloth.springs, state.x).mean,
            .area_growth = surface_area(state.x, built_.cloth.surface.triangles) / rest - 1.0};
  }

  std::optional<DrapeSupport> support(const MeasureConfig& config) const {
    std::optional<DrapeSupport> found = drape_support(scene_);
    if (config.support_radius) {
      if (!found) found.emplace();
      found->radius = *config.support_radius;
    }
    if (config.support_centre) {
      if (!found)
        throw std::invalid_argument(
            "a centre of the support needs its radius, because the scene has no upright cylinder");
      found->centre = Vec3(config.support_centre->x(), config.support_centre->y(), 0.0);
    }
    return found;
  }

  fs::path result_;
  Scene scene_;
  BuiltScene built_;
  int frames_ = 0;
};

// -- tables ---------------------------------------------------------------------------------------

void write_text(const fs::path& file, const std::string& text) {
  AtomicFile out(file);
  out.write(text);
  out.commit();
}

std::string strain_table(const ResultMeasures& m) {
  std::string text = "triangle,larger,smaller,area_m2\n";
  for (std::size_t i = 0; i < m.triangle_strains.size(); ++i) {
    const TriangleStrain& s = m.triangle_strains[i];
    text += fmt::format("{},{:.9g},{:.9g},{:.9g}\n", i, s.larger, s.smaller, s.area);
  }
  return text;
}

std::string spring_table(const ResultMeasures& m) {
  std::string text = "a,b,strain\n";
  for (const SpringStrain& s : m.spring_strains)
    text += fmt::format("{},{},{:.9g}\n", s.a, s.b, s.strain);
  return text;
}

std::string energy_table(const ResultMeasures& m) {
  std::string text = "time_s";
  for (const auto& [part, value] : m.joule) text += "," + part + "_J";
  text += ",strain_mean,area_growth\n";
  for (const FrameEnergies& frame : m.frames) {
    text += fmt::format("{:.6g}", frame.time);
    for (const auto& [part, value] : frame.joule) text += fmt::format(",{:.9g}", value);
    text += fmt::format(",{:.9g},{:.9g}\n", frame.spring_strain, frame.area_growth);
  }
  return text;
}

std::string rim_table(const RimProfile& rim) {
  std::string text = "angle_deg,radius_m,height_m\n";
  for (std::size_t k = 0; k < rim.radius.size(); ++k)
    text += fmt::format("{:.6g},{:.9g},{:.9g}\n", 360.0 * k / rim.radius.size(), rim.radius[k],
                        rim.height[k]);
  return text;
}

std::string spectrum_table(const RimProfile& rim) {
  std::string text = "order,amplitude_m\n";
  for (std::size_t n = 0; n < rim.amplitude.size(); ++n)
    text += fmt::format("{},{:.9g}\n", n, rim.amplitude[n]);
  return text;
}

Json to_json(const StrainSummary& s) {
  return {{"max", s.max}, {"min", s.min}, {"rms", s.rms}, {"mean", s.mean}};
}

}  // namespace

ResultMeasures measure_result(const fs::path& result, const MeasureConfig& config,
                              const Methods& methods) {
  return Measurement(result, methods).measure(config);
}

std::string measures_text(const ResultMeasures& m) {
  Json json = {{"scene", m.scene},
               {"frame", m.frame},
               {"strain", to_json(m.sheet)},
               {"spring_strain", to_json(m.springs)},
               {"strain_picture_range", m.picture_range},
               {"energy_J", m.joule}};
  if (m.drape)
    json["drape"] = {{"shadow_m2", m.drape->shadow},
                     {"specimen_m2", m.drape->specimen},
                     {"support_m2", m.drape->support},
                     {"drape_coefficient", m.drape->drape_coefficient},
                     {"folds", m.drape->rim.folds},
                     {"fold_maxima", m.drape->rim.maxima},
                     {"fold_amplitude_m", m.drape->rim.amplitude[m.drape->rim.folds]},
                     {"rim_mean_m", m.drape->rim.amplitude[0]}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_measure_tables(const ResultMeasures& m, const fs::path& folder) {
  write_text(folder / "strain.csv", strain_table(m));
  write_text(folder / "springs.csv", spring_table(m));
  write_text(folder / "energy.csv", energy_table(m));
  if (!m.drape) return;
  write_text(folder / "rim.csv", rim_table(m.drape->rim));
  write_text(folder / "spectrum.csv", spectrum_table(m.drape->rim));
}

}  // namespace selvedge
