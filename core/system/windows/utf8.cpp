// SPDX-License-Identifier: MIT
#include <selvedge/core/system/detail/windows.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cwchar>

namespace {

/// Bytes of the character that starts with this one; 0 if none does.
std::size_t length_of(unsigned char first) {
  if (first < 0x80) return 1;
  return first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
}

constexpr std::size_t kInvalid = static_cast<std::size_t>(-1);
constexpr std::size_t kIncomplete = static_cast<std::size_t>(-2);

std::size_t invalid() {
  errno = EILSEQ;
  return kInvalid;
}

}  // namespace

/// In place of mbrtowc, by an option of the linker. Texts of this project are UTF-8, which the C
/// library of Windows does not know; by mbrtowc, libstdc++ turns them into paths. A character of
/// four bytes takes two calls: three bytes give the first half of its pair, the last byte the
/// second one, which the state keeps.
extern "C" std::size_t __wrap_mbrtowc(wchar_t* out, const char* text, std::size_t count,
                                      std::mbstate_t* state) {
  static thread_local std::mbstate_t own{};
  std::mbstate_t& half = state != nullptr ? *state : own;
  if (text == nullptr || count == 0) return text == nullptr ? 0 : kIncomplete;
  wchar_t pair[2] = {};
  std::size_t used = 1;
  if (half != 0) {
    pair[0] = static_cast<wchar_t>(half);
    half = 0;
  } else {
    used = length_of(static_cast<unsigned char>(*text));
    if (used == 0) return invalid();
    if (used > count) return kIncomplete;
    if (MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, text, static_cast<int>(used), pair, 2) ==
        0)
      return invalid();
    half = pair[1];
    used = std::min<std::size_t>(used, 3);
  }
  if (out != nullptr) *out = pair[0];
  return pair[0] == 0 ? 0 : used;
}
