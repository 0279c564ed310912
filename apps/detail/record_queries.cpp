// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <selvedge/apps/detail/print.h>
#include <selvedge/apps/detail/record_queries.h>

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace selvedge {

void add_record_options(const Command& command, QueryRecorderConfig& config) {
  command.option("--record", config.prefix,
                 "Write the queries of the narrow phase and their exact answers to "
                 "PREFIX.point_triangle.csv and PREFIX.edge_edge.csv, or into this folder");
  command
      .option("--record-limit", config.limit,
              "Largest number of queries of each kind (default 100000; 0: all); beyond "
              "it, keeps every second, fourth, ... query")
      .range(std::size_t{0}, std::size_t{1'000'000'000});
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
  for (const std::string& name : methods.narrow_phases.names())
    methods.narrow_phases.add(
        name, methods.narrow_phases.at(name).wrapped([this](std::unique_ptr<NarrowPhase> method) {
          return make_recording(std::move(method), *recorder_);
        }));
}

RecordedRun::~RecordedRun() {
  if (!recorder_) return;
  try {
    write();
  } catch (const std::exception& error) {
    print_escaped(stderr, "warning: the recording could not be written: {}\n", error.what());
  }
}

void RecordedRun::write() {
  if (!recorder_) return;
  const std::vector<RecordedQueries> recorded = recorder_->write();
  recorder_.reset();
  for (const RecordedQueries& r : recorded)
    print_escaped(stderr, "recorded {} of {} queries, {} collide: {}\n", r.written, r.asked,
                  r.positives, r.file.string());
  if (recorded.empty()) print_escaped(stderr, "recorded nothing: no query was asked\n");
}

}  // namespace selvedge
