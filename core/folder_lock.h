// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

namespace selvedge {

/// Keeps a folder for one process at a time, as long as it lives: an advisory lock (flock) on the
/// file `lock` in it, which is removed at the end. The system releases the lock when the process
/// dies; the file that is then left over keeps nobody out.
class FolderLock {
 public:
  /// Name of the file in the folder.
  static constexpr const char* kFile = "lock";

  /// Makes the folder if it is missing. `user` is what works in it, for messages: "run". Throws
  /// std::invalid_argument if another process has the lock, or the file cannot be made.
  FolderLock(const std::filesystem::path& folder, const std::string& user);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// One sentence if the file system has no locks (NFS and Lustre may be mounted so), so that
  /// nothing keeps a second process out; else empty.
  const std::string& warning() const { return warning_; }

 private:
  bool is_current() const;
  void note_process() const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string warning_;
};

}  // namespace selvedge
