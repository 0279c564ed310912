// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/record_queries.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace selvedge {

void add_record_options(CLI::App& command, QueryRecorderConfig& config) {
  command.add_option(
      "--record", config.prefix,
      "Write the queries that the narrow phase is asked, with their true answers, to "
      "PREFIX.point_triangle.csv and PREFIX.edge_edge.csv, or into this folder");
  command
      .add_option("--record-limit", config.limit,
                  "At most so many queries of each kind (default 100000; 0: all): every second, "
                  "fourth, ... one of those asked")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1'000'000'000}));
}

RecordedRun::RecordedRun(const QueryRecorderConfig& config) {
  if (config.prefix.empty()) return;
  try {
    recorder_.emplace(config);
  } catch (const std::system_error& error) {
    throw std::invalid_argument(std::string("--record: ") + error.what());
  }
}

RecordedRun::RecordedRun(const QueryRecorderConfig& config, Methods& methods)
    : RecordedRun(config) {
  if (!recorder_) return;
  for (auto& entry : methods.narrow_phases)
    entry.second = [make = entry.second, this](const NarrowPhaseConfig& c) {
      return make_recording(make(c), *recorder_);
    };
}

RecordedRun::~RecordedRun() {
  if (!recorder_) return;
  try {
    write();
  } catch (const std::exception& error) {
    fmt::print(stderr, "warning: the recording could not be written: {}\n", error.what());
  }
}

void RecordedRun::write() {
  if (!recorder_) return;
  const std::vector<RecordedQueries> recorded = recorder_->write();
  recorder_.reset();
  for (const RecordedQueries& r : recorded)
    fmt::print(stderr, "recorded {} of {} queries, {} collide: {}\n", r.written, r.asked,
               r.positives, r.file.string());
  if (recorded.empty()) fmt::print(stderr, "recorded nothing: no query was asked\n");
}

}  // namespace selvedge
