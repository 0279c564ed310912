// SPDX-License-Identifier: MIT
// bench NAME [OPTIONS]: runs one benchmark; without a name it lists them.
#include <fmt/format.h>

#include <exception>
#include <string_view>

#include "bench.h"

namespace selvedge::bench_main {
namespace {

struct Benchmark {
  std::string_view name;
  int (*run)(int argc, char** argv);
  std::string_view measures;
};

constexpr Benchmark kBenchmarks[] = {
    {"batch", bench_batch, "many scenes stepped together: throughput and memory"},
    {"bending", bench_bending, "discrete bending energies against closed forms"},
    {"broadphase", bench_broadphase, "broad phases by part, on scenes of any size"},
    {"core", bench_core, "spring forces per second, steps, bending"},
    {"drape", bench_drape, "seconds by phase of whole drapes, and the cost of the solver"},
    {"drape_split", bench_drape_split, "causes of the difference from measured drapes"},
    {"enclosure", bench_enclosure, "savings of the minimal enclosure"},
    {"fail_safe", bench_fail_safe, "fail-safes on scenes that need them"},
    {"find_collisions", bench_find_collisions, "the C++ call beside that from Python"},
    {"grips", bench_grips, "cloth that jaws grip, in generated scenes"},
#ifdef SELVEDGE_HAS_OSMESA
    {"image_space", bench_image_space, "image space by resolution: time and error"},
#endif
    {"integrators", bench_integrators, "error against time of the integrators"},
    {"limiters", bench_limiters, "strain limiters on one swinging cloth"},
    {"order_in_contact", bench_order_in_contact, "order of the implicit integrators in contact"},
    {"response", bench_response, "responses on scenes with closed forms, and the survey's claims"},
    {"rest", bench_rest, "rest of the cloth and accuracy of Coulomb's law"},
    {"rivals", bench_rivals, "springs beside finite elements and a geometric drape"},
    {"seams", bench_seams, "cloth that slides over surfaces in parts"},
    {"slender", bench_slender, "slender strips against theory"},
    {"untangle", bench_untangle, "generated scenes that start tangled"},
};

int list() {
  fmt::print("bench NAME [OPTIONS]; bench NAME --help lists the options\n\n");
  for (const Benchmark& b : kBenchmarks) fmt::print("  {:<16} {}\n", b.name, b.measures);
  return 0;
}

}  // namespace
}  // namespace selvedge::bench_main

int main(int argc, char** argv) {
  using namespace selvedge::bench_main;
  const std::string_view name = argc > 1 ? argv[1] : "--help";
  if (name == "--help" || name == "-h") return list();
  for (const Benchmark& b : kBenchmarks) {
    if (b.name != name) continue;
    try {
      return b.run(argc - 1, argv + 1);
    } catch (const std::exception& error) {
      fmt::print(stderr, "bench {}: {}\n", name, error.what());
      return 2;
    }
  }
  fmt::print(stderr, "bench: no benchmark '{}'; bench --help lists them\n", name);
  return 2;
}
