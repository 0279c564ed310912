// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <selvedge/broadphase/detail/mesa.h>

#include <stdexcept>
#include <string>

#if defined(__SANITIZE_ADDRESS__)
// Mesa keeps about 2.4 kB until the process ends. Weak, so that a program that links this can
// define its own.
extern "C" __attribute__((weak)) const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\n";
}
#endif

namespace selvedge::detail {
namespace {

constexpr const char* kLibrary = "libOSMesa.so.8";  // ABI of Mesa since 2012

[[noreturn]] void fail() {
  const char* why = dlerror();
  throw std::runtime_error("image space: OSMesa cannot be used, install its library (" +
                           std::string(why ? why : kLibrary) + ")");
}

template <class Function>
void find(void* library, const char* name, Function*& function) {
  function = reinterpret_cast<Function*>(dlsym(library, name));
  if (!function) fail();
}

Mesa loaded() {
  void* library = dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL);
  if (!library) fail();
  Mesa functions;
#define SELVEDGE_FIND(name) find(library, #name, functions.name);
  SELVEDGE_MESA_FUNCTIONS(SELVEDGE_FIND)
#undef SELVEDGE_FIND
  return functions;
}

}  // namespace

const Mesa& mesa() {
  static const Mesa functions = loaded();
  return functions;
}

}  // namespace selvedge::detail
