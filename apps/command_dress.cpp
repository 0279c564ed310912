// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/commands.h>
#include <selvedge/apps/detail/output_file.h>
#include <selvedge/apps/detail/person_body.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/bodies/internal/sequence_leap.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/dress/dress_result.h>
#include <selvedge/dress/internal/arrange.h>
#include <selvedge/dress/internal/dress_batch.h>
#include <selvedge/garment/internal/pattern_svg.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/scene/fabric_file.h>
#include <selvedge/scene/methods.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "version.h"

namespace {

using namespace selvedge;

struct DressOptions {
  std::string pattern, body, out, fabric, sheet, list, only, workflow, over;
  std::string up;
  double resolution = 0.01;
  std::optional<double> unit;
  std::optional<double> strain_limit, friction, budget;
  double over_friction = WornGarment{}.outer_friction;
  std::vector<std::string> poses, pose_formats;
  double pose_rate = BodyMotion{}.rate, pose_lead = BodyMotion{}.lead;
  int threads = 0;
  bool fit_origin = false, arrange = false, every_step = false, json = false, pictures = true,
       views = false;
};

/// GarmentCode has y up, and so have most bodies that state nothing.
UpAxis pattern_up(const DressOptions& o) {
  return o.up == "x" ? UpAxis::x : o.up == "z" ? UpAxis::z : UpAxis::y;
}

LoadConfig body_file_of(const DressOptions& o, const std::filesystem::path& file) {
  LoadConfig config;
  config.unit = o.unit;
  if (!o.up.empty() || !states_axes(file)) config.up = pattern_up(o);
  return config;
}

BodyMesh read_body(const DressOptions& o, const std::string& file) {
  return read_person(file, body_file_of(o, file));
}

DressConfig dress_config(const DressOptions& o) {
  DressConfig config;
  if (!o.fabric.empty())
    config.fabric = find_fabric(o.fabric, std::filesystem::current_path()).material;
  config.fabric_name = o.fabric;
  if (o.strain_limit) config.fabric.strain_limit = *o.strain_limit;
  // What the data of a fabric say holds.
  if (!o.fabric.empty() || o.strain_limit) config.wearable_stretch = config.fabric.strain_limit;
  config.fit_origin = o.fit_origin;
  if (o.friction) config.body_friction = *o.friction;
  config.edge_length = o.resolution;
  if (o.budget) config.budget = *o.budget;
  return config;
}

double total_seconds(const DressResult& r) {
  double sum = 0.0;
  for (const char* phase : {"start", "sew", "close", "draw", "settle", "skin", "refine", "move"})
    if (const auto found = r.seconds.find(phase); found != r.seconds.end()) sum += found->second;
  return sum;
}

void print_under(const DressResult& r) {
  for (const UnderReport& under : r.under)
    print_escaped("below        {}: max stretch {:.1f} %, limit {:.1f} %, lowered by {:.0f} mm\n",
                  under.garment.name, 100.0 * under.max_stretch,
                  100.0 * under.garment.fabric.strain_limit, 1e3 * under.drop);
}

void print_motion(const DressResult& r) {
  if (r.poses.empty()) return;
  double stretch = 0.0;
  for (const PoseReport& pose : r.poses) stretch = std::max(stretch, pose.max_stretch);
  print_escaped(
      "poses        {} reached in {:.2f} s, max stretch at a pose {:.1f} %, lowered by {:.0f} mm\n",
      r.poses.size(), r.poses.back().time, 100.0 * stretch, 1e3 * r.poses.back().drop);
  if (r.jams > 0)
    print_escaped("jams         {}: the body left cloth no room and passed through it\n", r.jams);
}

constexpr std::size_t kMostPlaces = 3;  // of skin that are printed

/// Where the skin stays back.
void print_skin(const DressResult& r) {
  if (r.body_moved == 0) return;
  std::string places;
  for (std::size_t k = 0; k < std::min(kMostPlaces, r.skin.size()); ++k)
    places += fmt::format("{}({:.2f}, {:.2f}, {:.2f}) by {:.1f} mm", k == 0 ? "" : ", ",
                          r.skin[k].at.x(), r.skin[k].at.y(), r.skin[k].at.z(), 1e3 * r.skin[k].by);
  print_escaped(
      "body         the skin of body.obj stays back for the cloth between two parts in {}: {} m "
      "(z up){}\n",
      counted(r.skin.size(), "place"), places, r.skin.size() > kMostPlaces ? " ..." : "");
}

/// Girths of the zones where cloth is.
void print_fit(const DressResult& r) {
  std::string zones;
  for (const FitZone& zone : r.fit)
    if (zone.is_closed)
      zones += fmt::format("{}{} {:.1f} on {:.1f}", zones.empty() ? "" : ", ", zone.name,
                           100.0 * zone.cloth, 100.0 * zone.body);
  if (!zones.empty()) print_escaped("fit          {} cm around (fit.html)\n", zones);
}

void print_elastics(const DressResult& r) {
  for (const ElasticReport& elastic : r.elastics)
    print_escaped("elastic      {}: {:.1f} cm of cloth on {:.1f} cm, {:.1f} cm as worn\n",
                  elastic.name, 100.0 * elastic.length, 100.0 * elastic.rest, 100.0 * elastic.worn);
}

void print_summary(const std::string& name, const DressResult& r, const std::string& out) {
  print_escaped("{}: {}, {}, {:.1f} s; results in {}\n", name,
                counted(r.panel_names.size(), "panel"),
                counted(r.garment.vertices.size(), "vertex", "vertices"), total_seconds(r), out);
  for (const std::string& note : r.notes) print_escaped("note         {}\n", note);
  for (const MovedPanel& moved : r.moved)
    print_escaped("moved        panel {} by {:.0f} mm before the start, to be free\n",
                  r.panel_names[static_cast<std::size_t>(moved.panel)], 1e3 * moved.by.norm());
  if (!r.origin_moved.isZero(0.0))
    print_escaped(
        "origin       the pattern moved as a whole by {:.3f} m, {:.3f} m, {:.3f} m (z up)\n",
        r.origin_moved.x(), r.origin_moved.y(), r.origin_moved.z());
  print_skin(r);
  print_escaped("clean        {}, {} judged\n",
                r.clean ? "yes: nothing passed through anything" : "NO: something passed through",
                counted(static_cast<std::size_t>(r.states), "state"));
  const std::size_t open = r.open_pairs();
  print_escaped("seams        {} merged, largest opening {:.2f} mm\n",
                open == 0 ? "all" : "all but " + counted(open, "pair"), 1e3 * r.largest_opening);
  print_escaped("at rest      {}: root mean square speed {:.1f} mm/s, at most {:.0f} mm/s\n",
                r.at_rest ? "yes" : "NO", 1e3 * r.rms_speed, 1e3 * r.max_speed);
  print_escaped("max stretch  {:.1f} %, wearable {:.1f} %; folded over {:.1f} % of the area\n",
                100.0 * r.max_stretch, 100.0 * r.wearable_stretch, 100.0 * r.folded);
  print_fit(r);
  print_elastics(r);
  print_under(r);
  print_motion(r);
  print_escaped("seconds     ");
  for (const auto& [phase, seconds] : r.seconds)
    if (phase.find('/') == std::string::npos) print_escaped(" {} {:.1f}", phase, seconds);
  print_escaped("\n");
  print_escaped("verdict      {}\n", r.verdict());
}

void write_sheet(const std::string& file, const SewingPattern& pattern) {
  refuse_other_kind(file, kSvgPicture, "--sheet");
  AtomicFile out(file);
  out.write(pattern_svg(pattern));
  out.commit();
}

DressFolderConfig folder_config(const DressOptions& o) {
  DressFolderConfig folder;
  folder.every_step = o.every_step;
  folder.pictures = o.pictures;
  folder.body_file = {.unit = o.unit, .up = pattern_up(o)};
  folder.body_name = o.body;
  folder.pose_formats = o.pose_formats;
  return folder;
}

/// Reads the poses, and names their files in the result.
void read_poses(const DressOptions& o, BodyMotion& motion, DressFolderConfig& folder) {
  motion.rate = o.pose_rate;
  motion.lead = o.pose_lead;
  for (const std::string& file : o.poses) {
    motion.poses.push_back(read_body(o, file).mesh);
    const std::string name = std::filesystem::path(file).stem().string();
    if (std::find(folder.pose_names.begin(), folder.pose_names.end(), name) !=
        folder.pose_names.end())
      throw std::invalid_argument(fmt::format(
          "--pose: two files are called {}; rename one of them, because the garments at the poses "
          "are named after the files",
          name));
    folder.pose_names.push_back(name);
  }
}

/// Warns of a pose whose vertices are numbered in another way than those of the one before.
void warn_of_leaps(const DressOptions& o, const TriangleMesh& body, const BodyMotion& motion) {
  const std::vector<Edge> edges = unique_edges(body.triangles);
  const std::vector<Vec3>* before = &body.vertices;
  for (std::size_t k = 0; k < motion.poses.size(); ++k) {
    const std::vector<Vec3>& now = motion.poses[k].vertices;
    if (now.size() != body.vertices.size()) return;  // `dress` refuses it
    if (const std::string leap = vertex_leap(*before, now, edges); !leap.empty())
      print_escaped(stderr, "warning: {}: on the way to this pose {}\n", o.poses[k], leap);
    before = &now;
  }
}

void read_over(const DressOptions& o, const DressFolderConfig& folder, DressConfig& config) {
  std::error_code ignored;
  if (std::filesystem::equivalent(o.over, folder.out, ignored))
    throw std::invalid_argument(o.over +
                                ": is the folder of --out, too; give the new garment another one");
  config.under = read_worn(o.over, folder.body_file, o.over_friction);
}

void write_view(const std::filesystem::path& folder) {
  const ResultView views[] = {
      read_view(folder, {.methods = methods_of_this_build(), .shortfall = false})};
  AtomicFile page(folder / "view.html");
  page.write(view_page(views));
  page.commit();
}

/// In the axes of its file, like a pattern that has its places.
SewingPattern read_pattern(const DressOptions& o, const std::string& file,
                           const TriangleMesh& body) {
  if (!o.arrange) return read_sewing_pattern(file);
  std::vector<std::string> notes;
  const SewingPattern pattern = open_pattern(file, {}, notes);
  const Arrangement arrangement = arrange(pattern, body, find_landmarks(body));
  for (const std::string& note : notes)
    if (!o.json) print_escaped("file         {}\n", note);
  if (!o.json) print_escaped("{}", arrangement_table(arrangement));
  return turned_back(arrangement.pattern, pattern_up(o));
}

int dress_one(const DressOptions& o) {
  if (o.pattern.empty() || o.body.empty())
    throw std::invalid_argument("dress needs PATTERN and BODY, or --list with several patterns");
  const BodyMesh body = read_body(o, o.body);
  const SewingPattern pattern = read_pattern(o, o.pattern, body.mesh);
  if (!o.sheet.empty()) write_sheet(o.sheet, pattern);
  DressFolderConfig folder = folder_config(o);
  folder.body_file = {.unit = body.axes.unit, .up = body.axes.up};
  folder.out =
      o.out.empty() ? std::filesystem::path("out") / pattern.name : std::filesystem::path(o.out);
  DressConfig config = dress_config(o);
  read_poses(o, config.motion, folder);
  warn_of_leaps(o, body.mesh, config.motion);
  if (!o.over.empty()) read_over(o, folder, config);
  const DressResult result = dress_into_folder(turned_upright(pattern, pattern_up(o)), body.mesh,
                                               config, folder, methods_of_this_build());
  if (o.views) write_view(folder.out);
  if (o.json)
    print_escaped("{}", dress_result_text(pattern.name, result, o.body));
  else
    print_summary(pattern.name, result, folder.out.string());
  return result.worn() ? 0 : 1;
}

std::string motion_text(const DressOptions& o) {
  if (o.poses.empty()) return "no poses";
  std::string text = fmt::format("poses at {}, lead {}", o.pose_rate, o.pose_lead);
  for (const std::string& format : o.pose_formats) text += " " + format;
  for (const std::string& file : o.poses)
    text += fmt::format(" {} {}", std::filesystem::path(file).stem().string(), file_hash(file));
  return text;
}

/// The settings on which a result depends, and the program.
std::string settings_text(const DressOptions& o, const DressConfig& config) {
  const Material& f = config.fabric;
  return fmt::format(
      "resolution {}\nup {}\nunit {}\npictures {}\nsteps {}\nfabric {} {} {} {} {}\nfriction "
      "{}\nbudget {}\nfit origin {}\n{}\n{}",
      o.resolution, o.up.empty() ? "file" : o.up, o.unit ? fmt::format("{}", *o.unit) : "file",
      o.pictures, o.every_step, o.fabric, f.density, f.stretch_stiffness, f.strain_limit,
      f.friction, config.body_friction, config.budget, o.fit_origin, motion_text(o),
      version_text());
}

void print_dressed(const DressBatchRow& row) {
  print_escaped("{:<32} {:>7.1f} s  {}{}\n", row.job.name, row.seconds, row.verdict,
                row.kept ? " (kept)" : "");
  std::fflush(stdout);
}

std::string absolute(const std::string& path) {
  return std::filesystem::absolute(path).lexically_normal().string();
}

/// The arguments of `dress` with which a workflow puts on the garments of the list.
std::vector<std::string> arguments_of(const DressOptions& o) {
  std::vector<std::string> words = {"--list", absolute(o.list), "--out", "."};
  const auto add = [&](const char* option, const std::string& value) {
    words.insert(words.end(), {option, value});
  };
  const auto number = [](double value) { return fmt::format("{}", value); };
  if (!o.up.empty()) add("--up", o.up);
  if (o.unit) add("--unit", number(*o.unit));
  add("--resolution", number(o.resolution));
  if (o.budget) add("--budget", number(*o.budget));
  if (o.strain_limit) add("--strain-limit", number(*o.strain_limit));
  if (o.friction) add("--friction", number(*o.friction));
  if (o.fit_origin) words.emplace_back("--fit-origin");
  if (!o.fabric.empty()) {
    const auto hash = o.fabric.find('#');  // FILE.json#NAME
    add("--fabric", hash == std::string::npos
                        ? o.fabric
                        : absolute(o.fabric.substr(0, hash)) + o.fabric.substr(hash));
  }
  if (!o.poses.empty()) {
    words.emplace_back("--pose");
    for (const std::string& pose : o.poses) words.push_back(absolute(pose));
    if (!o.pose_formats.empty()) words.emplace_back("--pose-format");
    words.insert(words.end(), o.pose_formats.begin(), o.pose_formats.end());
    add("--pose-rate", number(o.pose_rate));
    add("--pose-lead", number(o.pose_lead));
  }
  if (o.every_step) words.emplace_back("--every-step");
  if (!o.pictures) words.emplace_back("--no-pictures");
  if (o.views) words.emplace_back("--views");
  if (!o.pattern.empty()) words.insert(words.begin(), absolute(o.pattern));  // the body
  return words;
}

int make_workflow(const DressOptions& o, const std::vector<DressJob>& jobs) {
  const FolderLock lock(o.workflow, "dress --workflow");
  write_dress_workflow(o.workflow, jobs, arguments_of(o), o.threads);
  print_escaped("{}/Snakefile: {}; run them with: cd {} && snakemake --cores 2\n", o.workflow,
                counted(jobs.size() + 1, "job"), shell_quoted(o.workflow));
  return 0;
}

void check_list_options(const DressOptions& o) {
  if (!o.body.empty())
    throw std::invalid_argument("with --list, give only BODY; the list names the patterns");
  if (o.json || !o.sheet.empty() || !o.over.empty() || o.arrange)
    throw std::invalid_argument(
        "--json, --sheet, --arrange and --over are for one garment, without --list");
  if (!o.workflow.empty() && (!o.out.empty() || !o.only.empty()))
    throw std::invalid_argument(
        "--workflow names the folder of the results and runs nothing; leave out --out and --only");
}

int dress_list(const DressOptions& o) {
  check_list_options(o);
  DressBatchConfig batch;
  batch.out =
      o.out.empty() ? std::filesystem::path("out") / "dressed" : std::filesystem::path(o.out);
  batch.dress = dress_config(o);
  batch.folder = folder_config(o);
  read_poses(o, batch.dress.motion, batch.folder);
  batch.settings = settings_text(o, batch.dress);
  if (o.views) batch.write_view = write_view;
  batch.read_body = [&](const std::filesystem::path& file) { return read_body(o, file.string()); };
  const std::vector<DressJob> jobs = read_dress_list(o.list, o.pattern);
  if (!o.workflow.empty()) return make_workflow(o, jobs);
  if (!o.only.empty()) {
    const DressBatchRow row = dress_one_of(jobs, o.only, batch, methods_of_this_build());
    print_dressed(row);
    return row.worn ? 0 : 1;
  }
  const std::vector<DressBatchRow> rows =
      dress_batch(jobs, batch, methods_of_this_build(), print_dressed);
  const auto count = [&](bool DressBatchRow::*is) {
    return std::count_if(rows.begin(), rows.end(),
                         [&](const DressBatchRow& row) { return row.*is; });
  };
  const auto worn = count(&DressBatchRow::worn);
  print_escaped("good: {} of {}, worn: {}; page {}\n", count(&DressBatchRow::good),
                counted(rows.size(), "garment"), worn, (batch.out / "index.html").string());
  return worn == static_cast<std::ptrdiff_t>(rows.size()) ? 0 : 1;
}

int dress_command(const DressOptions& o) {
  if (!o.list.empty()) return dress_list(o);
  if (!o.only.empty() || !o.workflow.empty())
    throw std::invalid_argument("--only and --workflow are for several garments, with --list");
  return dress_one(o);
}

void add_dress_options(const Command& command) {
  const auto options = std::make_shared<DressOptions>();
  command.option("pattern", options->pattern,
                 "Sewing pattern (JSON of GarmentCode); with --list, the body instead");
  command.option("body", options->body, "Mesh of the body");
  command.option("--list", options->list,
                 "Many garments: a folder with patterns, or a file with PATTERN or PATTERN,BODY in "
                 "each line; finished garments are kept");
  command.option("--only", options->only,
                 "Of --list, put on the garment of this name alone, without the page");
  command.option(
      "--workflow", options->workflow,
      "Write a Snakemake workflow of --list, one job for each garment, into this folder; "
      "runs nothing");
  command.option("--out", options->out,
                 "Result folder (default: out/NAME of the pattern, or out/dressed)");
  command.option("--budget", options->budget, "Longest time for one garment, s").positive();
  command.option(
      "--pose", options->poses,
      "Poses of the body, in order: meshes with the same triangles; the garment follows");
  command.option("--pose-format", options->pose_formats,
                 "Formats of the motion through the poses beside PLY, such as gltf, usd or pc2");
  command.option("--over", options->over,
                 "Put the garment over the one in RESULT, a folder that was made with this body");
  command
      .option("--over-friction", options->over_friction,
              "Friction between the garment and the one below")
      .range(0.0, 10.0)
      .show_default();
  command.option("--pose-rate", options->pose_rate, "Poses per second").positive().show_default();
  command
      .option("--pose-lead", options->pose_lead,
              "Time from the body to the first pose, s; unused if they are the same")
      .positive()
      .show_default();
  command.option("--sheet", options->sheet,
                 "Also draw the flat panels, with the numbers of edges and stitches (SVG)");
  command.option("--fabric", options->fabric, "A measured fabric by name, or FILE.json#NAME");
  command.option("--resolution", options->resolution, "Edge length of the mesh, m")
      .range(0.001, 0.2)
      .show_default();
  command.option("--strain-limit", options->strain_limit, "Largest stretch that the fabric allows")
      .range(0.001, 10.0);
  command.flag("--arrange", options->arrange,
               "Place the panels around the body by their names and seams, as `arrange` does");
  command.flag("--fit-origin", options->fit_origin,
               "Move a pattern that is drawn for a body with another origin to its place");
  command.option("--friction", options->friction, "Friction between fabric and body")
      .range(0.0, 10.0);
  command
      .option("--up", options->up,
              "Axis of body and pattern that points up (default: y; of a body in glTF, Collada or "
              "FBX what its file states)")
      .one_of({"x", "y", "z"});
  command
      .option("--unit", options->unit,
              "Metres per unit of the body's file (default: what it states, else 1)")
      .positive();
  command.flag("--every-step", options->every_step, "Also write every accepted state to steps/");
  command.flag("--views", options->views,
               "Also write view.html, which shows in a browser how the garment was put on");
  command.flag("--json", options->json, "Print the result as JSON");
  command.footer(
      "Exit code 0: the garment is worn, though perhaps with a reservation. 1: it is not; "
      "result.json says "
      "why.");
  command.action([options, command] {
    options->threads = command.threads().value_or(0);
    options->pictures = command.pictures();
    return dress_command(*options);
  });
}

}  // namespace

selvedge::ProgramCommand dress_command() {
  return {.name = "dress",
          .purpose = "Put a garment from a sewing pattern on a body",
          .add_options = add_dress_options};
}
