// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/core/base/internal/stopwatch.h>
#include <selvedge/core/cloth/measure.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/core/system/internal/read_file.h>
#include <selvedge/dress/detail/colour_scales.h>
#include <selvedge/dress/detail/deformation.h>
#include <selvedge/dress/detail/dressing.h>
#include <selvedge/dress/detail/fit_page.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/pictures/picture_files.h>
#include <selvedge/pictures/renderer/internal/garment_views.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/internal/flat_texture.h>
#include <selvedge/run/internal/part_colours.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/simulation/run_result.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>

namespace selvedge {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using detail::pressure_scale, detail::strain_scale;

constexpr const char* kMarker = "dress";  // key of result.json by which the folder is recognized

std::string under_file(std::size_t k) { return fmt::format("under/{}.obj", k); }

// ---- axes ------------------------------------------------------------------------------------

/// The inverse of the rotation and scale of load_mesh.
Vec3 to_file(const Vec3& x, const LoadConfig& file) {
  const Vec3 y = x / file.unit.value_or(1.0);
  switch (file.up.value_or(UpAxis::z)) {
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

/// Text of an OBJ file while it is made; `x` in metres, z up.
class ObjText {
 public:
  ObjText(std::span<const Vec3> x, const TriangleMesh& flat, const LoadConfig& axes) : flat_(flat) {
    for (const Vec3& p : to_file(x, axes))
      fmt::format_to(out(), "v {:.17g} {:.17g} {:.17g}\n", p.x(), p.y(), p.z());
    for (const Vec3& u : flat.vertices) fmt::format_to(out(), "vt {:.17g} {:.17g}\n", u.x(), u.y());
  }

  void add_group(const std::string& name) { fmt::format_to(out(), "g {}\n", name); }
  /// Triangle i of the flat pattern, whose corners are `t`.
  void add_face(const Triangle& t, std::size_t i) {
    const Triangle& f = flat_.triangles[i];
    fmt::format_to(out(), "f {}/{} {}/{} {}/{}\n", t[0] + 1, f[0] + 1, t[1] + 1, f[1] + 1, t[2] + 1,
                   f[2] + 1);
  }
  const std::string& text() const { return text_; }

 private:
  std::back_insert_iterator<std::string> out() { return std::back_inserter(text_); }

  const TriangleMesh& flat_;
  std::string text_ = "# flat pattern as texture coordinates, in metres\n";
};

/// The garment with its vertices at `x`.
void write_garment_obj(const fs::path& file, const DressResult& result, std::span<const Vec3> x,
                       const LoadConfig& axes) {
  ObjText obj(x, result.flat, axes);
  std::int32_t panel = -1;
  for (std::size_t i = 0; i < result.garment.triangles.size(); ++i) {
    if (result.panel_of_triangle[i] != panel) {
      panel = result.panel_of_triangle[i];
      obj.add_group(result.panel_names[static_cast<std::size_t>(panel)]);
    }
    obj.add_face(result.garment.triangles[i], i);
  }
  write_text_file(file, obj.text());
}

/// The body on which the garment lies, where it differs from that of the user.
void write_body(const fs::path& file, const TriangleMesh& body, const LoadConfig& axes) {
  std::string text = "# the body on which garment.obj lies\n";
  for (const Vec3& p : to_file(body.vertices, axes))
    fmt::format_to(std::back_inserter(text), "v {:.17g} {:.17g} {:.17g}\n", p.x(), p.y(), p.z());
  for (const Triangle& t : body.triangles)
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  write_text_file(file, text);
}

/// The garments below as they lie now: under/0.obj is the innermost.
void write_under(const fs::path& out, const DressResult& result, const LoadConfig& axes) {
  for (std::size_t k = 0; k < result.under.size(); ++k) {
    const WornGarment& worn = result.under[k].garment;
    ObjText obj(worn.surface.vertices, worn.flat, axes);
    for (std::size_t i = 0; i < worn.surface.triangles.size(); ++i)
      obj.add_face(worn.surface.triangles[i], i);
    write_text_file(out / under_file(k), obj.text());
  }
}

/// Strains along weft (x of the flat pattern) and warp (y) of each vertex: means over its
/// triangles, by area.
std::array<std::vector<double>, 2> weft_and_warp(const DressResult& r) {
  const std::size_t n = r.garment.vertices.size();
  std::array<std::vector<double>, 2> strain{std::vector<double>(n, 0.0),
                                            std::vector<double>(n, 0.0)};
  std::vector<double> area(n, 0.0);
  for (std::size_t i = 0; i < r.garment.triangles.size(); ++i) {
    const auto [a, gradient] = detail::deformation(r.garment, r.flat, i);
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

// ---- the folder ------------------------------------------------------------------------------

bool holds_dress_result(const fs::path& folder) {
  try {
    const Json json = Json::parse(read_if_there(folder / "result.json"), nullptr, false);
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
  DressFolder(const DressFolderConfig& config, const TriangleMesh& body,
              const std::vector<WornGarment>& under)
      : config_(config), body_(body), under_(under) {
    for (const std::string& name : config.pose_formats)
      formats_.at(name);  // refuses an unknown one
    check_out(config.out);
    make(config.out);
    lock_.emplace(config.out, "dress");
    for (const char* part : {"frames", "steps", "motion", "poses", "pictures", "under",
                             "garment.obj", "garment.ply", "body.obj", "view.html", "fit.html"})
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
      const auto own = detail::of_garment(now, now.positions());
      poses_.emplace_back(own.begin(), own.end());
      last_cloth_.assign(now.positions().begin(), now.positions().end());
      last_body_ = now.body_positions();
    };
    return observer;
  }

  /// Completes the files of the motion.
  void finish() {
    for (const auto& other : motion_.others) other->finish();
  }

  const std::vector<std::vector<Vec3>>& poses() const { return poses_; }  ///< m, of the garment
  const std::vector<Vec3>& last_cloth() const { return last_cloth_; }  ///< m, all, in the last pose
  const std::vector<Vec3>& last_body() const { return last_body_; }    ///< m, in the last pose

 private:
  /// Frames and steps of one folder.
  struct StateSeries {
    std::unique_ptr<FrameWriter> frames, steps;
    std::vector<std::unique_ptr<FrameWriter>> others;  // of `pose_formats`
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
    if (!motion_.frames) {
      open(motion_, config_.out / "motion");
      for (const std::string& name : config_.pose_formats)
        motion_.others.push_back(
            make_method(formats_, name, "pose_formats", {}, config_.out / "motion"));
    }
    return motion_;
  }

  void write_frame(StateSeries& series, const Simulation& now, double time) {
    write(*series.frames, series.others, now, series.frame++, time);
  }
  void write_step(StateSeries& series, const Simulation& now) {
    write(*series.steps, {}, now, series.step++, now.time());
  }

  /// The cloth of a state. Garments below belong to it also while they rest as bodies do.
  struct ClothState {
    std::vector<Vec3> x, v;
    std::vector<Triangle> triangles;
    std::vector<double> flags;
  };
  ClothState cloth_of(const Simulation& now) const {
    const auto x = now.positions(), v = now.velocities();
    const auto triangles = now.cloth_triangles();
    const auto flags = now.flags();
    ClothState cloth{{x.begin(), x.end()},
                     {v.begin(), v.end()},
                     {triangles.begin(), triangles.end()},
                     {flags.begin(), flags.end()}};
    if (now.built().piece_begin.size() > 2) return cloth;
    for (const WornGarment& worn : under_) {
      const auto first = static_cast<std::int32_t>(cloth.x.size());
      cloth.x.insert(cloth.x.end(), worn.surface.vertices.begin(), worn.surface.vertices.end());
      for (Triangle t : worn.surface.triangles) {
        for (std::int32_t& vertex : t) vertex += first;
        cloth.triangles.push_back(t);
      }
    }
    cloth.v.resize(cloth.x.size(), Vec3::Zero());
    cloth.flags.resize(cloth.x.size(), 0.0);
    return cloth;
  }

  /// The garments of a moving body as pieces with their colours.
  std::vector<FramePart> pieces_of(const Simulation& now) const {
    const std::vector<std::int32_t>& begin = now.built().piece_begin;
    std::vector<FramePart> pieces;
    for (std::size_t p = 0; p + 1 < begin.size(); ++p)
      pieces.push_back({p == 0 ? "garment" : "under_" + std::to_string(p - 1),
                        static_cast<std::size_t>(begin[p]),
                        static_cast<std::size_t>(begin[p + 1] - begin[p]), piece_dye(p).front});
    return pieces;
  }

  void write(FrameWriter& writer, const std::vector<std::unique_ptr<FrameWriter>>& others,
             const Simulation& now, int number, double time) const {
    ClothState cloth = cloth_of(now);
    std::vector<NamedValues> values = {
        {"vx", {}}, {"vy", {}}, {"vz", {}}, {"flag", std::move(cloth.flags), true}};
    for (const Vec3& v : cloth.v)
      for (int k = 0; k < 3; ++k) values[static_cast<std::size_t>(k)].values.push_back(v[k]);
    Frame frame{.number = number,
                .time = time,
                .x = cloth.x,
                .v = cloth.v,
                .triangles = cloth.triangles,
                .values = values,
                .bodies = {},
                .body_triangles = now.body_triangles().first(body_.triangles.size())};
    if (number == 0 || now.bodies_move())
      frame.bodies = std::span(now.body_positions()).first(body_.vertices.size());
    writer.write(frame);
    if (others.empty()) return;
    const std::vector<FramePart> pieces = pieces_of(now);
    const std::array<FramePart, 1> bodies = {{{"body", 0, body_.vertices.size(), body_colour()}}};
    const auto texture = flat_texture(now.built());
    frame.pieces = pieces;
    frame.body_parts = bodies;
    frame.texture = texture;
    for (const auto& other : others) {
      other->write(frame);
      other->update_series();
    }
  }

  const FrameFormatRegistry formats_ = frame_formats();
  const DressFolderConfig& config_;
  const TriangleMesh& body_;
  const std::vector<WornGarment>& under_;
  std::optional<FolderLock> lock_;
  StateSeries dressing_, motion_;
  std::vector<std::vector<Vec3>> poses_;
  std::vector<Vec3> last_cloth_, last_body_;
};

std::string pose_name(const DressFolderConfig& folder, std::size_t pose) {
  return pose < folder.pose_names.size() ? folder.pose_names[pose] : fmt::format("{:04}", pose);
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

PicturedGarment pictured(const DressResult& r, std::span<const Vec3> cloth,
                         std::span<const Vec3> body) {
  PicturedGarment garment{.cloth = cloth,
                          .triangles = r.garment.triangles,
                          .pattern = r.flat,
                          .panel_of_triangle = r.panel_of_triangle,
                          .below = {},
                          .body = body,
                          .body_triangles = r.body.triangles};
  for (const UnderReport& under : r.under) garment.below.push_back(&under.garment.surface);
  return garment;
}

/// NAMEfront.png and so on.
void write_views(const fs::path& folder, const std::string& name,
                 const std::vector<GarmentView>& views) {
  for (const GarmentView& view : views)
    write_png(folder / (name + view.side + ".png"), view.picture);
}

void write_pictures(const fs::path& folder, const DressResult& result, const DressFolder& files) {
  make(folder);
  const std::vector<Vec3> cloth = detail::all_cloth(result);
  const PicturedGarment garment = pictured(result, cloth, result.body.vertices);
  write_views(folder, "", views_of_panels(garment));
  write_views(folder, "strain_", views_by_scale(garment, strain_scale(result)));
  write_views(folder, "pressure_", views_by_scale(garment, pressure_scale(result)));
  write_views(folder, "fit_", views_by_colour(garment, detail::fit_colours(result)));
  if (!files.poses().empty())
    write_views(folder, "last_pose_",
                views_of_panels(pictured(result, files.last_cloth(), files.last_body())));
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

DressResult dress_into_folder(const SewingPattern& pattern, const TriangleMesh& body,
                              const DressConfig& config, const DressFolderConfig& folder,
                              const Methods& methods) {
  DressConfig with_fabrics = config;
  find_fabrics(pattern, fs::path(pattern.name).parent_path(), with_fabrics);
  DressFolder files(folder, body, config.under);
  try {
    DressResult result = dress(pattern, body, with_fabrics, methods, files.observer());
    const Stopwatch output;
    files.finish();
    write_garment_obj(folder.out / "garment.obj", result, result.garment.vertices,
                      folder.body_file);
    write_garment_ply(folder.out / "garment.ply", result, folder.body_file);
    if (result.body_moved > 0) write_body(folder.out / "body.obj", result.body, folder.body_file);
    if (!result.under.empty()) make(folder.out / "under");
    write_under(folder.out, result, folder.body_file);
    write_poses(folder, result, files);
    if (folder.pictures) {
      write_pictures(folder.out / "pictures", result, files);
      write_text_file(folder.out / "fit.html", detail::fit_page(pattern.name, result));
    }
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
