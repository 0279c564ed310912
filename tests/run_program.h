// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

/// Runs the program selvedge in tests: each test has a folder with a small scene, and the output of
/// the program is captured. Included only by tests that define SELVEDGE_PROGRAM.
namespace selvedge::testing {

namespace fs = std::filesystem;
using Json = nlohmann::json;

inline const std::string program = SELVEDGE_PROGRAM;

inline std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Whether the shell finds a program of this name.
inline bool has_program(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

/// Exit code and output of a run of the program.
struct Outcome {
  int code = -1;
  std::string out, err;
};

#define EXPECT_SAYS(text, part) \
  EXPECT_NE((text).find(part), std::string::npos) << "it says: " << (text)

/// Expects the result of wrong input: exit code 2 and one message on one line.
#define EXPECT_REFUSED(outcome, part)                                      \
  do {                                                                     \
    const ::selvedge::testing::Outcome refused = outcome;                  \
    EXPECT_EQ(refused.code, 2) << refused.out << refused.err;              \
    EXPECT_SAYS(refused.err, part);                                        \
    EXPECT_EQ(refused.err.rfind("selvedge: ", 0), 0u) << refused.err;      \
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) \
        << "more than a line: " << refused.err;                            \
    EXPECT_EQ(refused.out, "");                                            \
  } while (false)

/// Each test has its own folder, in which the program runs, with a small scene.
class Program : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              ("selvedge_cli_" + std::to_string(getpid()) + "_" + info->name());
    fs::create_directories(folder_);
    write("small.json", R"({
      "geometry": [{"name": "cloth", "size": [0.5, 0.5], "cells": [9, 9], "transformation": {"translation": [0, 0, 0.31]}}],
      "obstacles": [{"name": "ball", "shape": {"type": "sphere", "radius": 0.3, "resolution": 12}}],
      "time": {"frames": 3}})");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  /// Runs `selvedge arguments` through the shell, after the command `before` (such as a limit).
  Outcome run(const std::string& arguments, const std::string& before = "") const {
    const std::string command = "cd '" + folder_.string() + "' && " + before + " '" + program +
                                "' " + arguments + " >stdout.txt 2>stderr.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(folder_ / "stdout.txt"),
            content(folder_ / "stderr.txt")};
  }

  /// The same for the small scene without pictures; writes into the folder `out`.
  Outcome run_small(const std::string& out, const std::string& more = "",
                    const std::string& before = "") const {
    return run("run small.json --no-pictures --out " + out + " " + more, before);
  }

  Json result(const std::string& out) const {
    return Json::parse(content(folder_ / out / "result.json"), nullptr, false);
  }

  std::string frame(const std::string& out, int number) const {
    return content(folder_ / out / "frames" / ("cloth_0000" + std::to_string(number) + ".ply"));
  }

  std::size_t count(const std::string& out, const std::string& stem) const {
    std::size_t n = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / out))
      n += entry.path().filename().string().rfind(stem, 0) == 0;
    return n;
  }

  bool exists(const std::string& name) const { return fs::exists(folder_ / name); }

  fs::path folder_;
};

}  // namespace selvedge::testing
