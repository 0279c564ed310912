// SPDX-License-Identifier: MIT
// The fuzz targets of tests/fuzz without libFuzzer: each runs every input of its corpus in the
// repository, then inputs made from these by chance, the same ones each time. scripts/fuzz.sh makes
// millions, guided by what they reach.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "fuzz.h"

using Target = int(const std::uint8_t*, std::size_t);
// tests/CMakeLists.txt gives LLVMFuzzerTestOneInput of each file a name of its own.
extern "C" {
Target fuzz_ccd, fuzz_detectors, fuzz_fabric, fuzz_folder, fuzz_garment, fuzz_mesh, fuzz_query,
    fuzz_result, fuzz_scene, fuzz_sequence, fuzz_simulation;
}

namespace {

using namespace selvedge;
using Input = std::vector<std::uint8_t>;

struct Case {
  const char* name;
  Target* run;
  int mutants;  // inputs made by chance
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const Case kCases[] = {
    {"ccd", fuzz_ccd, 5000},
    {"detectors", fuzz_detectors, 1000},
    {"fabric", fuzz_fabric, 10000},
    {"folder", fuzz_folder, 1000},
    {"garment", fuzz_garment, 10000},
    {"mesh", fuzz_mesh, 10000},
    {"query", fuzz_query, 10000},
    {"result", fuzz_result, 10000},
    {"scene", fuzz_scene, 5000},
    {"sequence", fuzz_sequence, 1000},
    {"simulation", fuzz_simulation, 500},
};

// In the order of the names of the files, which is the same on every machine.
std::vector<Input> corpus_of(const std::string& target) {
  std::vector<std::filesystem::path> files;
  const std::string folder = SELVEDGE_SOURCE_DIR "/tests/fuzz/corpus/" + target;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Input> inputs;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return inputs;
}

std::size_t below(std::size_t n, std::mt19937_64& chance) { return chance() % n; }

/// One of the inputs with up to four changes: of a bit, a byte, a stretch that goes, comes twice or
/// is taken from another input.
Input mutant(const std::vector<Input>& inputs, std::mt19937_64& chance) {
  Input out = inputs[below(inputs.size(), chance)];
  for (std::size_t changes = 1 + below(4, chance); changes-- > 0;) {
    if (out.empty()) out.push_back(static_cast<std::uint8_t>(below(256, chance)));
    const std::size_t at = below(out.size(), chance);
    const auto place = out.begin() + static_cast<std::ptrdiff_t>(at);
    const auto length = static_cast<std::ptrdiff_t>(1 + below(out.size() - at, chance));
    const Input stretch(place, place + length);
    const Input& other = inputs[below(inputs.size(), chance)];
    switch (below(5, chance)) {
      case 0:
        *place ^= static_cast<std::uint8_t>(1u << below(8, chance));
        break;
      case 1:
        *place = static_cast<std::uint8_t>(below(256, chance));
        break;
      case 2:
        out.erase(place, place + length);
        break;
      case 3:
        out.insert(place, stretch.begin(), stretch.end());
        break;
      default:
        out.erase(place, out.end());
        out.insert(out.end(),
                   other.begin() + static_cast<std::ptrdiff_t>(std::min(at, other.size())),
                   other.end());
    }
  }
  return out;
}

class Fuzz : public testing::TestWithParam<Case> {};

// A fault ends the process and leaves the input in /dev/shm.
TEST_P(Fuzz, CorpusAndItsMutants) {
  const Case& target = GetParam();
  const fuzz::InputFile last("_last_" + std::string(target.name));
  const auto run = [&](const Input& input) {
    last.holding(input.data(), input.size());
    EXPECT_EQ(target.run(input.data(), input.size()), 0);
  };
  const std::vector<Input> inputs = corpus_of(target.name);
  ASSERT_GE(inputs.size(), 10u);
  for (const Input& input : inputs) run(input);
  std::mt19937_64 chance(19);
  for (int k = 0; k < target.mutants; ++k) run(mutant(inputs, chance));
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
