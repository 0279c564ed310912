// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/windows.h>
#include <selvedge/core/system/internal/libraries.h>

#include <stdexcept>
#include <string>

namespace selvedge {
namespace {

[[noreturn]] void fail(const char* name) {
  throw std::runtime_error(std::string(name) + ": " + detail::last_error().message());
}

std::filesystem::path file_of(HMODULE module) {
  constexpr DWORD longest = 32768;  // characters of a path, by the documentation of Windows
  std::wstring name(longest, L'\0');
  name.resize(GetModuleFileNameW(module, name.data(), longest));
  return name;
}

}  // namespace

LoadedLibrary::LoadedLibrary(const char* name) : library_(LoadLibraryA(name)) {
  if (!library_) fail(name);
}

void* LoadedLibrary::address_of(const char* name) const {
  const auto address = GetProcAddress(static_cast<HMODULE>(library_), name);
  if (!address) fail(name);
  return reinterpret_cast<void*>(address);
}

std::filesystem::path file_of_code(const void* code) {
  constexpr DWORD unowned_by_address =
      GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS | GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
  HMODULE module = nullptr;
  const auto* address = static_cast<const wchar_t*>(code);
  return GetModuleHandleExW(unowned_by_address, address, &module) != 0 ? file_of(module)
                                                                       : std::filesystem::path();
}

std::filesystem::path running_program() { return file_of(nullptr); }

}  // namespace selvedge
