// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

/// Open files, as every operating system has them: numbers that a child process does not inherit.
/// Results below 0 are errors; errno has the cause.
namespace selvedge::detail {

enum class Opening {
  written,   ///< emptied, or made if it is missing; write only
  replaced,  ///< emptied, or made if it is missing
  kept,      ///< must be there
};

int open_file(const std::filesystem::path& file, Opening opening);
/// A file without a name in this folder, which vanishes once it is closed.
int open_nameless(const std::filesystem::path& folder);
int close_file(int descriptor);

std::ptrdiff_t write_next(int descriptor, const void* bytes, std::size_t count);
/// At a place, bytes from the start of the file.
std::ptrdiff_t write_at(int descriptor, const void* bytes, std::size_t count, std::uint64_t place);
std::ptrdiff_t read_at(int descriptor, void* bytes, std::size_t count, std::uint64_t place);

std::int64_t size_of(int descriptor);
int resize_file(int descriptor, std::uint64_t bytes);

/// Number of this process.
long process_number();

}  // namespace selvedge::detail
