// SPDX-License-Identifier: MIT
#include <selvedge/compare/detail/extreme_cases.h>

#include <gtest/gtest.h>

namespace selvedge::extreme_test {
namespace {

std::vector<ExtremeCase> quick_cases() {
  std::vector<ExtremeCase> quick;
  for (ExtremeCase& one : extreme_cases())
    if (one.quick) quick.push_back(std::move(one));
  return quick;
}

class Extreme : public ::testing::TestWithParam<ExtremeCase> {};

TEST_P(Extreme, EndsAsItShould) {
  Trial trial({.data = SELVEDGE_SOURCE_DIR "/data/extreme", .method = {}, .out = {}});
  const CaseResult result = GetParam().run(trial);
  EXPECT_STREQ(to_string(result.answer), to_string(GetParam().best)) << result.note;
}

INSTANTIATE_TEST_SUITE_P(Cases, Extreme, ::testing::ValuesIn(quick_cases()), [](const auto& info) {
  std::string name = info.param.name;
  for (char& c : name)
    if (c == '.') c = '_';
  return name;
});

TEST(ExtremeProcess, AnAnswerThatIsNoneCountsAsSentByNobody) {
  const auto sent = read_case_result(R"({"answer": 2, "note": "a"})");
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->answer, Answer::degraded);
  EXPECT_EQ(sent->note, "a");
  for (const char* text :
       {"", "{\"ans", "7", R"({"note": "a"})", R"({"answer": 4, "note": "a"})",
        R"({"answer": -1, "note": "a"})", R"({"answer": 1e30, "note": "a"})",
        R"({"answer": 1.5, "note": "a"})", R"({"answer": 1, "note": 3})",
        R"({"answer": 1, "note": "a", "measures": {"max_stretch": 0, "crossings": -1,
            "worst_speed": 0, "energy_ratio": 1, "given": {}}})"})
    EXPECT_FALSE(read_case_result(text)) << text;
}

}  // namespace
}  // namespace selvedge::extreme_test
