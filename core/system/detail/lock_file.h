// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

/// What FolderLock does in the same way on every system.
namespace selvedge::detail {

/// Writes the number of this process to the lock file, for the message of another process. Does
/// nothing where the disk is full.
void note_owner(int descriptor);

/// Throws std::invalid_argument: another `user`, whose number the file has, has the lock.
[[noreturn]] void refuse_second(const std::filesystem::path& file, const std::string& user);

/// Throws std::invalid_argument: the system gives this cause.
[[noreturn]] void refuse_folder(const std::filesystem::path& file, const std::string& cause);

}  // namespace selvedge::detail
