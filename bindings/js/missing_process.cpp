// SPDX-License-Identifier: MIT
//
// A browser starts no processes, and the C library of Emscripten 3.1.6 lacks this function.
constexpr int kNoSuchFunction = 52;  // its ENOSYS

extern "C" int posix_spawnp(int*, const char*, const void*, const void*, char* const*,
                            char* const*) {
  return kNoSuchFunction;
}
