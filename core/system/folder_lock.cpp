// SPDX-License-Identifier: MIT
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

constexpr mode_t kReadable = 0666;  // less the process's umask

/// " (process 17)" if the file says so.
std::string owner_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  long process = 0;
  return in >> process ? " (process " + std::to_string(process) + ")" : "";
}

int lock(int descriptor) {
  int result = 0;
  do {
    result = ::flock(descriptor, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  return result;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::string& user)
    : file_(folder / kFile) {
  std::error_code ignored;  // without the folder the file cannot be made
  std::filesystem::create_directories(folder, ignored);
  // Its owner may remove the file between open and lock. A lock on that file would keep nobody out.
  while (!is_current()) {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kReadable);
    if (descriptor_ < 0)
      throw std::invalid_argument(file_.string() + ": cannot be made: " + std::strerror(errno) +
                                  "; name a folder that can be written with --out");
    if (lock(descriptor_) == 0) continue;
    const int cause = errno;
    ::close(std::exchange(descriptor_, -1));
    if (cause == EWOULDBLOCK)
      throw std::invalid_argument(folder.string() + ": another " + user + owner_in(file_) +
                                  " is at work in this folder; wait for it, or name another "
                                  "folder with --out");
    warning_ = folder.string() + ": its file system has no locks (" + std::strerror(cause) +
               "), so nothing keeps a second " + user + " out of this folder";
    return;
  }
  note_process();
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  ::unlink(file_.c_str());  // before the lock is released, so that it is still ours
  ::close(descriptor_);
}

// Whether the locked file is the one that others find under its name.
bool FolderLock::is_current() const {
  struct stat locked {
  }, named{};
  return descriptor_ >= 0 && ::fstat(descriptor_, &locked) == 0 &&
         ::stat(file_.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
         locked.st_ino == named.st_ino;
}

// For the message of another process, which goes without it where the disk is full.
void FolderLock::note_process() const {
  const std::string text = std::to_string(::getpid()) + "\n";
  if (::ftruncate(descriptor_, 0) != 0) return;
  if (::pwrite(descriptor_, text.data(), text.size(), 0) < 0) return;
}

}  // namespace selvedge
