// SPDX-License-Identifier: MIT
//
// Between C and the library: exceptions as codes, and arrays that a program passes.
#pragma once

#include <selvedge/bindings/c/selvedge.h>
#include <selvedge/bodies/body.h>
#include <selvedge/core/base/types.h>
#include <selvedge/detection/find.h>
#include <selvedge/dress/dress.h>
#include <selvedge/simulation/failure.h>

#include <array>
#include <atomic>
#include <map>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace selvedge::c {

static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
static_assert(sizeof(Triangle) == 3 * sizeof(std::int32_t));
static_assert(sizeof(TrianglePair) == 2 * sizeof(std::int32_t));
static_assert(sizeof(Edge) == 2 * sizeof(std::int32_t));

/// Keeps the sentence for selvedge_last_error and returns the code.
int fail(int code, const char* sentence) noexcept;

/// Another thread uses the object.
struct Busy : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Calls work() and returns SELVEDGE_OK, or the code of what it throws.
template <class Work>
int call(const Work& work) noexcept {
  try {
    work();
    return SELVEDGE_OK;
  } catch (const Busy& error) {
    return fail(SELVEDGE_BUSY, error.what());
  } catch (const SimulationFailed& error) {
    return fail(SELVEDGE_FAILED, error.what());
  } catch (const DressFailed& error) {
    return fail(SELVEDGE_FAILED, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(SELVEDGE_INVALID, error.what());
  } catch (const std::bad_alloc&) {
    return fail(SELVEDGE_NO_MEMORY, "the memory is used up");
  } catch (const std::exception& error) {
    return fail(SELVEDGE_INTERNAL, error.what());
  }
}

/// Refuses a second thread while one uses an object.
class OneThread {
 public:
  OneThread(std::atomic<bool>& busy, const char* what) : busy_(busy) {
    if (busy_.exchange(true))
      throw Busy(std::string("another thread uses this ") + what + "; give each thread its own");
  }
  ~OneThread() { busy_ = false; }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  std::atomic<bool>& busy_;
};

template <class T>
T& needed(T* pointer, const char* name) {
  if (pointer == nullptr)
    throw std::invalid_argument(std::string(name) + " is NULL; it is required");
  return *pointer;
}

/// n rows of an array. Throws if it is null and n is not 0.
template <class Row, class Number>
std::span<const Row> rows(const Number* array, std::size_t n, const char* name) {
  if (n > 0) needed(array, name);
  return {reinterpret_cast<const Row*>(array), n};
}

inline MovingSurface moving(const selvedge_surface* given, const char* name) {
  const selvedge_surface& s = needed(given, name);
  const auto x_t0 = rows<Vec3>(s.x_t0, s.vertices, "x_t0");
  return {x_t0, s.x_t1 == nullptr ? x_t0 : rows<Vec3>(s.x_t1, s.vertices, "x_t1"),
          rows<Triangle>(s.triangles, s.triangle_count, "triangles")};
}
inline SurfaceState state(const selvedge_surface* given, const char* name) {
  const MovingSurface s = moving(given, name);
  return {s.x_t0, s.triangles};
}

/// The figure of this name. Throws std::invalid_argument with the nearest name if there is none.
double figure_named(const char* name, const std::map<std::string, double>& figures);

/// The lists behind a selvedge_mesh, which is its first part.
struct Mesh : selvedge_mesh {
  TriangleMesh lists;

  explicit Mesh(TriangleMesh mesh);
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;
};

/// The lists behind a selvedge_contacts, which is its first part.
struct Contacts : selvedge_contacts {
  std::vector<std::uint8_t> kinds;
  std::vector<std::array<std::int32_t, 4>> corners;
  std::vector<std::array<double, 4>> shares;
  std::vector<std::array<std::int32_t, 2>> sides;
  std::vector<Vec3> normals, impulses;
  std::vector<double> times, gaps, rest_gaps;

  Contacts() : selvedge_contacts{} {}
  /// Hands the object to the program, its columns set.
  static selvedge_contacts* release(Contacts&& lists);
};

}  // namespace selvedge::c
