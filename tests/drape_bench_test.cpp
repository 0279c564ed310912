// SPDX-License-Identifier: MIT
// The scenes of `bench drape`, the program itself at a tiny size, and scripts/performance.sh with
// one program as both the old and the new one.
#include <selvedge/bodies/body.h>
#include <selvedge/core/cloth/measure.h>
#include "drape_scenes.h"
#include "garments.h"
#include "run_program.h"

#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace selvedge::bench::drape_bench_test {
namespace {

namespace fs = std::filesystem;
using selvedge::testing::content;
using selvedge::testing::Json;
using selvedge::testing::Outcome;

double length(const TriangleMesh& mesh, std::int32_t a, std::int32_t b) {
  return (mesh.vertices[a] - mesh.vertices[b]).norm();
}

std::size_t particles(const Garment& garment) {
  std::size_t sum = 0;
  for (const GarmentPiece& piece : garment.pieces) sum += piece.surface.vertices.size();
  return sum;
}

TEST(Garments, HaveAboutTheParticlesOfASheetOfThatSize) {
  for (const std::string& name : garment_names()) {
    EXPECT_NEAR(particles(make_garment(name, 40)), 1600.0, 0.1 * 1600.0) << name;
    EXPECT_NEAR(particles(make_garment(name, 80)), 6400.0, 0.05 * 6400.0) << name;
  }
}

TEST(Garments, HaveNearlyEqualEdges) {
  for (const std::string& name : garment_names())
    for (const GarmentPiece& piece : make_garment(name, 40).pieces) {
      double shortest = 1e9, longest = 0.0;
      for (const Edge& edge : unique_edges(piece.surface.triangles)) {
        shortest = std::min(shortest, length(piece.surface, edge[0], edge[1]));
        longest = std::max(longest, length(piece.surface, edge[0], edge[1]));
      }
      EXPECT_LT(longest, 4.0 * shortest) << piece.name;
    }
}

TEST(Garments, TheSewnSkirtHasTheShapeOfItsFlatPattern) {
  const GarmentPiece skirt = make_garment("skirt", 60).pieces.at(0);
  ASSERT_EQ(skirt.surface.triangles.size(), skirt.pattern.triangles.size());
  for (std::size_t i = 0; i < skirt.surface.triangles.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const Triangle &s = skirt.surface.triangles[i], &p = skirt.pattern.triangles[i];
      const double flat = length(skirt.pattern, p[k], p[(k + 1) % 3]);
      EXPECT_NEAR(length(skirt.surface, s[k], s[(k + 1) % 3]) / flat, 1.0, 2e-3) << i;
    }
}

TEST(Garments, SeamsOfTheTorsoJoinParticlesThatFaceEachOther) {
  const Garment torso = make_garment("torso", 40);
  ASSERT_EQ(torso.seams.size(), 4u);
  for (const GarmentSeam& seam : torso.seams) {
    ASSERT_EQ(seam.a.size(), seam.b.size());
    ASSERT_GT(seam.a.size(), 3u);
    for (std::size_t k = 0; k < seam.a.size(); ++k) {
      const Vec3 across =
          torso.pieces[1].surface.vertices[seam.b[k]] - torso.pieces[0].surface.vertices[seam.a[k]];
      EXPECT_NEAR(std::hypot(across.x(), across.z()), 0.0, 1e-12);
    }
  }
}

TEST(Garments, OthersAreRefused) {
  EXPECT_THROW(make_garment("cape", 40), std::invalid_argument);
  EXPECT_THROW(make_garment("skirt", 4), std::invalid_argument);
}

TEST(DrapeScene, ASubdividedBodyIsTheSameSurface) {
  const TriangleMesh box = tessellate(Box{}, 3), fine = subdivided(subdivided(box));
  EXPECT_EQ(fine.triangles.size(), 16 * box.triangles.size());
  EXPECT_NEAR(surface_area(fine.vertices, fine.triangles), 6.0, 1e-12);
  // Euler's formula for a closed surface: no vertex was made twice.
  EXPECT_EQ(fine.vertices.size() + fine.triangles.size() - unique_edges(fine.triangles).size(), 2u);
}

/// A table in Markdown: the cells of the row of a scene, by column.
std::map<std::string, std::string> row_of(const std::string& text, const std::string& column,
                                          const std::string& scene) {
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out;
    std::istringstream in(line.substr(1));
    for (std::string cell; std::getline(in, cell, '|');) {
      const auto first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      out.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    return out;
  };
  std::istringstream in(text);
  std::vector<std::string> head;
  std::map<std::string, std::string> row;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("| scene")) head = cells(line);
    if (!line.starts_with("| " + scene + " |") ||
        std::find(head.begin(), head.end(), column) == head.end())
      continue;
    const std::vector<std::string> found = cells(line);
    for (std::size_t k = 0; k < head.size(); ++k) row[head[k]] = found.at(k);
  }
  return row;
}

class DrapeBench : public selvedge::testing::Program {
 protected:
  Outcome run(const std::string& arguments) const { return Program::run("drape " + arguments); }
};

TEST_F(DrapeBench, PrintsTimesSolverAndQualityOfBodiesAndGarments) {
  const Outcome done =
      run("--body ball,mannequin --garment poncho,skirt,torso --subdivide 1 --frames 1 12");
  ASSERT_EQ(done.code, 0) << done.out << done.err;
  for (const std::string scene : {"ball", "mannequin", "poncho", "skirt", "torso"}) {
    EXPECT_GT(std::stod(row_of(done.out, "wall s", scene)["wall s"]), 0.0);
    const auto solver = row_of(done.out, "solves per step", scene);
    EXPECT_GE(std::stod(solver.at("solves per step")), 1.0) << scene;
    EXPECT_NEAR(std::stod(solver.at("particles")), 144.0, 50.0) << scene;
    const auto quality = row_of(done.out, "clean", scene);
    EXPECT_EQ(quality.at("clean"), "yes") << scene;
    EXPECT_EQ(quality.at("self crossings"), "0") << scene;
    EXPECT_GT(std::stod(quality.at("kB per particle")), 0.0) << scene;
  }
}

TEST_F(DrapeBench, RunsASceneWithSeveralNumbersOfThreads) {
  const Outcome done = run("--frames 2 --json --threads 1,2 12");
  ASSERT_EQ(done.code, 0) << done.err;
  const Json results = Json::parse(done.out)["results"];
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0]["threads"], 1);
  EXPECT_EQ(results[0]["state_hash"], results[1]["state_hash"]);
  for (const Json& result : results) EXPECT_GT(result["triad_bytes_per_s"], 0.0);
  const auto row = row_of(run("--threads 1,1 --frames 2 12").out, "times faster", "ball");
  EXPECT_GT(std::stod(row.at("times faster")), 0.0);
}

TEST_F(DrapeBench, MeasuresTheMemory) {
  EXPECT_SAYS(run("--triad --threads 1").out, "The triad moves");
}

TEST_F(DrapeBench, PutsASheetTwoCentimetresAboveAMeshFile) {
  // The highest point along y is (0.3, 0.5, 0.1); with y up that is (0.3, -0.1, 0.5).
  write("body.obj",
        "v 0 0 0\nv 0.6 0 0\nv 0.3 0.5 0.1\nv 0.3 0 0.4\nf 1 3 2\nf 1 4 3\nf 2 3 4\nf 1 2 4\n");
  ASSERT_EQ(run("--body body.obj --up y --unit 2 --write-scenes --out scenes 9").code, 0);
  const Json scene = Json::parse(content(folder_ / "scenes/body_9/scene/scene.json"));
  const auto place = scene["geometry"][0]["transformation"]["translation"];
  EXPECT_NEAR(place[0], 0.6, 1e-12);
  EXPECT_NEAR(place[1], -0.2, 1e-12);
  EXPECT_NEAR(place[2], 1.02, 1e-12);
}

TEST_F(DrapeBench, RefusesBadInput) {
  for (const std::string arguments : {"--threads x 9", "--body no_such.ply 9", "--garment cape 9",
                                      "--garment skirt 4", "--body ball 1"}) {
    const Outcome refused = run(arguments);
    EXPECT_EQ(refused.code, 2) << arguments;
    EXPECT_EQ(refused.out, "") << arguments;
  }
}

class PerformanceScript : public DrapeBench {
 protected:
  /// Runs the script with finished builds.
  Outcome run_script(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.string() +
                                "' && SELVEDGE_OLD='" SELVEDGE_BUILD_DIR
                                "' SELVEDGE_NEW='" SELVEDGE_BUILD_DIR "' '" SELVEDGE_SOURCE_DIR
                                "/scripts/performance.sh' " +
                                arguments + " >stdout.txt 2>stderr.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(folder_ / "stdout.txt"),
            content(folder_ / "stderr.txt")};
  }
};

TEST_F(PerformanceScript, ComparesTwoProgramsOnTheSameScenes) {
  const Outcome done =
      run_script("--rows ball,skirt --sizes 12 --frames 2 --repeats 2 --threads 1");
  ASSERT_EQ(done.code, 0) << done.out << done.err;
  const auto times = row_of(done.out, "times faster", "ball");
  EXPECT_GT(std::stod(times.at("old s")), 0.0);
  EXPECT_GT(std::stod(times.at("times faster")), 0.0);
  const auto counts = row_of(done.out, "times the limit", "skirt");
  EXPECT_EQ(counts.at("solves per step"), "1.00 / 1.00");  // it hangs and touches nothing yet
  EXPECT_GT(std::stod(counts.at("by that of the sheet")), 0.0);
  EXPECT_EQ(row_of(done.out, "clean", "ball")["clean"], "yes / yes");
}

TEST_F(PerformanceScript, RefusesBadInputInOneSentence) {
  for (const std::string arguments :
       {"--rows hat", "--sizes 5,x", "--repeats 0", "--slow", "--rows"}) {
    const Outcome refused = run_script(arguments);
    EXPECT_EQ(refused.code, 2) << arguments;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_TRUE(refused.err.starts_with("performance.sh: ")) << refused.err;
  }
}

}  // namespace
}  // namespace selvedge::bench::drape_bench_test
