// SPDX-License-Identifier: MIT
// The fuzz targets of tests/fuzz without libFuzzer: each runs every input of its corpus in the
// repository, then inputs made from these by chance, the same ones each time. scripts/fuzz.sh makes
// millions, guided by what they reach.
#include <gtest/gtest.h>

#include <algorithm>
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

// The names of files, so that the inputs come in the same order on every machine.
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

/// SplitMix64 [G. Steele, D. Lea, C. Flood, OOPSLA 2014].
class Chance {
 public:
  std::size_t below(std::size_t n) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return (z ^ (z >> 31)) % n;
  }

 private:
  std::uint64_t state_ = 19;
};

/// One of the inputs with up to four changes: of a bit, a byte, a stretch that goes, comes twice or
/// is taken from another input.
Input mutant(const std::vector<Input>& inputs, Chance& chance) {
  Input out = inputs[chance.below(inputs.size())];
  for (std::size_t changes = 1 + chance.below(4); changes-- > 0;) {
    if (out.empty()) out.push_back(static_cast<std::uint8_t>(chance.below(256)));
    const std::size_t at = chance.below(out.size());
    const auto place = out.begin() + static_cast<std::ptrdiff_t>(at);
    const auto length = static_cast<std::ptrdiff_t>(1 + chance.below(out.size() - at));
    const Input stretch(place, place + length);
    const Input& other = inputs[chance.below(inputs.size())];
    switch (chance.below(5)) {
      case 0:
        *place ^= static_cast<std::uint8_t>(1u << chance.below(8));
        break;
      case 1:
        *place = static_cast<std::uint8_t>(chance.below(256));
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
  Chance chance;
  for (int k = 0; k < target.mutants; ++k) run(mutant(inputs, chance));
}

INSTANTIATE_TEST_SUITE_P(Targets, Fuzz, testing::ValuesIn(kCases),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
