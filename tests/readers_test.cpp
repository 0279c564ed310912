// SPDX-License-Identifier: MIT
//
// What every reader has in common: it refuses what is no file with an end and what is damaged, in
// one sentence that names the file.
#include <selvedge/compare/compare_plan.h>
#include <selvedge/garment/sewing_pattern.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/pictures/result_pictures.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/run_folder.h>
#include <selvedge/run/internal/replay.h>
#include <selvedge/run/result_folder.h>
#include <selvedge/scene/fabric_file.h>
#include <sys/stat.h>

#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "garment_patterns.h"
#include "json_mutants.h"
#include "run_program.h"

namespace selvedge::testing::readers_test {
namespace {

class Readers : public Program {
 protected:
  /// Calls `read` with mutants of the JSON file, and expects what it throws to be a sentence about
  /// the file.
  void expect_sentences(const std::string& name, int mutants, const std::function<void()>& read) {
    const Json document = Json::parse(content(folder_ / name));
    std::mt19937_64 chance(41);
    int refused = 0;
    for (int k = 0; k < mutants; ++k) {
      const std::string text = type_mutant(document, chance).dump();
      write(name, text);
      try {
        read();
      } catch (const std::invalid_argument& fault) {
        const std::string what = fault.what();
        ++refused;
        EXPECT_EQ(what.find("json.exception"), std::string::npos) << what;
        EXPECT_SAYS(what, folder_.filename().string());
      } catch (const std::exception& other) {
        ADD_FAILURE() << "mutant " << k << " of seed 41: " << other.what() << "\n" << text;
      }
    }
    EXPECT_GT(refused, mutants / 10) << "the mutants of " << name << " are too tame";
    write(name, document.dump(2));
    read();
  }
};

TEST_F(Readers, NoCommandReadsWhatHasNoEnd) {
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_directories(folder_ / "sub");
  for (const std::string file : {"/dev/zero", "pipe", "sub"})
    for (const std::string arguments : {"run @ --out r",
                                        "plan @",
                                        "compare @ --vary dt=0.01",
                                        "advise @/x",
                                        "dress @ b.obj --out d",
                                        "dress p.json @ --out d",
                                        "info @",
                                        "sequence @ --out s",
                                        "check @ --against @",
                                        "ccd @ --kind edge_edge",
                                        "fabric @",
                                        "stability @",
                                        "detect --a0 @ --a1 @",
                                        "drape @ --geometric",
                                        "render @ --out o",
                                        "view @ --out v.html",
                                        "measure @",
                                        "replay @",
                                        "run mesh.json --out m",
                                        "run fabric.json --out f"}) {
      write("p.json", garment_patterns::kBodice);
      write("mesh.json", R"({"geometry": [{}], "obstacles": [{"mesh": ")" + file + "\"}]}");
      write("fabric.json",
            R"({"geometry": [{}], "materials": {"default": {"fabric": ")" + file + "\"}}}");
      std::string words = arguments;
      for (std::size_t at; (at = words.find('@')) != std::string::npos;) words.replace(at, 1, file);
      const Outcome outcome = run(words, "timeout 10");
      EXPECT_EQ(outcome.code, 2) << words << ": " << outcome.err;
      EXPECT_SAYS(outcome.err, "selvedge: ");
    }
}

TEST_F(Readers, APipeThatIsOpenAlreadyIsRead) {
  write("substituted.sh", "'" + program + "' plan <(cat small.json)\n");
  EXPECT_EQ(
      std::system(("cd '" + folder_.string() + "' && bash substituted.sh >out.txt 2>&1").c_str()),
      0)
      << content(folder_ / "out.txt");
  EXPECT_EQ(run("plan /dev/stdin", "cat small.json |").code, 0);
}

TEST_F(Readers, DamagedScenesFabricsAndPatternsGiveSentences) {
  expect_sentences("small.json", 150, [&] { read_scene(folder_ / "small.json"); });
  write("all.json", content(fs::path(SELVEDGE_SOURCE_DIR) / "data/scenes/round_table.json"));
  expect_sentences("all.json", 100, [&] { read_scene(folder_ / "all.json"); });
  for (const std::string set : {"matsudaira_2015", "usual_kes", "wang_2011"}) {
    write("f.json", content(fs::path(SELVEDGE_SOURCE_DIR) / ("data/fabrics/" + set + ".json")));
    expect_sentences("f.json", 150, [&] { read_fabrics(folder_ / "f.json"); });
  }
  write("p.json", garment_patterns::kBodice);
  expect_sentences("p.json", 400, [&] { read_sewing_pattern(folder_ / "p.json"); });
}

TEST_F(Readers, DamagedFilesOfAResultGiveSentences) {
  ASSERT_EQ(run_small("r", "--max-steps 3").code, 1);
  const fs::path out = folder_ / "r";
  const Scene scene = read_scene(folder_ / "small.json");
  expect_sentences("r/checkpoint.json", 400, [&] { detail::read_checkpoint(out); });
  expect_sentences("r/failure/failure.json", 400, [&] { read_failure_bundle(out / "failure"); });
  expect_sentences("r/result.json", 400, [&] {
    try {
      result_from_text(content(out / "result.json"));
    } catch (const std::invalid_argument& fault) {  // a text has no file
      throw std::invalid_argument((out / "result.json").string() + ": " + fault.what());
    }
  });
  expect_sentences("r/scene.json", 200, [&] {
    detail::check_folder(scene, out);
    read_scene(out / "scene.json");
  });
}

TEST_F(Readers, ReadersThatNeedNotKnowAFileIgnoreItsDamage) {
  ASSERT_EQ(run_small("r").code, 0);
  const Json document = Json::parse(content(folder_ / "r/scene.json"));
  std::mt19937_64 chance(42);
  for (int k = 0; k < 40; ++k) {
    write("r/scene.json", type_mutant(document, chance).dump());
    try {
      read_view(folder_ / "r", {.shortfall = false});
      ResultPictures pictures(folder_ / "r");
    } catch (const std::invalid_argument& fault) {
      EXPECT_EQ(std::string(fault.what()).find("json.exception"), std::string::npos)
          << fault.what();
    }
  }
}

TEST_F(Readers, DamagedPlansOfACompareGiveSentences) {
  ASSERT_EQ(run("compare small.json --vary dt=0.01 --set time.frames=1 --no-reference --repeats 1 "
                "--no-pictures --out c")
                .code,
            0);
  expect_sentences("c/plan.json", 400, [&] { read_plan(folder_ / "c"); });
}

TEST_F(Readers, ADamagedFileOfAResultEndsTheProgramWithOneSentence) {
  ASSERT_EQ(run_small("r").code, 0);
  for (const std::string name : {"r/checkpoint.json", "r/scene.json"}) {
    Json document = Json::parse(content(folder_ / name));
    document[name == "r/scene.json" ? "name" : "frame"] = Json::array({1});
    const std::string whole = content(folder_ / name);
    write(name, document.dump());
    EXPECT_REFUSED(run_small("r", "--resume"), name);
    write(name, "{");
    EXPECT_EQ(run_small("r", "--resume").code, 2);
    write(name, whole);
  }
}

TEST_F(Readers, ASourceThatIsAListIsRefusedWithTheFile) {
  write("f.json",
        R"({"source": [], "fabrics": {"a": {"density": {"value": 1, "unit": "kg/m2"}}}})");
  EXPECT_REFUSED(run("fabric f.json"), "f.json: \"source\" must be a text in quotes");
  write("f.json", R"({"source": "x", "fabrics": ["a"]})");
  EXPECT_REFUSED(run("fabric f.json"), "f.json, fabrics: must be an object");
}

}  // namespace
}  // namespace selvedge::testing::readers_test
