// SPDX-License-Identifier: MIT
#pragma once

#include <selvedge/apps/command_line.h>

#include <selvedge/narrowphase/query_file.h>
#include <selvedge/scene/methods.h>

#include <optional>

namespace selvedge {

/// The options --record and --record-limit.
void add_record_options(const Command& command, QueryRecorderConfig& config);

/// A recording; does nothing if `config` names no file. A run that fails keeps its recorded
/// queries.
class RecordedRun {
 public:
  explicit RecordedRun(const QueryRecorderConfig& config);
  /// Records every narrow phase that `methods` creates after this call.
  RecordedRun(const QueryRecorderConfig& config, Methods& methods);
  ~RecordedRun();
  RecordedRun(const RecordedRun&) = delete;
  RecordedRun& operator=(const RecordedRun&) = delete;

  /// Null if nothing is recorded.
  QueryRecorder* recorder() { return recorder_ ? &*recorder_ : nullptr; }
  /// Writes the files and reports them on the error stream.
  void write();

 private:
  std::optional<QueryRecorder> recorder_;
};

}  // namespace selvedge
