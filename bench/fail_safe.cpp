// SPDX-License-Identifier: MIT
// Every fail-safe on scenes that need one: steps, halvings, rounds, time, the speed left, and
// whether what slides goes on sliding. Prints one table in Markdown.
#include <selvedge/apps/judge.h>
#include <selvedge/core/parallel.h>
#include <selvedge/scene/simulation.h>

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace {

using namespace selvedge;
namespace fs = std::filesystem;

struct Case {
  std::string name;
  Scene scene;
  int frames = 0;
  double slide = 0.0;  // m/s along x that Coulomb leaves at the end; 0: not asked
};

struct Options {
  std::vector<std::string> only, fail_safes;
  bool judged = true;
  double seconds = 60.0;  // for one run
};

constexpr double kFallSpeed = 10.0, kSlideSpeed = 5.0, kFriction = 0.3, kGravity = 9.81;

Scene stack(int sheets, int cells, double slide) {
  Scene scene;
  scene.materials["default"] = Material{};
  scene.materials["default"].friction = kFriction;
  for (int k = 0; k < sheets; ++k) {
    ClothSpec sheet;
    sheet.name = "sheet" + std::to_string(k);
    sheet.shape = ClothGrid{ClothPattern::rectangular, {0.2, 0.2, cells, cells}, {}};
    sheet.placement.translation = Vec3(0.003 * k, 0.002 * k, 0.01 + 0.003 * k);
    sheet.placement.rotation = Eigen::AngleAxisd(0.2 * k, Vec3::UnitZ());
    sheet.velocity = Vec3(slide, 0.0, -kFallSpeed);
    scene.cloths.push_back(sheet);
  }
  BodySpec floor;
  floor.name = "floor";
  floor.shape = BodyShape{Box{Vec3(10, 10, 0.005)}, 16};
  floor.friction = kFriction;
  scene.bodies.push_back(floor);
  return scene;
}

// What Coulomb leaves of the sideways speed once the fall has been stopped by the floor, a frame
// before `frames`: the impulse that stops the fall takes mu times itself, and so does weight.
double coulomb_slide(int frames, double fps) {
  return kSlideSpeed - kFriction * (kFallSpeed + kGravity * frames / fps);
}

Case from_file(const char* file, int frames) {
  const fs::path path = fs::path(SELVEDGE_SOURCE_DIR) / "data" / file;
  return {path.stem().string(), read_scene(path), frames, 0.0};
}

std::vector<Case> cases() {
  std::vector<Case> list;
  list.push_back({"stack of 12 at 10 m/s", stack(12, 4, 0.0), 20, 0.0});
  list.push_back({"the same, 16 x 16 cells", stack(12, 16, 0.0), 20, 0.0});
  list.push_back({"one sheet, 5 m/s sideways", stack(1, 12, kSlideSpeed), 6, coulomb_slide(6, 60)});
  list.push_back({"8 sheets, 5 m/s sideways", stack(8, 6, kSlideSpeed), 6, coulomb_slide(6, 60)});
  list.push_back(from_file("extreme/s10_fast_sphere.json", 40));
  list.push_back(from_file("extreme/s07_twist.json", 240));
  list.push_back(from_file("extreme/s06_ring_5cm.json", 90));
  list.push_back(from_file("extreme/pinch.json", 120));
  list.push_back(from_file("extreme/pinch_and_go.json", 120));
  return list;
}

struct Row {
  RunResult result;
  std::string stopped;
  double wall = 0.0, sliding = 0.0;
  std::size_t wrong = 0;  // crossings and collisions that the judge found
};

TriangleMesh mesh(std::span<const Vec3> x, std::span<const Triangle> triangles) {
  return {{x.begin(), x.end()}, {triangles.begin(), triangles.end()}};
}

double mean_x(const std::vector<Vec3>& v) {
  double sum = 0.0;
  for (const Vec3& u : v) sum += u.x();
  return sum / static_cast<double>(v.size());
}

class Judged {
 public:
  explicit Judged(const Simulation& simulation) : simulation_(simulation) { now(last_, body_); }
  std::size_t wrong() {
    TriangleMesh cloth, body;
    now(cloth, body);
    const PathVerdict path = judge_path(last_, cloth.vertices, body_, body.vertices);
    std::swap(last_, cloth);
    std::swap(body_, body);
    return path.self_collisions + path.body_collisions;
  }

 private:
  void now(TriangleMesh& cloth, TriangleMesh& body) const {
    cloth = mesh(simulation_.state().x, simulation_.cloth_triangles());
    body = mesh(simulation_.body_positions(), simulation_.body_triangles());
  }
  const Simulation& simulation_;
  TriangleMesh last_, body_;
};

Row run(Scene scene, int frames, const std::string& fail_safe, const Options& options) {
  scene.contact.fail_safe = fail_safe;
  Simulation simulation(scene, build_scene(scene));
  Judged judged(simulation);
  Row row;
  double aside = 0.0;  // s, for the judge
  const auto clock = [] { return std::chrono::steady_clock::now(); };
  const auto since = [&](auto t) { return std::chrono::duration<double>(clock() - t).count(); };
  const auto start = clock();
  try {
    for (int frame = 1; frame <= frames; ++frame) {
      simulation.advance_to_frame(frame, [&](double) {
        if (!options.judged) return;
        const auto t = clock();
        row.wrong += judged.wrong();
        aside += since(t);
      });
      if (since(start) - aside > options.seconds) {
        row.stopped = fmt::format("time, frame {} of {}", frame, frames);
        break;
      }
    }
  } catch (const SimulationFailed& failed) {
    row.stopped = failed.what();
  }
  row.wall = since(start) - aside;
  row.result = simulation.result();
  row.sliding = mean_x(simulation.state().v);
  return row;
}

void print(const Case& c, const std::string& name, Row& row) {
  const auto count = [&](const char* key) {
    const auto at = row.result.counters.find(key);
    return at == row.result.counters.end() ? 0.0 : at->second;
  };
  const auto phase = [&](const char* key) {
    const auto at = row.result.phase_s.find(key);
    return at == row.result.phase_s.end() ? 0.0 : at->second;
  };
  const double rounds = count("impulse_passes") + count("projection_rounds") +
                        count("zone_rounds") + count("plane_rounds") + count("bound_rounds");
  fmt::print("| {} | {} | {} | {} | {:.0f} | {:.0f} | {:.2f} | {:.2f} | {:.2f} | {} | {} |\n",
             c.name, name, row.result.steps, row.result.halvings, count("fail_safe_steps"), rounds,
             row.wall, phase("response"), row.result.final_max_speed,
             c.slide > 0.0 ? fmt::format("{:.2f} of {:.2f}", row.sliding, c.slide) : "",
             row.wrong             ? fmt::format("**{} wrong**", row.wrong)
             : row.stopped.empty() ? "clean"
                                   : row.stopped);
  std::fflush(stdout);
}

Options parse(int argc, char** argv, const std::vector<Case>& all) {
  Options options;
  CLI::App app("Every fail-safe on scenes that need one");
  app.add_option("--case", options.only, "Only cases whose name contains this");
  app.add_option("--fail-safe", options.fail_safes, "Only these");
  app.add_option("--seconds", options.seconds, "Most seconds of one run");
  app.add_flag("!--unjudged", options.judged, "Leave out the independent judge");
  app.footer([&] {
    std::string text = "Cases:";
    for (const Case& c : all) text += "\n  " + c.name;
    return text;
  });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error) == 0 ? 0 : 2);
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<Case> all = cases();
  Options options = parse(argc, argv, all);
  if (options.fail_safes.empty())
    for (const auto& [name, make] : fail_safes()) options.fail_safes.push_back(name);
  fmt::print(
      "| scene | fail-safe | steps | halvings | steps in need | rounds | s | s in response | "
      "fastest "
      "at the end, m/s | sliding, m/s | verdict "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Case& c : all) {
    if (!options.only.empty() &&
        std::none_of(options.only.begin(), options.only.end(),
                     [&](const auto& o) { return c.name.find(o) != std::string::npos; }))
      continue;
    for (const std::string& name : options.fail_safes) {
      Row row = run(c.scene, c.frames, name, options);
      print(c, name, row);
    }
  }
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "bench_fail_safe: {}\n", error.what());
  return 1;
}
