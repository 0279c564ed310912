// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace selvedge {

/// How a process ended.
struct ProcessEnd {
  bool by_signal = false;
  int code = -1;  ///< exit status, or number of the signal; -1: unknown
};

/// Name of a signal, such as "Segmentation fault".
std::string signal_name(int signal);

/// A child of this process. Where this process ignores its children, their exit status is unknown.
class ChildProcess {
 public:
  explicit ChildProcess(int id) : id_(id) {}

  /// nullopt if it still runs after this many seconds.
  std::optional<ProcessEnd> wait(double seconds) const;
  ProcessEnd wait() const;
  /// Kills it, waits for its end and returns that.
  ProcessEnd kill() const;
  /// Processor time that it has used, s; NaN where the system does not tell, or after its end.
  double processor_s() const;

 private:
  int id_;
};

// ---- a copy of this process

/// Starts a copy of this process that runs `task` and exits with the code that it returns, or dies
/// with this process. An exception leaves the function in the copy. The copy has the calling thread
/// only: locks that other threads hold would never be released. Throws std::system_error if the
/// system refuses a process, std::runtime_error on Windows, which has no such copies.
ChildProcess run_in_copy(const std::function<int()>& task);

/// Number of threads of this process; 0 where the system does not tell.
std::size_t running_threads();

/// Sends standard error to a file and standard output nowhere.
void redirect_output(const std::filesystem::path& log);

/// Keeps this process on one core. False if there is no such core.
bool pin_to_core(int core);

/// Bytes from one process to another: one of them writes, the other reads.
class Pipe {
 public:
  enum class ReadEnd { complete, late, too_much, failed };

  /// Throws std::system_error if the system refuses a pipe.
  Pipe();
  ~Pipe();
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  /// Descriptor for a program that writes.
  int writing_end() const { return ends_[1]; }
  /// False if the reader is gone.
  bool write(std::string_view bytes);
  /// Appends all that the other process writes until it ends, for at most `seconds` and `limit`
  /// bytes.
  ReadEnd read_all(double seconds, std::size_t limit, std::string& bytes);

 private:
  void close(int end);

  int ends_[2];
};

// ---- another program

/// Limits of a program.
struct ChildConfig {
  double timeout = 30.0;         ///< s; the program is killed when it runs longer
  std::size_t output_limit = 0;  ///< bytes; the program is killed when it writes more
};

/// How a program ended.
struct ChildResult {
  enum class End { exited, signalled, timed_out, too_much_output, not_started };
  End end = End::not_started;
  int code = 0;        ///< exit status, signal number, or errno when not started
  std::string output;  ///< its standard output
};

/// Runs a program until it exits, or kills it and its children. Never waits longer than the
/// timeout. Safe in a program with threads: the child is spawned, not forked.
ChildResult run_program(const std::vector<std::string>& words, const ChildConfig& config);

/// A program that reads what this process writes, from its standard input; its standard output is
/// discarded.
class FedProgram {
 public:
  /// `words` are the program and its arguments. Throws std::system_error if it cannot be started.
  explicit FedProgram(const std::vector<std::string>& words);
  /// Waits for its end.
  ~FedProgram();
  FedProgram(const FedProgram&) = delete;
  FedProgram& operator=(const FedProgram&) = delete;

  /// False if the program has stopped reading.
  bool write(const void* bytes, std::size_t count);
  /// Ends its input and waits for its end.
  ProcessEnd finish();

 private:
  int socket_ = -1, process_ = -1;
};

/// True if the folders of PATH have a program of this name.
bool program_is_there(const std::string& name);

/// Lets this process die with its parent, without a core dump, when it needs more memory (bytes) or
/// processor time (s).
void limit_this_process(std::uint64_t memory, std::uint64_t seconds);

}  // namespace selvedge
