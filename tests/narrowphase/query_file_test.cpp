// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <selvedge/narrowphase/detail/rational.h>
#include <selvedge/narrowphase/query_file.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <stdexcept>

namespace selvedge::query_file_test {
namespace {

using detail::parse_rational;
using detail::RationalFault;
namespace fs = std::filesystem;

constexpr double kTiniest = std::numeric_limits<double>::denorm_min();

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

/// The fault, or the double that num / den is.
std::string read(const std::string& num, const std::string& den) {
  double value = 0.0;
  const RationalFault fault = parse_rational(num, den, value);
  char text[64];
  std::snprintf(text, sizeof text, "%.17g", value);
  return fault == RationalFault::none ? text : "fault " + std::to_string(static_cast<int>(fault));
}

std::string fault(RationalFault f) { return "fault " + std::to_string(static_cast<int>(f)); }

// -- rational numbers -----------------------------------------------------------------------------

TEST(Rational, DoublesOfEverySizeComeBackBitForBit) {
  std::mt19937_64 random(1);
  std::vector<double> values = {0.0,
                                -0.0,
                                1.0,
                                -1.5,
                                kTiniest,
                                -kTiniest,
                                std::numeric_limits<double>::min(),
                                std::nextafter(std::numeric_limits<double>::min(), 0.0),
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::lowest(),
                                1e-300,
                                1e300,
                                0.1,
                                0x1p53 + 2.0,
                                0x1p64,
                                0x1p-64};
  for (int i = 0; i < 20000; ++i)
    if (const double x = std::bit_cast<double>(random()); std::isfinite(x)) values.push_back(x);
  for (const double x : values) {
    std::string text;
    detail::append_rational(x, text);
    const std::size_t comma = text.find(',');
    double back = 1.0;
    ASSERT_EQ(parse_rational(text.substr(0, comma), text.substr(comma + 1), back),
              RationalFault::none)
        << text;
    ASSERT_EQ(bits(back), bits(x)) << text;
  }
}

TEST(Rational, WhatIsWrittenIsTheNumberAsOtherReadersSeeIt) {
  const auto written = [](double x) {
    std::string text;
    detail::append_rational(x, text);
    return text;
  };
  EXPECT_EQ(written(0.0), "0,1");
  EXPECT_EQ(written(-0.75), "-3,4");
  EXPECT_EQ(written(6.0), "6,1");
  EXPECT_EQ(written(0x1p-70), "1,1180591620717411303424");
  EXPECT_EQ(written(0x1p70), "1180591620717411303424,1");
  // strtod is an independent reader of long decimals; 2^1074 itself is no double.
  const std::string tiny = written(kTiniest);
  EXPECT_EQ(tiny.size(), 2u + 324u);
  EXPECT_EQ(written(2.0 * kTiniest).substr(0, 2), "1,");
  EXPECT_EQ(std::strtod(written(0x1p-1000).c_str() + 2, nullptr), 0x1p1000);
}

TEST(Rational, QuotientsNeedNotBeReducedNorHavePowersOfTwoBelow) {
  EXPECT_EQ(read("6", "4"), "1.5");
  EXPECT_EQ(read("-21", "7"), "-3");
  EXPECT_EQ(read("21", "-14"), "-1.5");
  EXPECT_EQ(read("-21", "-14"), "1.5");
  EXPECT_EQ(read("+3", "0000000000000000000000000000004"), "0.75");
  EXPECT_EQ(read("0", "-7"), "-0");
  // 3^80 * 5 / 3^80 and 3^80 / (3^79 * 2^3), parts far longer than a machine word.
  EXPECT_EQ(
      read("739044147071729616580416051031916488006", "147808829414345923316083210206383297601"),
      fault(RationalFault::no_double));
  EXPECT_EQ(
      read("739044147071729616580416051031916488005", "147808829414345923316083210206383297601"),
      "5");
  EXPECT_EQ(
      read("147808829414345923316083210206383297601", "394156878438255795509555227217022126936"),
      "0.375");
}

TEST(Rational, WhatNoDoubleEqualsIsRefused) {
  const std::string no_double = fault(RationalFault::no_double);
  EXPECT_EQ(read("1", "3"), no_double);
  EXPECT_EQ(read("1", "10"), no_double);
  EXPECT_EQ(read("9007199254740993", "1"), no_double) << "2^53 + 1";
  EXPECT_EQ(read("9007199254740994", "1"), "9007199254740994");
  EXPECT_EQ(read("18446744073709551617", "1"), no_double) << "2^64 + 1";
  EXPECT_EQ(read("1" + std::string(310, '0'), "1"), no_double) << "beyond the largest double";
  EXPECT_EQ(read("1" + std::string(310, '0'), "1" + std::string(309, '0')), "10");
  EXPECT_EQ(read("1", "1" + std::string(330, '0')), no_double);
}

TEST(Rational, OneUnitBesideADoubleIsRefusedAtAnyLength) {
  // (2^53 + 1) 2^k is no double; neither is k 2^n + 1 for large n.
  std::string text;
  detail::append_rational(0x1.8p200, text);
  std::string number = text.substr(0, text.find(','));
  EXPECT_NE(read(number, "1"), fault(RationalFault::no_double));
  ++number.back();
  EXPECT_EQ(read(number, "1"), fault(RationalFault::no_double));
}

TEST(Rational, WhatIsNoIntegerIsRefused) {
  for (const char* text : {"", "-", "+", "--1", "1.0", "1e3", "0x1", "one", "1 2", "nan", "1\t"}) {
    EXPECT_EQ(read(text, "1"), fault(RationalFault::numerator)) << text;
    EXPECT_EQ(read("1", text), fault(RationalFault::denominator)) << text;
  }
  for (const char* zero : {"0", "-0", "00000000000000000000000000"}) {
    EXPECT_EQ(read("1", zero), fault(RationalFault::zero_denominator)) << zero;
    EXPECT_EQ(read("0", zero), fault(RationalFault::zero_denominator)) << zero;
  }
  EXPECT_EQ(read("1" + std::string(100000, '0'), "1"), fault(RationalFault::too_long));
}

// -- files ----------------------------------------------------------------------------------------

class QueryFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("selvedge_query_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  /// The sentence with which the file is refused, without the folder.
  std::string refusal(const std::string& text, const std::string& toi = "") const {
    const fs::path file = write("vf.csv", text);
    fs::remove(folder_ / "vf.toi.csv");
    if (!toi.empty()) write("vf.toi.csv", toi);
    try {
      read_queries(file);
    } catch (const std::invalid_argument& error) {
      const std::string sentence = error.what();
      const std::string folder = (folder_ / "").string();
      EXPECT_EQ(sentence.rfind(folder, 0), 0u) << sentence;
      EXPECT_EQ(sentence.find('\n'), std::string::npos);
      return sentence.substr(folder.size());
    }
    return "not refused";
  }

  fs::path folder_;
};

#define EXPECT_SAYS(text, part)                                                     \
  do {                                                                              \
    const std::string sentence_ = text;                                             \
    EXPECT_NE(sentence_.find(part), std::string::npos) << "it says: " << sentence_; \
  } while (false)

/// `count` rows; line k (from 1) has the coordinates k, k/2 and k/4.
std::string rows(int count, int truth = 0, int first = 1, const std::string& end = "\n") {
  std::string text;
  for (int k = first; k < first + count; ++k) {
    const std::string n = std::to_string(k);
    text += n + ",1," + n + ",2," + n + ",4," + std::to_string(truth) + end;
  }
  return text;
}

/// rows(16) with one line replaced.
std::string with_line(int line, const std::string& row) {
  return rows(line - 1) + row + "\n" + rows(16 - line, 0, line + 1);
}

TEST_F(QueryFile, RowsAreVerticesAtTheStartThenAtTheEnd) {
  const QuerySet set = read_queries(write("vf.csv", rows(8) + rows(8, 1, 9)));
  ASSERT_EQ(set.queries.size(), 2u);
  EXPECT_EQ(set.kind, ContactKind::point_triangle);
  EXPECT_EQ(set.truth, (std::vector<std::uint8_t>{0, 1}));
  EXPECT_TRUE(set.toi.empty());
  EXPECT_TRUE(set.remarks.empty());
  for (int q = 0; q < 2; ++q)
    for (int k = 0; k < 4; ++k) {
      const double at_0 = 8 * q + k + 1, at_1 = at_0 + 4;
      EXPECT_EQ(set.queries[q].x_t0[k], Vec3(at_0, at_0 / 2, at_0 / 4));
      EXPECT_EQ(set.queries[q].x_t1[k], Vec3(at_1, at_1 / 2, at_1 / 4));
    }
}

TEST_F(QueryFile, WhatIsWrittenComesBackBitForBit) {
  std::mt19937_64 random(2);
  std::vector<Query> queries(200);
  std::vector<TimeEnclosure> times(queries.size());
  const auto any = [&] {
    double x = std::bit_cast<double>(random());
    while (!std::isfinite(x)) x = std::bit_cast<double>(random());
    return x;
  };
  std::uniform_real_distribution<double> time(0.0, 1.0);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    queries[i].kind = ContactKind::edge_edge;
    for (int k = 0; k < 4; ++k) {
      queries[i].x_t0[k] = Vec3(any(), any(), any());
      queries[i].x_t1[k] = Vec3(1e-300 * time(random), 1e300 * time(random), kTiniest);
    }
    if (i % 3 == 0) times[i].lo = time(random);
    if (i % 3 == 0) times[i].hi = std::nextafter(times[i].lo, 2.0);
  }
  const fs::path file = folder_ / "edge-edge.csv";
  QueryWriter writer(file);
  for (std::size_t i = 0; i < queries.size(); ++i) writer.append(queries[i], times[i]);
  EXPECT_FALSE(fs::exists(file)) << "half a file was to be seen";
  writer.commit();
  EXPECT_EQ(writer.count(), queries.size());
  const QuerySet set = read_queries(file);
  ASSERT_EQ(set.queries.size(), queries.size());
  ASSERT_EQ(set.toi.size(), queries.size());
  for (std::size_t i = 0; i < queries.size(); ++i) {
    EXPECT_EQ(set.truth[i], i % 3 == 0 ? 1 : 0);
    EXPECT_EQ(bits(set.toi[i].lo), bits(times[i].lo));
    EXPECT_EQ(bits(set.toi[i].hi), bits(times[i].hi));
    EXPECT_EQ(set.queries[i].kind, ContactKind::edge_edge);
    for (int k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(bits(set.queries[i].x_t0[k][axis]), bits(queries[i].x_t0[k][axis]));
        ASSERT_EQ(bits(set.queries[i].x_t1[k][axis]), bits(queries[i].x_t1[k][axis]));
      }
  }
}

TEST_F(QueryFile, TheWriterRefusesWhatTheReaderWould) {
  const fs::path file = folder_ / "q.csv";
  QueryWriter writer(file);
  Query query{};
  for (int k = 0; k < 4; ++k) query.x_t0[k] = query.x_t1[k] = Vec3::Zero();
  writer.append(query, {});
  query.x_t1[3][2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(writer.append(query, {}), std::invalid_argument);
  query.x_t1[3][2] = 0.0;
  EXPECT_THROW(writer.append(query, {0.5, 0.25}), std::invalid_argument);
  EXPECT_THROW(writer.append(query, {0.5, 2.0}), std::invalid_argument);
  query.kind = ContactKind::edge_edge;
  EXPECT_THROW(writer.append(query, {}), std::invalid_argument);
  writer.commit();
  EXPECT_EQ(read_queries(file, ContactKind::point_triangle).queries.size(), 1u);
  EXPECT_THROW(QueryWriter(folder_ / "none" / "q.csv"), std::exception);
}

TEST_F(QueryFile, ThePathTellsTheKind) {
  const auto pt = ContactKind::point_triangle, ee = ContactKind::edge_edge;
  EXPECT_EQ(query_kind_of("a/vertex-face/data_0_0.csv"), pt);
  EXPECT_EQ(query_kind_of("a/edge-edge/data_0_0.csv"), ee);
  EXPECT_EQ(query_kind_of("227vf.csv"), pt);
  EXPECT_EQ(query_kind_of("a/b/3036ee.csv"), ee);
  EXPECT_EQ(query_kind_of("drape.point_triangle.csv"), pt);
  EXPECT_EQ(query_kind_of("drape.edge_edge.csv"), ee);
  EXPECT_EQ(query_kind_of("edge-edge/227VF.csv"), pt) << "the name of the file says it";
  EXPECT_EQ(query_kind_of("vertex-face/edge-edge/x.csv"), ee) << "the nearest folder says it";
  for (const char* file : {"data.csv", "sleeve.csv", "ee/data.csv", "vf-ee.csv"})
    EXPECT_FALSE(query_kind_of(fs::path("/") / file).has_value()) << file;
}

TEST_F(QueryFile, AKindThatNothingTellsIsAskedFor) {
  const fs::path file = write("data.csv", rows(8));
  EXPECT_THROW(read_queries(file), std::invalid_argument);
  EXPECT_EQ(read_queries(file, ContactKind::edge_edge).queries[0].kind, ContactKind::edge_edge);
  EXPECT_EQ(read_queries(write("vf.csv", rows(8)), ContactKind::edge_edge).kind,
            ContactKind::edge_edge)
      << "what is said comes before the name";
}

TEST_F(QueryFile, WindowsLineEndsAndByteOrderMarksAreReadWithARemark) {
  const QuerySet windows = read_queries(write("vf.csv", rows(2) + rows(14, 0, 3, "\r\n")));
  EXPECT_EQ(windows.queries.size(), 2u);
  EXPECT_EQ(windows.queries[1].x_t1[3], Vec3(16.0, 8.0, 4.0));
  ASSERT_EQ(windows.remarks.size(), 1u);
  EXPECT_SAYS(windows.remarks[0], "vf.csv: line 3: ");
  const QuerySet marked = read_queries(write("vf.csv", "\xEF\xBB\xBF" + rows(8)));
  EXPECT_EQ(marked.queries.size(), 1u);
  ASSERT_EQ(marked.remarks.size(), 1u);
  EXPECT_SAYS(marked.remarks[0], "vf.csv: line 1: ");
}

TEST_F(QueryFile, BlanksAndAMissingLastLineEndDoNoHarm) {
  std::string text = rows(8);
  text.pop_back();
  EXPECT_EQ(read_queries(write("vf.csv", text)).queries.size(), 1u);
  EXPECT_EQ(read_queries(write("vf.csv", rows(8) + "\n \n\r\n")).queries.size(), 1u);
  const std::string spaced = " 1 ,\t1, 1, 2,1 ,4, 0 ";
  EXPECT_EQ(read_queries(write("vf.csv", with_line(1, spaced))).queries.size(), 2u);
}

TEST_F(QueryFile, EveryFaultIsSaidWithItsLine) {
  EXPECT_SAYS(refusal(with_line(12, "1,1,1,2,1,4")), "vf.csv: line 12: has 6 columns, must have 7");
  EXPECT_SAYS(refusal(with_line(3, "1,1,1,2,1,4,0,0")), "line 3: has 8 columns");
  EXPECT_SAYS(refusal(with_line(16, "x")), "line 16: has 1 column,");
  EXPECT_SAYS(refusal(with_line(9, "1,1,1,0,1,4,0")), "line 9: y_den is zero");
  EXPECT_SAYS(refusal(with_line(9, "1,1,1,2,1,3,0")), "line 9: z is \"1/3\", which no double");
  EXPECT_SAYS(refusal(with_line(9, "1.5,1,1,2,1,4,0")), "line 9: x_num is \"1.5\", must be");
  EXPECT_SAYS(refusal(with_line(9, "1,one,1,2,1,4,0")), "line 9: x_den is \"one\", must be");
  EXPECT_SAYS(refusal(with_line(9, "1,1,1,2,,4,0")), "line 9: z_num is \"\", must be");
  EXPECT_SAYS(refusal(with_line(9, "1,1,1,2,1,4,2")), "line 9: truth is \"2\", must be 0 or 1");
  EXPECT_SAYS(refusal(with_line(9, "1,1,1,2,1,4,")), "line 9: truth is \"\"");
  EXPECT_SAYS(refusal(with_line(14, "1,1,1,2,1,4,1")),
              "line 14: truth is 1, but line 9 of the same query says 0");
  EXPECT_SAYS(refusal(with_line(5, "")), "line 5: is empty");
  EXPECT_SAYS(refusal(with_line(2, std::string("1,1,\0,2,1,4,0", 12))), "line 2: y_num is \"?\"");
  EXPECT_SAYS(refusal("x_num,x_den,y_num,y_den,z_num,z_den,truth\n" + rows(8)),
              "line 1: x_num is \"x_num\", must be an integer (a query file has no header)");
  EXPECT_SAYS(refusal(with_line(2, "1" + std::string(100000, '0') + ",1,1,2,1,4,0")),
              "line 2: x_num or x_den has more than 100000 digits");
}

TEST_F(QueryFile, RowsMustComeInEights) {
  for (const int count : {1, 7, 9, 15}) {
    const std::string said = refusal(rows(count));
    EXPECT_SAYS(said, "line " + std::to_string(count) + ": the file ends after " +
                          std::to_string(count % 8) + " of the 8 rows of query " +
                          std::to_string(count / 8) + ", which begins in line " +
                          std::to_string(count / 8 * 8 + 1));
  }
}

TEST_F(QueryFile, WhatIsNoQueryFileIsRefused) {
  EXPECT_SAYS(refusal(""), "vf.csv: is empty");
  EXPECT_SAYS(refusal("\n \n"), "vf.csv: is empty");
  EXPECT_SAYS(refusal(std::string(2'000'000, '1')), "line 1: is too long");
  EXPECT_THROW(read_queries(folder_ / "none.csv"), std::invalid_argument);
  EXPECT_THROW(read_queries(folder_ / "none_vf.csv"), std::invalid_argument);
  EXPECT_THROW(read_queries(folder_, ContactKind::edge_edge), std::invalid_argument);
}

TEST_F(QueryFile, TimesThatDoNotFitAreRefusedWithTheirLine) {
  const std::string two = rows(8) + rows(8, 1, 9);
  EXPECT_EQ(refusal(two, "0,0,,\n1,1,0.25,0.5\n"), "not refused");
  const QuerySet set = read_queries(folder_ / "vf.csv");
  ASSERT_EQ(set.toi.size(), 2u);
  EXPECT_EQ(set.toi[0].lo, kNoCollision);
  EXPECT_EQ(set.toi[1].lo, 0.25);
  EXPECT_EQ(set.toi[1].hi, 0.5);
  EXPECT_SAYS(refusal(two, "0,0,,\n"), "vf.toi.csv: has times for 1 of 2 queries");
  EXPECT_SAYS(refusal(two, "0,0,,\n1,1,0.5,0.5\n2,0,,\n"), "vf.toi.csv: line 3: there are only 2");
  EXPECT_SAYS(refusal(two, "0,0,,\n2,1,0.5,0.5\n"), "line 2: index is \"2\", must be 1");
  EXPECT_SAYS(refusal(two, "0,1,0,0\n1,1,0.5,0.5\n"), "line 1: truth is 1, but the query file");
  EXPECT_SAYS(refusal(two, "0,0,0.5,\n1,1,0.5,0.5\n"), "line 1: has a time");
  EXPECT_SAYS(refusal(two, "0,0,,\n1,1,,\n"), "line 2: toi_lo is \"\"");
  EXPECT_SAYS(refusal(two, "0,0,,\n1,1,0.5,1.5\n"), "line 2: toi_hi is \"1.5\"");
  EXPECT_SAYS(refusal(two, "0,0,,\n1,1,nan,1\n"), "line 2: toi_lo is \"nan\"");
  EXPECT_SAYS(refusal(two, "0,0,,\n1,1,0.75,0.5\n"), "line 2: toi_lo is later than toi_hi");
  EXPECT_SAYS(refusal(two, "0,0,\n"), "line 1: has 3 columns, must have 4");
}

// -- recordings -----------------------------------------------------------------------------------

/// A point that falls from `height` m through a triangle, to which it comes at 1 / (1 + below).
Query falling_point(double below) {
  Query query;
  query.kind = ContactKind::point_triangle;
  query.x_t0 = {Vec3(0.25, 0.25, 1), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  query.x_t1 = query.x_t0;
  query.x_t1[0].z() = -below;
  return query;
}

TEST_F(QueryFile, ARecordingHasTheTrueTimesWithinARounding) {
  QueryRecorder recorder({folder_ / "run.csv"});
  recorder.add(falling_point(1.0));   // at 0.5
  recorder.add(falling_point(0.0));   // at 1
  recorder.add(falling_point(-0.5));  // not at all
  const std::vector<RecordedQueries> recorded = recorder.write();
  ASSERT_EQ(recorded.size(), 1u);
  EXPECT_EQ(recorded[0].file, folder_ / "run.point_triangle.csv");
  EXPECT_EQ(recorded[0].positives, 2u);
  const QuerySet set = read_queries(recorded[0].file);
  EXPECT_EQ(set.truth, (std::vector<std::uint8_t>{1, 1, 0}));
  ASSERT_EQ(set.toi.size(), 3u);
  EXPECT_EQ(set.toi[0].lo, 0.5);
  EXPECT_EQ(set.toi[0].hi, std::nextafter(0.5, 1.0));
  EXPECT_EQ(set.toi[1].lo, 1.0);
  EXPECT_EQ(set.toi[1].hi, 1.0);
  EXPECT_EQ(set.toi[2].lo, kNoCollision);
}

TEST_F(QueryFile, ARecordingIsNamedAfterItsPrefixAndNeedsItsFolder) {
  const auto file = [](const fs::path& prefix) {
    QueryRecorder recorder({prefix});
    recorder.add(falling_point(1.0));
    return recorder.write().at(0).file;
  };
  EXPECT_EQ(file(folder_), folder_ / "point_triangle.csv");
  EXPECT_EQ(file(folder_ / "a.b"), folder_ / "a.b.point_triangle.csv");
  for (const fs::path& missing : {folder_ / "none" / "a", folder_ / "none" / ""})
    EXPECT_THROW(QueryRecorder({missing}), std::invalid_argument) << missing;
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  const fs::path here = file("here");
  fs::current_path(before);
  EXPECT_EQ(here, "here.point_triangle.csv");
  EXPECT_TRUE(fs::exists(folder_ / here));
}

}  // namespace

}  // namespace selvedge::query_file_test
