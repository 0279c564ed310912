// SPDX-License-Identifier: MIT
#include <selvedge/core/cloth/detail/coloring.h>

#include <algorithm>
#include <numeric>

namespace selvedge::detail {

Coloring color_elements(std::span<const std::int32_t> particle_of, std::size_t arity,
                        std::size_t particles) {
  Coloring result;
  const std::size_t n = particle_of.size() / arity;
  const std::size_t chunks = (n + kColorChunk - 1) / kColorChunk;
  std::vector<std::size_t> rest(chunks), later;
  std::iota(rest.begin(), rest.end(), std::size_t{0});
  std::vector<std::int32_t> last_color(particles, -1);
  result.color_begin.push_back(0);
  // First fit: one pass per colour takes every chunk whose particles are all still unused in this
  // colour.
  for (std::int32_t color = 0; !rest.empty(); ++color) {
    later.clear();
    for (const std::size_t chunk : rest) {
      const std::size_t begin = chunk * kColorChunk, end = std::min(n, begin + kColorChunk);
      const auto own = particle_of.subspan(begin * arity, (end - begin) * arity);
      if (std::any_of(own.begin(), own.end(), [&](auto p) { return last_color[p] == color; })) {
        later.push_back(chunk);
        continue;
      }
      for (const std::int32_t p : own) last_color[p] = color;
      for (std::size_t e = begin; e < end; ++e)
        result.order.push_back(static_cast<std::int32_t>(e));
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
    parallel_for(color_begin[c + 1] - first, kColorChunk,
                 [&](std::size_t begin, std::size_t end) { body(first + begin, first + end); });
  }
}

}  // namespace selvedge::detail
