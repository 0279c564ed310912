// SPDX-License-Identifier: MIT
#include "extreme_cases.h"

#include <gtest/gtest.h>

#include <iostream>

namespace selvedge::extreme_test {
namespace {

std::vector<ExtremeCase> cases(bool quick) {
  std::vector<ExtremeCase> some;
  for (const auto& half : {number_cases(), contact_cases()})
    for (const ExtremeCase& one : half)
      if (one.quick == quick) some.push_back(one);
  return some;
}

/// Prints how the case ends, and its figure.
void expect_best(const ExtremeCase& one) {
  Trial trial({.data = SELVEDGE_SOURCE_DIR "/data/extreme", .method = {}, .out = {}});
  const CaseResult result = one.run(trial);
  std::cout << one.name << ": " << to_string(result.answer) << ", " << result.note << '\n';
  EXPECT_STREQ(to_string(result.answer), to_string(one.best)) << result.note;
}

class Extreme : public ::testing::TestWithParam<ExtremeCase> {};
TEST_P(Extreme, EndsAsItShould) { expect_best(GetParam()); }

class LongExtreme : public ::testing::TestWithParam<ExtremeCase> {};
TEST_P(LongExtreme, EndsAsItShould) { expect_best(GetParam()); }

std::string name_of(const ::testing::TestParamInfo<ExtremeCase>& info) {
  std::string name = info.param.name;
  for (char& c : name)
    if (c == '.') c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Cases, Extreme, ::testing::ValuesIn(cases(true)), name_of);
INSTANTIATE_TEST_SUITE_P(Cases, LongExtreme, ::testing::ValuesIn(cases(false)), name_of);

TEST(ExtremeProcess, AnAnswerThatIsNoneCountsAsSentByNobody) {
  const auto sent = detail::read_case_result(R"({"answer": 2, "note": "a"})");
  ASSERT_TRUE(sent);
  EXPECT_EQ(sent->answer, Answer::degraded);
  EXPECT_EQ(sent->note, "a");
  for (const char* text :
       {"", "{\"ans", "7", R"({"note": "a"})", R"({"answer": 5, "note": "a"})",
        R"({"answer": -1, "note": "a"})", R"({"answer": 1e30, "note": "a"})",
        R"({"answer": 1.5, "note": "a"})", R"({"answer": 1, "note": 3})",
        R"({"answer": 1, "note": "a", "measures": {"max_stretch": 0, "crossings": -1,
            "worst_speed": 0, "energy_ratio": 1, "given": {}}})"})
    EXPECT_FALSE(detail::read_case_result(text)) << text;
}

}  // namespace
}  // namespace selvedge::extreme_test
