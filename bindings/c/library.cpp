// SPDX-License-Identifier: MIT
//
// Version, errors, threads and names of methods.
#include <selvedge/apps/version.h>
#include <selvedge/bindings/c/calls.h>
#include <selvedge/core/base/parallel.h>
#include <selvedge/core/base/registry.h>

#include <memory>
#include <mutex>

namespace selvedge::c {
namespace {

thread_local std::string last_error;

/// The names of the methods of a registry.
template <class Registry>
std::vector<std::string> names_of(const Registry& registry) {
  std::vector<std::string> names;
  for (const auto& [name, entry] : registry) names.push_back(name);
  return names;
}

const char* name_at(const std::vector<std::string>& names, std::size_t i) {
  return i < names.size() ? names[i].c_str() : nullptr;
}

}  // namespace

int fail(int code, const char* sentence) noexcept {
  try {
    last_error = sentence;
  } catch (const std::bad_alloc&) {
    last_error.clear();
  }
  return code;
}

double figure_named(const char* name, const std::map<std::string, double>& figures) {
  const auto found = figures.find(&needed(name, "name"));
  if (found != figures.end()) return found->second;
  throw std::invalid_argument("figure: " + unknown_name(name, names_of(figures), {}));
}

}  // namespace selvedge::c

using namespace selvedge;  // NOLINT: the functions below are outside of it

int selvedge_interface_version() { return 1; }
const char* selvedge_version() { return version_text(); }
const char* selvedge_last_error() { return c::last_error.c_str(); }

int selvedge_set_threads(int threads) {
  return c::call([&] {
    if (threads < 0)
      throw std::invalid_argument("threads is " + std::to_string(threads) +
                                  "; it must be 0 (all) or positive");
    static std::mutex mutex;
    static std::unique_ptr<ThreadLimit> limit;
    const std::lock_guard lock(mutex);
    limit.reset();
    if (threads > 0) limit = std::make_unique<ThreadLimit>(threads);
  });
}

const char* selvedge_broad_phase(size_t i) {
  static const std::vector<std::string> names = c::names_of(broad_phases());
  return c::name_at(names, i);
}

const char* selvedge_narrow_phase(size_t i) {
  static const std::vector<std::string> names = c::names_of(narrow_phases());
  return c::name_at(names, i);
}
