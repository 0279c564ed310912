// SPDX-License-Identifier: MIT
#include <selvedge/bodies/detail/child_process.h>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

extern char** environ;

namespace selvedge::detail {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kReadSize = std::size_t{1} << 16;  // bytes, the capacity of a pipe
constexpr auto kWaitStep = std::chrono::milliseconds(1);

class Descriptor {
 public:
  explicit Descriptor(int value = -1) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (value_ >= 0) ::close(value_);
    value_ = -1;
  }
  int value() const { return value_; }

 private:
  int value_;
};

// Environment of the child: output into the pipe, empty input, errors discarded.
class SpawnSettings {
 public:
  explicit SpawnSettings(int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&actions_, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_init(&attributes_);
    // Its own process group, so that it is killed together with its children.
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes_, 0);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  int spawn(const std::vector<std::string>& arguments, pid_t& child) const {
    std::vector<char*> pointers;
    for (const std::string& a : arguments) pointers.push_back(const_cast<char*>(a.c_str()));
    pointers.push_back(nullptr);
    return posix_spawnp(&child, pointers[0], &actions_, &attributes_, pointers.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

int milliseconds_until(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
  return static_cast<int>(std::clamp<std::int64_t>(left.count() + 1, 0, 60'000));
}

// Reads until the child closes its end. Sets result.end if the child has to be killed.
bool read_output(int pipe, Clock::time_point deadline, std::size_t limit, ChildResult& result) {
  std::string buffer(kReadSize, '\0');
  while (true) {
    if (Clock::now() >= deadline) return result.end = ChildResult::End::timed_out, false;
    pollfd state{pipe, POLLIN, 0};
    if (::poll(&state, 1, milliseconds_until(deadline)) <= 0) continue;
    const ssize_t n = ::read(pipe, buffer.data(), buffer.size());
    if (n == 0) return true;
    if (n < 0) {
      if (errno == EINTR) continue;
      return true;
    }
    if (result.output.size() + static_cast<std::size_t>(n) > limit)
      return result.end = ChildResult::End::too_much_output, false;
    result.output.append(buffer.data(), static_cast<std::size_t>(n));
  }
}

void take_status(int status, ChildResult& result) {
  const bool signalled = WIFSIGNALED(status);
  result.end = signalled ? ChildResult::End::signalled : ChildResult::End::exited;
  result.code = signalled ? WTERMSIG(status) : WEXITSTATUS(status);
}

bool wait_for_end(pid_t child, Clock::time_point deadline, ChildResult& result) {
  while (true) {
    int status = 0;
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return take_status(status, result), true;
    // A program that ignores SIGCHLD cannot learn the exit status; the output then decides.
    if (ended < 0 && errno == ECHILD) return result.end = ChildResult::End::exited, true;
    if (Clock::now() >= deadline) return result.end = ChildResult::End::timed_out, false;
    std::this_thread::sleep_for(kWaitStep);
  }
}

void kill_child(pid_t child) {
  ::kill(-child, SIGKILL);
  ::kill(child, SIGKILL);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments, const ChildConfig& config) {
  ChildResult result;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return result.code = errno, result;
  const Descriptor read_end(ends[0]);
  Descriptor write_end(ends[1]);
  pid_t child = 0;
  result.code = SpawnSettings(write_end.value()).spawn(arguments, child);
  if (result.code != 0) return result;
  write_end.close();
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(config.timeout));
  const bool ended = read_output(read_end.value(), deadline, config.output_limit, result) &&
                     wait_for_end(child, deadline, result);
  if (!ended) kill_child(child);
  return result;
}

}  // namespace selvedge::detail
