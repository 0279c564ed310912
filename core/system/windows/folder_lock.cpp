// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/descriptor.h>
#include <selvedge/core/system/detail/lock_file.h>
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/files.h>

#include <fcntl.h>
#include <io.h>

#include <cstdint>
#include <system_error>

namespace selvedge {

// The lock is the file opened for writing, which Windows allows one process. Others may read it.
FolderLock::FolderLock(const std::filesystem::path& folder, const std::string& user)
    : file_(folder / kFile) {
  std::error_code ignored;  // without the folder the file cannot be made
  std::filesystem::create_directories(folder, ignored);
  const HANDLE handle = CreateFileW(file_.c_str(), GENERIC_READ | GENERIC_WRITE, FILE_SHARE_READ,
                                    nullptr, OPEN_ALWAYS, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    const std::error_code cause = detail::last_error();
    if (cause.value() == ERROR_SHARING_VIOLATION) detail::refuse_second(file_, user);
    detail::refuse_folder(file_, cause.message());
  }
  descriptor_ = _open_osfhandle(reinterpret_cast<std::intptr_t>(handle), _O_BINARY);
  detail::note_owner(descriptor_);
}

FolderLock::~FolderLock() {
  detail::close_file(descriptor_);
  // Fails, as it should, if another process has the lock already.
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

}  // namespace selvedge
