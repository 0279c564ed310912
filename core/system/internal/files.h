// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace selvedge {

/// Writes a file that appears under its final name only once it is complete. Bytes go to a
/// temporary file in the same folder, whose name ends in `.partial` and the process id, so two
/// processes that write the same file do not interfere. commit() renames it; without commit() the
/// destructor deletes it. An existing target that is not a regular file (a pipe, a device) is
/// written directly. Every failure throws std::system_error, whose message names the file and whose
/// code is the cause.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path file);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* bytes, std::size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();

 private:
  void flush();
  void write_through(const std::byte* begin, std::size_t count);
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path file_, partial_;
  std::vector<std::byte> buffer_;
  int descriptor_ = -1;
  bool committed_ = false;
};

/// True if this process may make files in a folder.
bool can_write_in(const std::filesystem::path& folder);

/// A file that is read and written at any place. Every failure throws std::system_error, whose
/// message names the file.
class OpenFile {
 public:
  /// What happens to the file that has the name.
  enum class Former { replaced, kept };

  /// `kept`: the file must be there.
  OpenFile(const std::filesystem::path& file, Former former);
  /// A file without a name in this folder, which vanishes with this object or the process.
  static OpenFile nameless(const std::filesystem::path& folder);
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void write(const void* bytes, std::size_t count, std::uint64_t place);
  /// Returns the number of bytes read, which is less than `count` at the end of the file only.
  std::size_t read(void* bytes, std::size_t count, std::uint64_t place) const;
  std::uint64_t size() const;
  void resize(std::uint64_t bytes);

 private:
  OpenFile(int descriptor, std::string name) : descriptor_(descriptor), name_(std::move(name)) {}
  [[noreturn]] void fail(const char* action) const;

  int descriptor_;
  std::string name_;  // for messages
};

/// Keeps a folder for one process at a time, as long as it lives: a lock on the file `lock` in it
/// (POSIX: flock; Windows: nobody else may write it), which is removed at the end. The system
/// releases the lock when the process dies; the file that is then left over keeps nobody out.
class FolderLock {
 public:
  /// Name of the file in the folder.
  static constexpr const char* kFile = "lock";

  /// Makes the folder if it is missing. `user` names the work in it for messages, such as "run".
  /// Throws std::invalid_argument if another process has the lock, or the file cannot be made.
  FolderLock(const std::filesystem::path& folder, const std::string& user);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// One sentence if the file system has no locks (NFS and Lustre may be mounted so), so that
  /// nothing keeps a second process out; else empty.
  const std::string& warning() const { return warning_; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::string warning_;
};

}  // namespace selvedge
