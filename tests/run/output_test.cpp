// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/core/system/internal/files.h>
#include <selvedge/run/detail/checkpoint.h>
#include <selvedge/run/detail/result_json.h>
#include <selvedge/run/frame_writer.h>
#include <selvedge/run/result_folder.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

namespace selvedge::output_test {
namespace {

namespace fs = std::filesystem;

/// An empty folder of its own for each test, removed at the end.
class Output : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("selvedge_output_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
T read_at(const std::string& bytes, std::size_t place) {
  T value{};
  if (place + sizeof value > bytes.size()) throw std::out_of_range("past the end of the file");
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

/// What a call threw, "" if nothing.
template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

const std::vector<Vec3> square = {{0, 0, 0.1}, {1, 0, 1.0 / 3.0}, {1, 1, -2e-300}, {0, 1, 7.25}};
const std::vector<Vec3> speeds = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0.1, 0.2, 0.3}};
const std::vector<Triangle> halves = {{0, 1, 2}, {0, 2, 3}};

RunResult example_result() {
  RunResult result;
  result.frames = 121;
  result.steps = 480;
  result.halvings = 3;
  result.retried_steps = 2;
  result.wall_s = 1.0 / 3.0;
  result.phase_s = {{"solve", 0.25}, {"response", 0.05}};
  result.worst_self_intersections = 1;
  result.worst_body_intersections = 2;
  result.max_penetration_m = 1e-9;
  result.max_stretch = 0.0625;
  result.strain_residual = 1e-5;
  result.final_max_speed = 0.001;
  result.peak_bytes = std::size_t{5} << 32;
  result.state_hash = "00ff";
  result.stopped = "interrupted";
  result.counters = {{"zones", 4.0}};
  result.clean = false;
  return result;
}

TEST_F(Output, ResultHasTheFieldsOthersReadWithTheirValues) {
  write_result(folder_ / "result.json", example_result());
  const auto json = nlohmann::json::parse(bytes_of(folder_ / "result.json"));
  EXPECT_EQ(json.at("clean"), false);
  EXPECT_EQ(json.at("frames"), 121);
  EXPECT_EQ(json.at("steps"), 480);
  EXPECT_EQ(json.at("halvings"), 3);
  EXPECT_EQ(json.at("retried_steps"), 2);
  EXPECT_EQ(json.at("wall_s").get<double>(), 1.0 / 3.0);
  EXPECT_EQ(json.at("phase_s"), (nlohmann::json{{"solve", 0.25}, {"response", 0.05}}));
  EXPECT_EQ(json.at("worst_self_intersections"), 1);
  EXPECT_EQ(json.at("worst_body_intersections"), 2);
  EXPECT_EQ(json.at("max_penetration_m"), 1e-9);
  EXPECT_EQ(json.at("max_stretch"), 0.0625);
  EXPECT_EQ(json.at("strain_residual"), 1e-5);
  EXPECT_EQ(json.at("final_max_speed"), 0.001);
  EXPECT_EQ(json.at("peak_bytes"), std::uint64_t{5} << 32);
  EXPECT_EQ(json.at("state_hash"), "00ff");
  EXPECT_EQ(json.at("stopped"), "interrupted");
  EXPECT_EQ(json.at("counters").at("zones"), 4.0);
}

/// A result whose fields all differ from their defaults and from each other.
RunResult filled_result() {
  RunResult r = example_result();
  r.clean_elsewhere = false;
  r.unchecked = "cloth was not checked";
  r.rest = {
      .at_rest = true, .unbalanced = 0.0005, .max_speed = 0.002, .vertex = 7, .verdict = "at rest"};
  r.tangle = {.start_pairs = 11,
              .pairs = 12,
              .elsewhere = 13,
              .until_s = 0.5,
              .max_speed = 0.75,
              .given_up = true,
              .jams = 14};
  r.flags = {.end = {1, 2, 3, 4}, .worst = {5, 6, 7, 8}};
  r.counters["max_gap_violation_m"] = 1e-5;
  r.ledger = {{"response", {{"steps", 4.0}, {"max_momentum_error", 1e-12}}}};
  r.plan = {{"bodies", {.asked = 9, .left_out = 8, .saved_s = 0.125}}};
  r.measures = {{"folds", 6.0}};
  return r;
}

TEST_F(Output, EveryFieldOfAResultReadsBackFromItsText) {
  RunResult result = filled_result();
  result.max_stretch = std::numeric_limits<double>::infinity();
  const std::string text = result_text(result);
  EXPECT_EQ(result_text(result_from_text(text)), text);
  EXPECT_NE(result_text(RunResult()), text);
  EXPECT_EQ(result_from_text(text).max_stretch, result.max_stretch);
}

TEST_F(Output, TheTextOfAResultIsIndentedByTwoSpaces) {
  EXPECT_TRUE(result_text(RunResult()).starts_with("{\n  \"clean\": "));
}

TEST_F(Output, ACounterOfAnOlderVersionGetsItsPresentName) {
  std::string text = result_text(filled_result());
  const std::string now = "max_gap_violation_m";
  text.replace(text.find(now), now.size(), "max_gap_lack_m");
  EXPECT_EQ(result_from_text(text).counters, filled_result().counters);
}

TEST_F(Output, TheFieldsOfAResultKeepTheirOrder) {
  std::vector<std::string> names;
  const auto json = nlohmann::ordered_json::parse(result_text(RunResult()));
  for (const auto& [name, value] : json.items()) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"clean",
                                             "unchecked",
                                             "clean_elsewhere",
                                             "frames",
                                             "steps",
                                             "halvings",
                                             "retried_steps",
                                             "wall_s",
                                             "phase_s",
                                             "worst_self_intersections",
                                             "worst_body_intersections",
                                             "max_penetration_m",
                                             "max_stretch",
                                             "strain_residual",
                                             "final_max_speed",
                                             "rest",
                                             "peak_bytes",
                                             "tangle",
                                             "flags",
                                             "state_hash",
                                             "stopped",
                                             "counters",
                                             "ledger",
                                             "plan",
                                             "measures"}));
}

TEST_F(Output, ATextThatIsNotAResultIsRefused) {
  EXPECT_THROW(result_from_text("{\"clean\": true"), std::invalid_argument);
  EXPECT_THROW(result_from_text("{\"clean\": true}"), std::invalid_argument);
  for (const char* steps : {"2.7e109", "3.5", "1e3", "99999999999999999999", "\"3\"", "null"}) {
    nlohmann::json json = nlohmann::json::parse(result_text(filled_result()));
    json["steps"] = nlohmann::json::parse(steps);
    EXPECT_THROW(result_from_text(json.dump()), std::invalid_argument) << steps;
  }
  std::string text = result_text(filled_result());
  text.replace(text.find("121"), 3, "\"x\"");
  EXPECT_THROW(result_from_text(text), std::invalid_argument);
}

TEST_F(Output, ACheckpointKeepsExactlyTheFieldsThatAResumedRunJoins) {
  const RunResult before = filled_result();
  RunResult kept, joined;
  kept = detail::result_from_checkpoint(JsonValue(detail::checkpoint_json(before)));
  EXPECT_EQ(kept.frames, 0);
  EXPECT_EQ(kept.plan.at("bodies").asked, before.plan.at("bodies").asked);
  EXPECT_EQ(kept.tangle.pairs, 0);
  EXPECT_EQ(kept.tangle.max_speed, 0.75);
  carry_on(before, joined);
  joined.clean = true;
  EXPECT_EQ(result_text(kept), result_text(joined));
  auto older = detail::checkpoint_json(before);
  older.erase("plan");
  EXPECT_TRUE(detail::result_from_checkpoint(JsonValue<nlohmann::json>(older)).plan.empty());
  older.erase("ledger");
  EXPECT_ANY_THROW(detail::result_from_checkpoint(JsonValue<nlohmann::json>(older)));
}

TEST_F(Output, ResultsOfTwoPartsAreJoinedByTheRuleOfEachField) {
  RunResult r = filled_result();
  r.clean = true;
  r.clean_elsewhere = true;
  r.max_stretch = 0.01;
  r.tangle.until_s = 0.0;
  r.counters = {{"zones", 1.0}, {"max_gap_violation_m", 1e-6}};
  r.flags.worst = {9, 0, 0, 0};
  carry_on(filled_result(), r);
  EXPECT_FALSE(r.clean_elsewhere);
  EXPECT_FALSE(r.clean) << "an earlier part had an intersection";
  EXPECT_EQ(r.steps, 480);
  EXPECT_EQ(r.halvings, 6);
  EXPECT_EQ(r.wall_s, 2.0 / 3.0);
  EXPECT_EQ(r.max_stretch, 0.0625);
  EXPECT_EQ(r.phase_s.at("solve"), 0.5);
  EXPECT_EQ(r.tangle.until_s, 0.5);
  EXPECT_EQ(r.tangle.pairs, 12);
  EXPECT_EQ(r.counters.at("zones"), 5.0);
  EXPECT_EQ(r.counters.at("max_gap_violation_m"), 1e-5);
  EXPECT_EQ(r.ledger.at("response").at("steps"), 8.0);
  EXPECT_EQ(r.ledger.at("response").at("max_momentum_error"), 1e-12);
  EXPECT_EQ(r.plan.at("bodies").left_out, 16);
  EXPECT_EQ(r.flags.worst, (std::array<int, kVertexFlags>{9, 6, 7, 8}));
  EXPECT_EQ(r.state_hash, "00ff");
}

TEST_F(Output, ANumberThatIsNotFiniteIsNamedAndNeverNull) {
  RunResult result;
  result.max_stretch = std::numeric_limits<double>::infinity();
  result.final_max_speed = std::numeric_limits<double>::quiet_NaN();
  result.phase_s["solve"] = -std::numeric_limits<double>::infinity();
  result.stopped = "name of a file that is no UTF-8: \xff";
  write_result(folder_ / "result.json", result);
  const std::string text = bytes_of(folder_ / "result.json");
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json.at("max_stretch"), "inf");
  EXPECT_EQ(json.at("final_max_speed"), "nan");
  EXPECT_EQ(json.at("phase_s").at("solve"), "-inf");
  EXPECT_EQ(text.find("null"), std::string::npos);
}

TEST_F(Output, AFrameSaysOnWhichSideOfWhichTangleItsVerticesAre) {
  detail::StateCopy copy;
  std::vector<Triangle> triangles;
  for (std::int32_t i = 0; i < 300; ++i) triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  copy.triangles = triangles;
  copy.state.x.assign(3 * triangles.size(), Vec3::Zero());
  copy.state.v = copy.state.x;
  copy.flags.assign(copy.state.x.size(), 0);
  const auto sides = [&]() -> std::vector<double> {
    for (const NamedValues& values : detail::frame_values(copy))
      if (values.name == "side") return values.values;
    return {};
  };
  EXPECT_TRUE(sides().empty()) << "no tangles";
  // Tangle k is of the triangles 2k and 2k + 1, the second one also of one of a body.
  for (std::int32_t k = 0; k < 140; ++k)
    copy.state.tangles.list.push_back({.side = {std::vector{2 * k}, std::vector{2 * k + 1, 300}}});
  const std::vector<double> found = sides();
  ASSERT_EQ(found.size(), copy.state.x.size());
  for (std::size_t v = 0; v < found.size(); ++v) {
    const std::size_t triangle = v / 3;
    // The numbers of 127 tangles fit into a byte; then they begin again.
    const double expected = triangle < 280 ? static_cast<double>(triangle % 254 + 1) : 0.0;
    EXPECT_EQ(found[v], expected) << v;
  }
}

TEST_F(Output, NumberedFilesSortByNumberAndGrowPastTheirDigits) {
  EXPECT_EQ(numbered("frames", "cloth", 42, 5, ".ply"), fs::path("frames/cloth_00042.ply"));
  EXPECT_EQ(numbered("steps", "cloth", 0, 6, ".ply"), fs::path("steps/cloth_000000.ply"));
  EXPECT_EQ(numbered("", "x", 123456, 5, ".png"), fs::path("x_123456.png"));
}

/// The values of one appended array, found through its offset as a reader of the format does.
template <class T>
std::vector<T> vtp_array(const std::string& bytes, const std::string& name) {
  const std::string head = bytes.substr(0, bytes.find("<AppendedData"));
  const char* type = std::is_same_v<T, double> ? "Float64" : "Int64";
  const std::string element = "<DataArray type=\"" + std::string(type) + "\" Name=\"" + name + "\"";
  const std::string format = "format=\"appended\" offset=\"";
  const std::size_t at = head.find(element);
  const std::size_t offset = at == std::string::npos ? at : head.find(format, at);
  if (offset >= head.find("/>", at)) throw std::runtime_error("no array " + name);
  const std::string mark = "<AppendedData encoding=\"raw\">\n_";
  const std::size_t begin =
      bytes.find(mark) + mark.size() + std::stoul(head.substr(offset + format.size()));
  std::vector<T> values(read_at<std::uint64_t>(bytes, begin) / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = read_at<T>(bytes, begin + sizeof(std::uint64_t) + i * sizeof(T));
  return values;
}

TEST_F(Output, AVtpFileGivesBackTheSameBits) {
  write_vtp(folder_ / "a.vtp", square, speeds, halves);
  const std::string bytes = bytes_of(folder_ / "a.vtp");
  EXPECT_NE(bytes.find("NumberOfPoints=\"4\""), std::string::npos);
  EXPECT_NE(bytes.find("NumberOfPolys=\"2\""), std::string::npos);
  EXPECT_NE(bytes.find("header_type=\"UInt64\""), std::string::npos);
  const auto points = vtp_array<double>(bytes, "Points");
  const auto velocity = vtp_array<double>(bytes, "velocity");
  ASSERT_EQ(points.size(), 12U);
  ASSERT_EQ(velocity.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(points[i], square[i / 3][static_cast<int>(i % 3)]);
    EXPECT_EQ(velocity[i], speeds[i / 3][static_cast<int>(i % 3)]);
  }
  EXPECT_EQ(vtp_array<std::int64_t>(bytes, "connectivity"),
            (std::vector<std::int64_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(vtp_array<std::int64_t>(bytes, "offsets"), (std::vector<std::int64_t>{3, 6}));
  const std::string tail = "\n</AppendedData>\n</VTKFile>\n";
  EXPECT_EQ(bytes.substr(bytes.size() - tail.size()), tail);
}

TEST_F(Output, AVtpFileWithoutVelocitiesHasNone) {
  write_vtp(folder_ / "a.vtp", square, {}, halves);
  EXPECT_EQ(bytes_of(folder_ / "a.vtp").find("velocity"), std::string::npos);
  EXPECT_THROW(write_vtp(folder_ / "b.vtp", square, std::span(speeds).first(3), halves),
               std::invalid_argument);
}

TEST_F(Output, APvdSeriesNamesItsPiecesRelativeToItself) {
  const std::vector<double> times = {0.0, 1.0 / 60.0};
  write_pvd(folder_ / "run.pvd", {folder_ / "vtk" / "a&b_00000.vtp", folder_ / "vtk" / "1.vtp"},
            times);
  const std::string text = bytes_of(folder_ / "run.pvd");
  EXPECT_NE(text.find("timestep=\"0.0\" part=\"0\" file=\"vtk/a&amp;b_00000.vtp\""),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("timestep=\"0.016666666666666666\" part=\"0\" file=\"vtk/1.vtp\""),
            std::string::npos)
      << text;
  EXPECT_THROW(write_pvd(folder_ / "run.pvd", {"a.vtp"}, times), std::invalid_argument);
}

TEST_F(Output, APointCacheIsValidAfterEveryFrame) {
  Pc2Writer cache(folder_ / "cloth.pc2", 4);
  for (int frame = 0; frame < 3; ++frame) {
    std::vector<Vec3> x = square;
    for (Vec3& p : x) p.x() += frame;
    cache.append(x);
    const std::string bytes = bytes_of(folder_ / "cloth.pc2");
    ASSERT_EQ(bytes.size(), 32U + 48U * static_cast<unsigned>(frame + 1));
    EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2\0", 12));
    EXPECT_EQ(read_at<std::int32_t>(bytes, 12), 1);
    EXPECT_EQ(read_at<std::int32_t>(bytes, 16), 4);
    EXPECT_EQ(read_at<float>(bytes, 20), 1.0F);
    EXPECT_EQ(read_at<float>(bytes, 24), 1.0F);
    EXPECT_EQ(read_at<std::int32_t>(bytes, 28), frame + 1);
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_EQ(read_at<float>(bytes, bytes.size() - 48 + 4 * i),
                static_cast<float>(x[i / 3][static_cast<int>(i % 3)]));
  }
}

TEST_F(Output, APointCacheThatIsResumedEqualsOneWrittenAtOnce) {
  const fs::path once = folder_ / "once.pc2", twice = folder_ / "twice.pc2";
  {
    Pc2Writer cache(once, 4);
    for (int i = 0; i < 3; ++i) cache.append(i == 2 ? speeds : square);
  }
  {
    Pc2Writer cache(twice, 4);
    for (int i = 0; i < 4; ++i) cache.append(square);
  }
  {
    Pc2Writer cache(twice, 4, 2);
    cache.append(speeds);
    EXPECT_EQ(cache.frames(), 3);
  }
  EXPECT_EQ(bytes_of(once), bytes_of(twice));
}

TEST_F(Output, APointCacheRefusesWhatDoesNotFit) {
  const fs::path file = folder_ / "cloth.pc2";
  Pc2Writer cache(file, 4);
  cache.append(square);
  EXPECT_THROW(cache.append(std::span(square).first(3)), std::invalid_argument);
  std::vector<Vec3> far = square;
  far[2].y() = 1e39;
  EXPECT_THROW(cache.append(far), std::invalid_argument);
  far[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cache.append(far), std::invalid_argument);
  EXPECT_EQ(cache.frames(), 1);
  EXPECT_EQ(bytes_of(file).size(), 32U + 48U);
  EXPECT_THROW(Pc2Writer(file, 5, 1), std::invalid_argument);
  EXPECT_THROW(Pc2Writer(file, 4, 2), std::invalid_argument);
  EXPECT_THROW(Pc2Writer(folder_ / "missing.pc2", 4, 0), std::runtime_error);
  std::ofstream(folder_ / "text.pc2") << "this is no point cache, but it is long enough to be one";
  EXPECT_THROW(Pc2Writer(folder_ / "text.pc2", 4, 0), std::invalid_argument);
}

TEST_F(Output, AFullDiskIsSaidAndNamesTheFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  const std::string no_space = std::strerror(ENOSPC);
  const auto expect_said = [&](const std::string& message) {
    EXPECT_NE(message.find("/dev/full"), std::string::npos) << message;
    EXPECT_NE(message.find(no_space), std::string::npos) << message;
  };
  expect_said(message_of([] { write_result("/dev/full", {}); }));
  expect_said(message_of([] { write_vtp("/dev/full", square, speeds, halves); }));
  expect_said(message_of([] { write_pvd("/dev/full", {}, {}); }));
  expect_said(message_of([] { Pc2Writer cache("/dev/full", 4); }));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST_F(Output, AMissingFolderIsSaidAndNamesTheFile) {
  const fs::path file = folder_ / "missing" / "result.json";
  const std::string message = message_of([&] { write_result(file, {}); });
  EXPECT_NE(message.find(file.string()), std::string::npos) << message;
  EXPECT_NE(message.find(std::strerror(ENOENT)), std::string::npos) << message;
}

TEST_F(Output, AnUnfinishedFileLeavesTheOldOneAsItWas) {
  const fs::path file = folder_ / "kept.txt";
  {
    AtomicFile out(file);
    out.write("old");
    out.commit();
  }
  {
    AtomicFile out(file);
    out.write(std::string(1000000, 'x'));
    EXPECT_EQ(bytes_of(file), "old");
  }
  EXPECT_EQ(bytes_of(file), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(Output, TwoProcessesThatWriteOneFileDoNotMixTheirBytes) {
  const fs::path file = folder_ / "shared.txt";
  AtomicFile out(file);
  out.write(std::string(1000000, 'x'));
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    AtomicFile other(file);
    other.write("child");
    other.commit();
    _exit(0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(bytes_of(file), "child");
  out.commit();
  EXPECT_EQ(bytes_of(file), std::string(1000000, 'x'));
}

TEST_F(Output, AFaultOfTheSystemIsThrownWithItsCode) {
  try {
    AtomicFile out(folder_ / "missing" / "a.txt");
    FAIL() << "opened in a folder that is not there";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
  }
}

}  // namespace
}  // namespace selvedge::output_test
