// SPDX-License-Identifier: MIT
//
// Many garments on several machines or processors: a Snakemake workflow [Molder2021].
#include <selvedge/core/system/internal/files.h>
#include <selvedge/dress/internal/dress_batch.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

namespace selvedge {
namespace {

/// A string of Python.
std::string python(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', /*ensure_ascii=*/true,
                                   nlohmann::json::error_handler_t::replace);
}

}  // namespace

void write_dress_workflow(const std::filesystem::path& out, const std::vector<DressJob>& jobs,
                          const std::vector<std::string>& arguments, int threads) {
  std::string words, names;
  for (const std::string& word : arguments) words += "    " + python(word) + ",\n";
  for (const DressJob& job : jobs) names += "    " + python(job.name) + ",\n";
  std::error_code ignored;  // the file reports it
  std::filesystem::create_directories(out, ignored);
  AtomicFile file(out / "Snakefile");
  file.write(R"(# Made by selvedge dress --workflow
# Run it here:  snakemake --cores 2
# Another program than the selvedge of the path:  --config selvedge=/where/it/is
# One job a garment. A garment that is not good (exit code 1) does not end the others; the page names it.
import shlex
SELVEDGE = config.get("selvedge", "selvedge")
DRESS = shlex.join([
)" + words + R"(])
GARMENTS = [
)" + names + R"(]

rule page:
    input: expand(".done/{name}", name=GARMENTS)
    output: "index.html"
    params: dress=DRESS
    shell: "{SELVEDGE} dress {params.dress} --threads 1 || [ $? -eq 1 ]"

rule garment:
    output: touch(".done/{name}")
    threads: )" +
             std::to_string(std::max(1, threads)) + R"(
    params: dress=DRESS
    shell: "{SELVEDGE} dress {params.dress} --threads {threads} --only={wildcards.name:q} || [ $? -eq 1 ]"
)");
  file.commit();
}

}  // namespace selvedge
