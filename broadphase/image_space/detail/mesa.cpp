// SPDX-License-Identifier: MIT
#include <selvedge/broadphase/image_space/detail/mesa.h>
#include <selvedge/core/system/internal/libraries.h>

#include <stdexcept>
#include <string>

#if defined(__SANITIZE_ADDRESS__)
// Defaults of the sanitizers for programs that link this. Weak, so that they can define their own.
// Mesa keeps about 2.4 kB until the process ends.
extern "C" __attribute__((weak)) const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\n";
}
// Up to g++ 13, the search for leaks takes the thread-local data of a library that was loaded late
// for that of glibc before 2.25 if it starts 16 bytes into a page, and crashes when it reads there
// (google/sanitizers, issue 1322). It finds this data without that interceptor, too.
extern "C" __attribute__((weak)) const char* __asan_default_options() {
  return "intercept_tls_get_addr=0";
}
#endif

namespace selvedge::detail {
namespace {

constexpr const char* kLibrary = "libOSMesa.so.8";  // ABI of Mesa since 2012

Mesa loaded() try {
  const LoadedLibrary library(kLibrary);
  Mesa functions;
#define SELVEDGE_FIND(name) library.find(#name, functions.name);
  SELVEDGE_MESA_FUNCTIONS(SELVEDGE_FIND)
#undef SELVEDGE_FIND
  return functions;
} catch (const std::runtime_error& why) {
  throw std::runtime_error(
      std::string("image space: OSMesa cannot be used, install its library (") + why.what() + ")");
}

}  // namespace

const Mesa& mesa() {
  static const Mesa functions = loaded();
  return functions;
}

}  // namespace selvedge::detail
