// SPDX-License-Identifier: MIT
// The page of `selvedge view`: what it holds, and what a browser makes of it.
#include <gtest/gtest.h>
#include <selvedge/bodies/mesh_file.h>
#include <selvedge/core/base/internal/html.h>
#include <selvedge/pictures/internal/result_view.h>
#include <selvedge/scene/scene.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "run_program.h"

namespace selvedge::view_test {
namespace {

using namespace selvedge::testing;

// -- the text of pages ----------------------------------------------------------------------------

std::string base64_of(const std::string& text) { return base64(std::as_bytes(std::span(text))); }

TEST(Html, Base64IsThatOfTheStandard) {  // RFC 4648, section 10
  for (const auto& [text, expected] : std::map<std::string, std::string>{{"", ""},
                                                                         {"f", "Zg=="},
                                                                         {"fo", "Zm8="},
                                                                         {"foo", "Zm9v"},
                                                                         {"foob", "Zm9vYg=="},
                                                                         {"fooba", "Zm9vYmE="},
                                                                         {"foobar", "Zm9vYmFy"}})
    EXPECT_EQ(base64_of(text), expected);
}

TEST(Html, NothingInANameIsTakenForHtmlOrForAMark) {
  EXPECT_EQ(html_escaped("<b title='x'>&\"</b>"),
            "&lt;b title=&#39;x&#39;&gt;&amp;&quot;&lt;/b&gt;");
  EXPECT_EQ(safe_in_script("\"</script>\""), "\"\\u003c/script>\"");
  const PagePart parts[] = {{"%A%", "%B%"}, {"%B%", "b"}};
  EXPECT_EQ(filled_page("1%A%2%B%3%A%", parts), "1%B%2b3%B%");
}

// -- what a page holds ----------------------------------------------------------------------------

/// The JSON of a page.
Json data_of(const std::string& page) {
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const auto begin = page.find(open) + open.size();
  return Json::parse(page.substr(begin, page.find("</script>", begin) - begin), nullptr, false);
}

std::string decoded(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  std::uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 255u);
  }
  return bytes;
}

std::vector<Vec3> positions_of(const Json& surface) {
  const std::string bytes = decoded(surface["x"].get<std::string>());
  std::vector<std::uint16_t> levels(bytes.size() / 2);
  std::memcpy(levels.data(), bytes.data(), bytes.size());
  std::vector<Vec3> x(levels.size() / 3);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const int axis = static_cast<int>(i % 3);
    x[i / 3][axis] = surface["low"][axis].get<double>() +
                     surface["extent"][axis].get<double>() * levels[i] / 65535.0;
  }
  return x;
}

/// A waving square sheet of n x n vertices, with two values of each vertex.
ResultView waving(int n, int frames) {
  ResultView view;
  view.name = "waving";
  auto& triangles = view.triangles.emplace_back();
  for (std::int32_t j = 0; j + 1 < n; ++j)
    for (std::int32_t i = 0; i + 1 < n; ++i) {
      const std::int32_t v = j * n + i;
      triangles.push_back({v, v + 1, v + n + 1});
      triangles.push_back({v, v + n + 1, v + n});
    }
  ViewField field{.name = "strain", .meaning = "", .unit = "%", .full = 1.0};
  for (int f = 0; f < frames; ++f) {
    ViewFrame& frame = view.frames.emplace_back();
    frame.number = f;
    frame.time = f / 30.0;
    frame.cloth.triangles = 0;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        frame.cloth.x.emplace_back(i / (n - 1.0), j / (n - 1.0), 0.1 * std::sin(0.1 * f + 0.2 * i));
    field.frames.emplace_back(frame.cloth.x.size(), static_cast<std::uint8_t>(f));
  }
  view.fields = {field, field};
  view.fields[1].name = "pressure";
  return view;
}

TEST(ViewPage, PositionsAreWithinTheErrorThatThePageStates) {
  ResultView view = waving(23, 3);
  view.frames[1].cloth.x[7] = {1e3, -1e-3, 5.0};
  const std::vector<ResultView> views = {view};
  const Json data = data_of(view_page(views))[0];
  const double stated = data["error_m"].get<double>();
  EXPECT_EQ(stated, quantisation_error(view));
  for (std::size_t f = 0; f < view.frames.size(); ++f) {
    const std::vector<Vec3> x = positions_of(data["frames"][f]);
    ASSERT_EQ(x.size(), view.frames[f].cloth.x.size());
    for (std::size_t v = 0; v < x.size(); ++v)
      EXPECT_LE((x[v] - view.frames[f].cloth.x[v]).norm(), stated * (1.0 + 1e-9));
  }
}

TEST(ViewPage, AHundredSquareClothOf120FramesIsLessThan15Megabytes) {
  const std::vector<ResultView> views = {waving(101, 121)};
  EXPECT_LT(view_page(views).size(), 15'000'000u);
}

TEST(ViewPage, OnlyOneOrTwoResultsFitOnAPage) {
  EXPECT_THROW(view_page({}), std::invalid_argument);
  const std::vector<ResultView> three(3, waving(2, 1));
  EXPECT_THROW(view_page(three), std::invalid_argument);
}

TEST(ViewPage, TheDistanceOfTwoRunsIsThatOfTheirVertices) {
  ResultView a = waving(5, 4), b = waving(5, 3);
  b.frames[2].cloth.x[6] += Vec3(0.003, 0.004, 0.0);
  add_distance(a, b);
  ASSERT_EQ(a.frames.size(), 3u) << "only frames that both have";
  for (const ResultView* view : {&a, &b}) {
    const ViewField& field = view->fields[0];
    EXPECT_EQ(field.name, "distance");
    EXPECT_NEAR(field.full, 5.0, 1e-5) << field.unit;
    EXPECT_TRUE(field.frames[0].empty());
    for (std::size_t v = 0; v < 25; ++v) EXPECT_EQ(field.frames[2][v], v == 6 ? 255 : 0);
    EXPECT_EQ(view->fields[1].frames.size(), 3u);
  }
  ResultView c = waving(5, 2), d = waving(5, 2), other = waving(4, 2);
  add_distance(c, d);
  EXPECT_EQ(c.notes, std::vector<std::string>{"The two results have the same positions in every "
                                              "frame."});
  add_distance(d, other);
  EXPECT_SAYS(d.notes.at(0), "different numbers of vertices");
}

// -- the command ----------------------------------------------------------------------------------

class View : public Program {
 protected:
  std::string page(const std::string& file) const { return content(folder_ / file); }

  const Json* field(const Json& view, const std::string& name) const {
    for (const Json& f : view["fields"])
      if (f["name"] == name) return &f;
    return nullptr;
  }
};

TEST_F(View, ThePageNeedsNothingButItselfAndEscapesNames) {
  const std::string name = "</script><img src=x onerror=fail()>%DATA% 'a' \"b\"";
  ASSERT_EQ(run("run small.json --no-pictures --out r").code, 0);
  // `run` refuses such a name, but a result folder may come from anywhere.
  Json scene = Json::parse(content(folder_ / "r/scene.json"));
  scene["name"] = name;
  write("r/scene.json", scene.dump());
  const Outcome o = run("view r");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_SAYS(o.out, "4 frames");
  const std::string text = page("r/view.html");
  for (const char* outside : {"http:", "https:", "url(", "import ", "src=\"", "<img"})
    EXPECT_EQ(text.find(outside), std::string::npos) << outside;
  EXPECT_EQ(data_of(text)[0]["name"], name);
}

TEST_F(View, ThePageHoldsEveryFrameTheBodiesAndTheStrains) {
  ASSERT_EQ(run_small("r").code, 0);
  ASSERT_EQ(run("view r --out one.html --frames 1:3:2").code, 0);
  const Json data = data_of(page("one.html"))[0];
  ASSERT_EQ(data["frames"].size(), 2u);
  EXPECT_EQ(data["frames"][1]["number"], 3);
  ASSERT_EQ(data["bodies"].size(), 1u);
  const TriangleMesh cloth = read_mesh(folder_ / "r/frames/cloth_00003.ply");
  const std::vector<Vec3> x = positions_of(data["frames"][1]);
  ASSERT_EQ(x.size(), cloth.vertices.size());
  for (std::size_t v = 0; v < x.size(); ++v)
    EXPECT_LE((x[v] - cloth.vertices[v]).norm(), data["error_m"].get<double>() * (1.0 + 1e-9));
  const Json* strain = field(data, "strain");
  ASSERT_NE(strain, nullptr);
  EXPECT_GT((*strain)["full"].get<double>(), 0.0);
  EXPECT_EQ(field(data, "pressure"), nullptr) << "the run did not ask for it";
}

TEST_F(View, TheContactPressureOfARestingSheetCarriesItsWeight) {
  write("rest.json", R"({
    "materials": {"default": {"density": 0.2}},
    "geometry": [{"size": [0.2, 0.2], "cells": [4, 4], "transformation": {"translation": [0, 0, 0.001]}}],
    "obstacles": [{"shape": {"type": "box", "size": [1, 1, 0.1]}, "transformation": {"translation": [0, 0, -0.05]}}],
    "output": {"formats": [{"type": "ply", "pressure": true}]},
    "time": {"frames": 40}})");
  ASSERT_EQ(run("run rest.json --no-pictures --out r").code, 0);
  std::vector<NamedValues> values;
  const TriangleMesh cloth = read_ply(folder_ / "r/frames/cloth_00040.ply", values);
  const std::vector<double> area = vertex_areas(cloth.vertices, cloth.triangles);
  double force = 0.0;
  for (const NamedValues& named : values)
    if (named.name == "pressure")
      for (std::size_t v = 0; v < area.size(); ++v) force += area[v] * named.values[v];
  const double weight = 0.2 * 0.2 * 0.2 * 9.81;  // N
  EXPECT_NEAR(force, weight, 0.02 * weight);
  ASSERT_EQ(run("view r").code, 0);
  const Json data = data_of(page("r/view.html"))[0];
  EXPECT_EQ(data["pieces"], Json::parse("[[0, \"geometry_0\"]]"));
  ASSERT_NE(field(data, "pressure"), nullptr);
  EXPECT_EQ((*field(data, "pressure"))["unit"], "Pa");
}

TEST_F(View, AClothNearerThanItsRestGapHasThatShortfall) {
  ASSERT_EQ(run_small("r").code, 0);
  // The sheet of the first frame, moved so that it hangs half a millimetre above the ball.
  TriangleMesh cloth = read_mesh(folder_ / "r/frames/cloth_00000.ply");
  const TriangleMesh ball = read_mesh(folder_ / "r/frames/bodies_00000.ply");
  double top = -1.0;
  for (const Vec3& x : ball.vertices) top = std::max(top, x.z());
  constexpr double kGap = 5e-4;
  for (Vec3& x : cloth.vertices) x.z() = top + kGap;
  write_ply(folder_ / "r/frames/cloth_00000.ply", cloth.vertices, cloth.triangles);
  ASSERT_EQ(run("view r --frames 0").code, 0);
  const Json data = data_of(page("r/view.html"))[0];
  const Json* shortfall = field(data, "shortfall");
  ASSERT_NE(shortfall, nullptr);
  const double rest_gap = read_scene(folder_ / "r/scene.json").contact.rest_gap;
  EXPECT_NEAR((*shortfall)["full"].get<double>(), 1e3 * (rest_gap - kGap), 1e-4);
}

const char* const kPinch = R"({
  "name": "pinch",
  "geometry": [{"name": "napkin", "size": [0.2, 0.2], "cells": [6, 6]}],
  "obstacles": [
    {"name": "lower plate", "shape": {"type": "box", "size": [0.3, 0.3, 0.05]},
     "transformation": {"translation": [0, 0, -0.04]},
     "motion": [{"time": 0}, {"time": 0.2, "translation": [0, 0, 0.0151]}]},
    {"name": "upper plate", "shape": {"type": "box", "size": [0.3, 0.3, 0.05]},
     "transformation": {"translation": [0, 0, 0.04]},
     "motion": [{"time": 0}, {"time": 0.2, "translation": [0, 0, -0.0151]}]}],
  "contact": {"fail_safe": "impulse_zones"},
  "time": {"frames": 14}})";

TEST_F(View, AFailureBundleShowsThePairsThatCollide) {
  write("pinch.json", kPinch);
  ASSERT_EQ(run("run pinch.json --no-pictures --out p").code, 1);
  ASSERT_EQ(run("view p").code, 0);
  const Json whole = data_of(page("p/view.html"))[0];
  EXPECT_SAYS(whole["notes"].dump(), "This run stopped: ");
  EXPECT_SAYS(whole["notes"].dump(), "selvedge view p/failure");
  EXPECT_EQ(whole["bodies"].size(), whole["frames"].size()) << "the plates move";
  const Outcome o = run("view p/failure");
  ASSERT_EQ(o.code, 0) << o.err;
  const Json data = data_of(page("p/failure/view.html"))[0];
  ASSERT_GT(data["pairs"].size(), 0u);
  for (const Json& pair : data["pairs"]) {
    EXPECT_GE(pair["toi"].get<double>(), 0.0);
    EXPECT_LE(pair["toi"].get<double>(), 1.0);
    EXPECT_EQ(pair["x0"].size(), 12u);
  }
  EXPECT_EQ(data["frames"].back()["time"], 1.0);
}

TEST_F(View, WrongInputIsRefusedInOneSentence) {
  EXPECT_REFUSED(run("view nothing"), "no such result folder");
  fs::create_directories(folder_ / "empty");
  EXPECT_REFUSED(run("view empty"), "holds no frames/cloth_*.ply");
  ASSERT_EQ(run_small("r").code, 0);
  EXPECT_REFUSED(run("view r --frames 9"), "selects no frame");
  EXPECT_REFUSED(run("view r r r"), "one or two results");
  write("r/frames/cloth_00002.ply", "ply\nformat ascii 1.0\n");
  EXPECT_REFUSED(run("view r"), "cloth_00002.ply");
}

TEST_F(View, WithoutItsSceneAResultIsShownWithoutStrains) {
  ASSERT_EQ(run_small("r").code, 0);
  write("r/scene.json", R"({"name": "gone", "geometry": [{"mesh": "gone.obj"}]})");
  ASSERT_EQ(run("view r").code, 0);
  const Json data = data_of(page("r/view.html"))[0];
  EXPECT_EQ(field(data, "strain"), nullptr);
  EXPECT_SAYS(data["notes"].dump(), "gone.obj");
}

// -- in a browser ---------------------------------------------------------------------------------

class ViewInABrowser : public View {
 protected:
  void SetUp() override {
    View::SetUp();
    if (std::system("command -v chromium >/dev/null 2>&1") != 0)
      GTEST_SKIP() << "there is no browser; install chromium to have the pages of view opened";
  }

  /// The attributes data-… of the page after it has been opened at an address.
  std::map<std::string, std::string> opened(const std::string& file,
                                            const std::string& hash) const {
    const std::string command =
        "cd '" + folder_.string() + "' && HOME='" + folder_.string() +
        "' timeout 60 chromium --headless --no-sandbox --disable-dev-shm-usage "
        "--use-angle=swiftshader --enable-unsafe-swiftshader --window-size=400,800 "
        "--enable-logging=stderr "
        "--virtual-time-budget=1500 --dump-dom \"file://$PWD/" +
        file + "#" + hash + "\" >dom.txt 2>said.txt";
    EXPECT_EQ(std::system(command.c_str()), 0) << content(folder_ / "said.txt");
    const std::string said = content(folder_ / "said.txt");
    EXPECT_EQ(said.find("CONSOLE"), std::string::npos) << said;
    const std::string dom = content(folder_ / "dom.txt");
    std::map<std::string, std::string> attributes;
    const std::string tag = dom.substr(dom.find("<html"), dom.find('>', dom.find("<html")));
    for (auto at = tag.find("data-"); at != std::string::npos; at = tag.find("data-", at + 1)) {
      const auto equals = tag.find("=\"", at);
      const auto end = tag.find('"', equals + 2);
      attributes[tag.substr(at + 5, equals - at - 5)] = tag.substr(equals + 2, end - equals - 2);
    }
    EXPECT_EQ(attributes["ready"], "yes") << dom.substr(0, 2000);
    return attributes;
  }

  void append(const std::string& from, const std::string& to, const std::string& script) const {
    write(to, content(folder_ / from) + "<script>" + script + "</script>");
  }
};

TEST_F(ViewInABrowser, FramesDifferInTimeAndFollowSliderAndKeys) {
  ASSERT_EQ(run("run small.json --no-pictures --out r --set time.frames=20").code, 0);
  ASSERT_EQ(run("view r --out a.html").code, 0);
  auto end = opened("a.html", "frame=20&probe=1");
  EXPECT_EQ(end["frame"], "20");
  EXPECT_EQ(end["frames"], "21");
  EXPECT_EQ(opened("a.html", "probe=1")["frame"], "20") << "a page opens at the end of its run";
  const double area = std::stod(end["width"]) * std::stod(end["height"]);
  EXPECT_GT(std::stod(end["drawn"]), 0.05 * area) << "almost blank";
  EXPECT_LT(std::stod(end["drawn"]), 0.95 * area) << "no background";
  // What the user does, one thing after the other, and the picture after each.
  append("a.html", "used.html", R"(
    const shown = () => { draw(); return document.documentElement.dataset.pixels; };
    const note = (name, value) => document.documentElement.dataset[name] = value;
    const key = k => document.body.dispatchEvent(new KeyboardEvent('keydown', {key: k, bubbles: true}));
    note('start', shown());
    const slider = document.getElementById('time');
    slider.value = 20;
    slider.dispatchEvent(new Event('input', {bubbles: true}));
    note('slid', shown());
    key('Home');
    note('home', shown());
    key('End');
    note('end', shown());
    key('e');
    note('edges', shown());
    key('e');
    key('c');
    note('strain', shown());
    key('c'); key('d');
    note('turned', shown());)");
  auto used = opened("used.html", "frame=0&probe=1");
  EXPECT_NE(used["start"], end["pixels"]) << "two times, one picture";
  EXPECT_EQ(used["slid"], end["pixels"]) << "scrubbing shows the frame of its number";
  EXPECT_EQ(used["home"], used["start"]);
  EXPECT_EQ(used["end"], used["slid"]);
  EXPECT_NE(used["edges"], used["end"]);
  EXPECT_NE(used["strain"], used["end"]);
  EXPECT_NE(used["turned"], used["end"]);
}

TEST_F(ViewInABrowser, TwoRunsAreShownSideBySideWithTheirDistance) {
  ASSERT_EQ(run_small("a").code, 0);
  ASSERT_EQ(run_small("b", "--set geometry.0.transformation.translation=[0.02,0,0.32]").code, 0);
  ASSERT_EQ(run("view a b --out two.html").code, 0);
  append("two.html", "used.html", R"(
    draw();
    document.documentElement.dataset.apart = document.documentElement.dataset.pixels;
    state.colour = 'none';
    draw();)");
  auto page = opened("used.html", "frame=2&probe=1");
  EXPECT_EQ(page["frames"], "4");
  EXPECT_SAYS(page["colours"], "distance");
  EXPECT_NE(page["apart"], page["pixels"]) << "the distance is no colour";
}

}  // namespace

}  // namespace selvedge::view_test
