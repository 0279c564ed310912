// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/lock_file.h>
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace selvedge {
namespace {

constexpr mode_t kReadable = 0666;  // less the process's umask

int lock(int descriptor) {
  int result = 0;
  do {
    result = ::flock(descriptor, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  return result;
}

// Whether the locked file is the one that others find under its name.
bool is_current(int descriptor, const std::filesystem::path& file) {
  struct stat locked {
  }, named{};
  return descriptor >= 0 && ::fstat(descriptor, &locked) == 0 &&
         ::stat(file.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
         locked.st_ino == named.st_ino;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::string& user)
    : file_(folder / kFile) {
  std::error_code ignored;  // without the folder the file cannot be made
  std::filesystem::create_directories(folder, ignored);
  // Its owner may remove the file between open and lock. A lock on that file would keep nobody out.
  while (!is_current(descriptor_, file_)) {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kReadable);
    if (descriptor_ < 0) detail::refuse_folder(file_, std::strerror(errno));
    if (lock(descriptor_) == 0) continue;
    const int cause = errno;
    ::close(std::exchange(descriptor_, -1));
    if (cause == EWOULDBLOCK) detail::refuse_second(file_, user);
    warning_ = folder.string() + ": its file system has no locks (" + std::strerror(cause) +
               "), so nothing keeps a second " + user + " out of this folder";
    return;
  }
  detail::note_owner(descriptor_);
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  ::unlink(file_.c_str());  // before the lock is released, so that it is still ours
  ::close(descriptor_);
}

}  // namespace selvedge
