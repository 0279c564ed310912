// SPDX-License-Identifier: MIT
#include <selvedge/core/coloring.h>

#include <algorithm>

namespace selvedge {
namespace {

// Elements per task: an element costs some 50 ns, starting a task about 1 µs.
constexpr std::size_t color_grain = 1024;

}  // namespace

Coloring color_elements(std::span<const std::int32_t> particle_of, std::size_t arity,
                        std::size_t particles) {
  Coloring result;
  const std::size_t n = particle_of.size() / arity;
  std::vector<std::int32_t> rest(n), later;
  for (std::size_t e = 0; e < n; ++e) rest[e] = static_cast<std::int32_t>(e);
  std::vector<std::int32_t> last_color(particles, -1);
  result.color_begin.push_back(0);
  // One pass per colour takes every element whose particles are still free in this colour, which
  // is what first fit gives.
  for (std::int32_t color = 0; !rest.empty(); ++color) {
    later.clear();
    for (const std::int32_t e : rest) {
      const auto own = particle_of.subspan(static_cast<std::size_t>(e) * arity, arity);
      if (std::any_of(own.begin(), own.end(), [&](auto p) { return last_color[p] == color; })) {
        later.push_back(e);
        continue;
      }
      for (const std::int32_t p : own) last_color[p] = color;
      result.order.push_back(e);
    }
    result.color_begin.push_back(result.order.size());
    rest.swap(later);
  }
  return result;
}

void for_each_color(std::span<const std::size_t> color_begin,
                    FunctionRef<void(std::size_t, std::size_t)> body) {
  for (std::size_t c = 0; c + 1 < color_begin.size(); ++c) {
    const std::size_t first = color_begin[c];
    parallel_for(color_begin[c + 1] - first, color_grain,
                 [&](std::size_t begin, std::size_t end) { body(first + begin, first + end); });
  }
}

}  // namespace selvedge
