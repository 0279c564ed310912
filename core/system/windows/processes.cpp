// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/processes.h>

#include <fcntl.h>
#include <io.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

namespace selvedge {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(1);
constexpr double kLongestWait = 1e6;  // s; the system counts milliseconds in 32 bits
constexpr UINT kKilled = 1;           // exit code of what this process kills

DWORD milliseconds(double seconds) {
  return static_cast<DWORD>(1e3 * std::clamp(seconds, 0.0, kLongestWait));
}

/// A process by its number, as long as this object lives.
class Process {
 public:
  explicit Process(int id)
      : handle_(OpenProcess(SYNCHRONIZE | PROCESS_QUERY_LIMITED_INFORMATION | PROCESS_TERMINATE, 0,
                            static_cast<DWORD>(id))) {}
  ~Process() {
    if (handle_ != nullptr) CloseHandle(handle_);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  HANDLE handle() const { return handle_; }

 private:
  HANDLE handle_;
};

/// A word of a command line, as CommandLineToArgvW and the C library read it: in quotes, with
/// backslashes doubled before a quote.
std::wstring quoted(const std::string& word) {
  std::wstring text = L"\"";
  std::size_t backslashes = 0;
  for (const wchar_t c : std::filesystem::path(word).wstring()) {
    if (c == L'"') text.append(backslashes + 1, L'\\');
    backslashes = c == L'\\' ? backslashes + 1 : 0;
    text += c;
  }
  return text.append(backslashes, L'\\') + L'"';
}

std::wstring command_line(const std::vector<std::string>& words) {
  std::wstring line;
  for (const std::string& word : words) line += (line.empty() ? L"" : L" ") + quoted(word);
  return line;
}

/// A copy of a handle, which children inherit, or the device that discards everything.
class Inherited {
 public:
  explicit Inherited(HANDLE handle) {
    const HANDLE self = GetCurrentProcess();
    DuplicateHandle(self, handle, self, &handle_, 0, TRUE, DUPLICATE_SAME_ACCESS);
  }
  Inherited() {
    SECURITY_ATTRIBUTES inherit{sizeof inherit, nullptr, TRUE};
    handle_ = CreateFileW(L"NUL", GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE,
                          &inherit, OPEN_EXISTING, 0, nullptr);
  }
  ~Inherited() { CloseHandle(handle_); }
  Inherited(const Inherited&) = delete;
  Inherited& operator=(const Inherited&) = delete;

  HANDLE handle() const { return handle_; }

 private:
  HANDLE handle_ = INVALID_HANDLE_VALUE;
};

HANDLE handle_of(int descriptor) { return reinterpret_cast<HANDLE>(_get_osfhandle(descriptor)); }

/// Starts a program, which waits until resume(). False if it cannot be started.
bool start(const std::vector<std::string>& words, const Inherited& input, const Inherited& output,
           PROCESS_INFORMATION& started) {
  const Inherited nowhere;
  STARTUPINFOW settings{};
  settings.cb = sizeof settings;
  settings.dwFlags = STARTF_USESTDHANDLES;
  settings.hStdInput = input.handle();
  settings.hStdOutput = output.handle();
  settings.hStdError = nowhere.handle();
  std::wstring line = command_line(words);
  return CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE,
                        CREATE_SUSPENDED | CREATE_NO_WINDOW, nullptr, nullptr, &settings,
                        &started) != 0;
}

void resume(const PROCESS_INFORMATION& started) {
  ResumeThread(started.hThread);
  CloseHandle(started.hThread);
}

/// A program and its children.
class Job {
 public:
  explicit Job(HANDLE process) : job_(CreateJobObjectW(nullptr, nullptr)) {
    AssignProcessToJobObject(job_, process);
  }
  ~Job() { CloseHandle(job_); }
  Job(const Job&) = delete;
  Job& operator=(const Job&) = delete;

  void kill() const { TerminateJobObject(job_, kKilled); }

 private:
  HANDLE job_;
};

/// nullopt if it still runs after this time.
std::optional<ProcessEnd> wait_for(HANDLE process, DWORD most) {
  if (WaitForSingleObject(process, most) == WAIT_TIMEOUT) return {};
  DWORD code = 0;
  ProcessEnd end;
  if (GetExitCodeProcess(process, &code) == 0) return end;
  // An exception that nothing catches ends a process with its code, such as 0xC0000005.
  end.by_signal = code >= 0xC0000000;
  end.code = static_cast<int>(code);
  return end;
}

}  // namespace

std::string signal_name(int signal) {
  char name[32];
  std::snprintf(name, sizeof name, "exception 0x%08X", static_cast<unsigned>(signal));
  return name;
}

std::optional<ProcessEnd> ChildProcess::wait(double seconds) const {
  return wait_for(Process(id_).handle(), milliseconds(seconds));
}

ProcessEnd ChildProcess::wait() const { return *wait_for(Process(id_).handle(), INFINITE); }

ProcessEnd ChildProcess::kill() const {
  const Process process(id_);
  TerminateProcess(process.handle(), kKilled);
  return *wait_for(process.handle(), INFINITE);
}

double ChildProcess::processor_s() const {
  FILETIME begin, end, kernel, user;
  if (GetProcessTimes(Process(id_).handle(), &begin, &end, &kernel, &user) == 0)
    return std::numeric_limits<double>::quiet_NaN();
  const auto seconds = [](const FILETIME& time) {  // from units of 100 ns
    return 1e-7 * (4294967296.0 * time.dwHighDateTime + time.dwLowDateTime);
  };
  return seconds(kernel) + seconds(user);
}

// ---- a copy of this process

ChildProcess run_in_copy(const std::function<int()>&) {
  throw std::runtime_error(
      "this command needs copies of its process, which Windows does not make; use it on another "
      "system");
}

std::size_t running_threads() { return 0; }

void redirect_output(const std::filesystem::path& log) {
  std::freopen("NUL", "w", stdout);
  const int file = _wopen(log.c_str(), _O_WRONLY | _O_CREAT | _O_TRUNC | _O_BINARY, 0600);
  if (file >= 0) _dup2(file, _fileno(stderr));
}

bool pin_to_core(int core) {
  return core < std::numeric_limits<DWORD_PTR>::digits &&
         SetProcessAffinityMask(GetCurrentProcess(), DWORD_PTR{1} << core) != 0;
}

Pipe::Pipe() {
  constexpr unsigned capacity = 1U << 16;
  if (_pipe(ends_, capacity, _O_BINARY | _O_NOINHERIT) != 0)
    throw std::system_error(errno, std::generic_category(), "no pipe could be made");
}

Pipe::~Pipe() {
  close(0);
  close(1);
}

void Pipe::close(int end) {
  if (ends_[end] >= 0) _close(std::exchange(ends_[end], -1));
}

bool Pipe::write(std::string_view bytes) {
  constexpr std::size_t most = std::size_t{1} << 20;
  close(0);
  while (!bytes.empty()) {
    const int written =
        _write(ends_[1], bytes.data(), static_cast<unsigned>(std::min(bytes.size(), most)));
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Pipe::ReadEnd Pipe::read_all(double seconds, std::size_t limit, std::string& bytes) {
  close(1);
  const HANDLE pipe = handle_of(ends_[0]);
  const auto deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(
                         std::chrono::duration<double>(std::min(seconds, kLongestWait)));
  std::string buffer;
  while (Clock::now() < deadline) {
    DWORD ready = 0;
    if (PeekNamedPipe(pipe, nullptr, 0, nullptr, &ready, nullptr) == 0)
      return GetLastError() == ERROR_BROKEN_PIPE ? ReadEnd::complete : ReadEnd::failed;
    if (ready == 0) {
      std::this_thread::sleep_for(kLookEvery);
      continue;
    }
    if (bytes.size() + ready > limit) return ReadEnd::too_much;
    buffer.resize(ready);
    DWORD count = 0;
    if (ReadFile(pipe, buffer.data(), ready, &count, nullptr) == 0) return ReadEnd::failed;
    bytes.append(buffer.data(), count);
  }
  return ReadEnd::late;
}

// ---- another program

ChildResult run_program(const std::vector<std::string>& words, const ChildConfig& config) {
  using End = ChildResult::End;
  ChildResult result;
  Pipe pipe;
  PROCESS_INFORMATION started{};
  if (!start(words, Inherited(), Inherited(handle_of(pipe.writing_end())), started)) {
    result.code = detail::last_error().default_error_condition().value();
    return result;
  }
  const Job job(started.hProcess);
  resume(started);
  const auto begin = Clock::now();
  const Pipe::ReadEnd read = pipe.read_all(config.timeout, config.output_limit, result.output);
  const double used = std::chrono::duration<double>(Clock::now() - begin).count();
  std::optional<ProcessEnd> end;
  if (read != Pipe::ReadEnd::late && read != Pipe::ReadEnd::too_much)
    end = wait_for(started.hProcess, milliseconds(config.timeout - used));
  if (end) {
    result.end = end->by_signal ? End::signalled : End::exited;
    result.code = end->code;
  } else {
    job.kill();
    result.end = read == Pipe::ReadEnd::too_much ? End::too_much_output : End::timed_out;
  }
  CloseHandle(started.hProcess);
  return result;
}

FedProgram::FedProgram(const std::vector<std::string>& words) {
  constexpr unsigned capacity = 1U << 16;
  int ends[2];
  if (_pipe(ends, capacity, _O_BINARY | _O_NOINHERIT) != 0)
    throw std::system_error(errno, std::generic_category(), "cannot make a pipe");
  PROCESS_INFORMATION started{};
  const bool is_started = start(words, Inherited(handle_of(ends[0])), Inherited(), started);
  _close(ends[0]);
  socket_ = ends[1];
  if (!is_started) {
    const std::error_code error = detail::last_error();
    _close(socket_);
    throw std::system_error(error, "cannot start the program");
  }
  resume(started);
  process_ = static_cast<int>(started.dwProcessId);
  CloseHandle(started.hProcess);
}

FedProgram::~FedProgram() {
  if (process_ >= 0) finish();
}

bool FedProgram::write(const void* bytes, std::size_t count) {
  constexpr std::size_t most = std::size_t{1} << 20;
  for (const char* at = static_cast<const char*>(bytes); count > 0;) {
    const int sent = _write(socket_, at, static_cast<unsigned>(std::min(count, most)));
    if (sent <= 0) return false;
    at += sent;
    count -= static_cast<std::size_t>(sent);
  }
  return true;
}

ProcessEnd FedProgram::finish() {
  const Process process(std::exchange(process_, -1));  // before it can end
  _close(std::exchange(socket_, -1));
  return *wait_for(process.handle(), INFINITE);
}

bool program_is_there(const std::string& name) {
  return SearchPathW(nullptr, std::filesystem::path(name).c_str(), L".exe", 0, nullptr, nullptr) !=
         0;
}

// The job that starts this process ends it with its parent.
void limit_this_process(std::uint64_t memory, std::uint64_t seconds) {
  const HANDLE job = CreateJobObjectW(nullptr, nullptr);
  JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
  limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_PROCESS_MEMORY |
                                            JOB_OBJECT_LIMIT_PROCESS_TIME |
                                            JOB_OBJECT_LIMIT_DIE_ON_UNHANDLED_EXCEPTION;
  limits.BasicLimitInformation.PerProcessUserTimeLimit.QuadPart =
      static_cast<LONGLONG>(seconds) * 10'000'000;  // units of 100 ns
  limits.ProcessMemoryLimit = memory;
  SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
  AssignProcessToJobObject(job, GetCurrentProcess());
}

}  // namespace selvedge
