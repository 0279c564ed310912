// SPDX-License-Identifier: MIT
// Linked into the test programs of mutants.py. The file SELVEDGE_REACHED gets a line when a test
// starts, and one when it ends: its time in seconds, whether it passed, and the changes that it
// reached.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

namespace {

class ReachedListener : public testing::EmptyTestEventListener {
 public:
  explicit ReachedListener(const char* path) : out_(path, std::ios::app) {}

  void OnTestStart(const testing::TestInfo& test) override {
    out_ << "start " << name(test) << std::endl;
  }

  void OnTestEnd(const testing::TestInfo& test) override {
    const testing::TestResult& result = *test.result();
    out_ << "end " << name(test) << ' ' << 1e-3 * static_cast<double>(result.elapsed_time()) << ' '
         << (result.Passed() ? 1 : 0);
    for (int i = 0; i < kSelvedgeMutants; ++i)
      if (selvedge_reached[i].exchange(false)) out_ << ' ' << i;
    out_ << std::endl;
  }

 private:
  static std::string name(const testing::TestInfo& test) {
    return std::string(test.test_suite_name()) + "." + test.name();
  }

  std::ofstream out_;
};

const bool kListens = [] {
  const char* path = std::getenv("SELVEDGE_REACHED");
  if (path != nullptr)
    testing::UnitTest::GetInstance()->listeners().Append(new ReachedListener(path));
  return path != nullptr;
}();

}  // namespace
