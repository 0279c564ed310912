// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/processes.h>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#ifdef __linux__
#include <sched.h>
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <sstream>
#include <system_error>
#include <thread>
#include <utility>

extern char** environ;

namespace selvedge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(1);
constexpr double kLongestWait = 1e9;  // s; a clock's time must not overflow

Clock::time_point after(double seconds) {
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(
                            std::chrono::duration<double>(std::min(seconds, kLongestWait)));
}

double seconds_until(Clock::time_point deadline) {
  return std::chrono::duration<double>(deadline - Clock::now()).count();
}

[[noreturn]] void fail(int error, const char* action) {
  throw std::system_error(error, std::generic_category(), action);
}

/// waitpid that no signal interrupts: true once the process has ended.
bool has_ended(int process, int flags, ProcessEnd& end) {
  int status = 0;
  pid_t ended = -1;
  do ended = ::waitpid(process, &status, flags);
  while (ended < 0 && errno == EINTR);
  if (ended == 0) return false;
  if (ended == process) {
    end.by_signal = WIFSIGNALED(status);
    end.code = end.by_signal ? WTERMSIG(status) : WEXITSTATUS(status);
  }
  return true;
}

void die_with_parent() {
#ifdef __linux__
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

/// What a spawned program starts with.
class SpawnSettings {
 public:
  SpawnSettings() {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  void connect(int descriptor, int as) {
    posix_spawn_file_actions_adddup2(&actions_, descriptor, as);
  }
  void discard(int descriptor) {
    const int flags = descriptor == STDIN_FILENO ? O_RDONLY : O_WRONLY;
    posix_spawn_file_actions_addopen(&actions_, descriptor, "/dev/null", flags, 0);
  }
  /// Its own process group, so that it is killed together with its children.
  void separate() {
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes_, 0);
  }
  /// Returns 0 or the error.
  int spawn(const std::vector<std::string>& words, pid_t& child) const {
    std::vector<char*> pointers;
    for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
    pointers.push_back(nullptr);
    return posix_spawnp(&child, pointers[0], &actions_, &attributes_, pointers.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

}  // namespace

std::string signal_name(int signal) { return ::strsignal(signal); }

std::optional<ProcessEnd> ChildProcess::wait(double seconds) const {
  const auto deadline = after(seconds);
  ProcessEnd end;
  while (!has_ended(id_, WNOHANG, end)) {
    if (Clock::now() >= deadline) return {};
    std::this_thread::sleep_for(kLookEvery);
  }
  return end;
}

ProcessEnd ChildProcess::wait() const {
  ProcessEnd end;
  has_ended(id_, 0, end);
  return end;
}

ProcessEnd ChildProcess::kill() const {
  ::kill(id_, SIGKILL);
  return wait();
}

double ChildProcess::processor_s() const {
#ifdef __linux__
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(id_, &clock) == 0 && ::clock_gettime(clock, &used) == 0)
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
#endif
  return std::numeric_limits<double>::quiet_NaN();
}

// ---- a copy of this process

ChildProcess run_in_copy(const std::function<int()>& task) {
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) fail(errno, "no process could be started");
  if (child > 0) return ChildProcess(child);
  die_with_parent();
  if (::getppid() != parent) ::_exit(EXIT_FAILURE);  // it died before
  const int code = task();
  std::fflush(stderr);
  ::_exit(code);  // buffered output belongs to the parent
}

std::size_t running_threads() {
  std::error_code error;
  const std::filesystem::directory_iterator tasks("/proc/self/task", error);
  if (error) return 0;
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

void redirect_output(const std::filesystem::path& log) {
  constexpr mode_t readable = 0644;
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, readable);
  if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  if (file >= 0) ::dup2(file, STDERR_FILENO);
}

bool pin_to_core([[maybe_unused]] int core) {
#ifdef __linux__
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(core, &cores);
  return ::sched_setaffinity(0, sizeof cores, &cores) == 0;
#else
  return false;
#endif
}

Pipe::Pipe() {
  if (::pipe2(ends_, O_CLOEXEC) != 0) fail(errno, "no pipe could be made");
}

Pipe::~Pipe() {
  close(0);
  close(1);
}

void Pipe::close(int end) {
  if (ends_[end] >= 0) ::close(std::exchange(ends_[end], -1));
}

bool Pipe::write(std::string_view bytes) {
  close(0);
  while (!bytes.empty()) {
    const ssize_t written = ::write(ends_[1], bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Pipe::ReadEnd Pipe::read_all(double seconds, std::size_t limit, std::string& bytes) {
  constexpr double most_s = 60.0;  // of one wait
  constexpr std::size_t capacity = std::size_t{1} << 16;
  close(1);
  const auto deadline = after(seconds);
  std::string buffer(capacity, '\0');
  while (true) {
    const double left = seconds_until(deadline);
    if (left <= 0.0) return ReadEnd::late;
    pollfd state{ends_[0], POLLIN, 0};
    if (::poll(&state, 1, static_cast<int>(1e3 * std::min(left, most_s)) + 1) <= 0) continue;
    const ssize_t count = ::read(ends_[0], buffer.data(), buffer.size());
    if (count == 0) return ReadEnd::complete;
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ReadEnd::failed;
    if (bytes.size() + static_cast<std::size_t>(count) > limit) return ReadEnd::too_much;
    bytes.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

// ---- another program

ChildResult run_program(const std::vector<std::string>& words, const ChildConfig& config) try {
  using End = ChildResult::End;
  ChildResult result;
  Pipe pipe;
  SpawnSettings settings;
  settings.discard(STDIN_FILENO);
  settings.connect(pipe.writing_end(), STDOUT_FILENO);
  settings.discard(STDERR_FILENO);
  settings.separate();
  pid_t id = 0;
  result.code = settings.spawn(words, id);
  if (result.code != 0) return result;
  const ChildProcess child(id);
  const auto deadline = after(config.timeout);
  const Pipe::ReadEnd read = pipe.read_all(config.timeout, config.output_limit, result.output);
  std::optional<ProcessEnd> end;
  if (read != Pipe::ReadEnd::late && read != Pipe::ReadEnd::too_much)
    end = child.wait(seconds_until(deadline));
  if (!end) {
    ::kill(-id, SIGKILL);
    child.kill();
    result.end = read == Pipe::ReadEnd::too_much ? End::too_much_output : End::timed_out;
    return result;
  }
  result.end = end->by_signal ? End::signalled : End::exited;
  result.code = std::max(end->code, 0);  // where it is unknown, the output decides
  return result;
} catch (const std::system_error& error) {
  ChildResult result;
  result.code = error.code().value();
  return result;
}

FedProgram::FedProgram(const std::vector<std::string>& words) {
  // A pair of sockets: when the reader has died, a write to a socket can return an error, whereas a
  // write to a pipe raises a signal that kills this process.
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    fail(errno, "cannot make a socket");
  SpawnSettings settings;
  settings.connect(ends[1], STDIN_FILENO);
  settings.discard(STDOUT_FILENO);
  const int error = settings.spawn(words, process_);
  ::close(ends[1]);
  socket_ = ends[0];
  if (error == 0) return;
  ::close(socket_);
  fail(error, "cannot start the program");
}

FedProgram::~FedProgram() {
  if (process_ >= 0) finish();
}

bool FedProgram::write(const void* bytes, std::size_t count) {
  for (const char* at = static_cast<const char*>(bytes); count > 0;) {
    const ssize_t sent = ::send(socket_, at, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

ProcessEnd FedProgram::finish() {
  ::close(std::exchange(socket_, -1));
  return ChildProcess(std::exchange(process_, -1)).wait();
}

bool program_is_there(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const auto program = std::filesystem::path(folder.empty() ? "." : folder) / name;
    std::error_code ignored;  // a file that cannot be inspected cannot be executed
    if (std::filesystem::is_regular_file(program, ignored) && ::access(program.c_str(), X_OK) == 0)
      return true;
  }
  return false;
}

void limit_this_process([[maybe_unused]] std::uint64_t memory, std::uint64_t seconds) {
  die_with_parent();
  const auto limit = [](auto resource, rlim_t value) {
    const rlimit both{value, value};
    ::setrlimit(resource, &both);
  };
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, seconds);
#ifndef __SANITIZE_ADDRESS__  // the address sanitizer reserves terabytes
  limit(RLIMIT_AS, memory);
#endif
}

}  // namespace selvedge
