// SPDX-License-Identifier: MIT
#include <selvedge/compare/compare_plan.h>
#include <selvedge/core/base/internal/text.h>
#include <selvedge/core/system/internal/files.h>

#include <string>

namespace selvedge {

void write_workflow(const std::filesystem::path& out, const ComparePlan& plan) {
  std::string cells;
  for (const CompareCell& cell : plan.cells)
    if (cell.impossible.empty()) cells += "    \"" + cell.id + "\",\n";
  for (const std::string& level : plan.levels) cells += "    \"" + level + "\",\n";
  AtomicFile file(out / "Snakefile");
  // A line end in a name would end the comment.
  file.write("# Made by: " + printable(plan.command) + " --workflow\n" +
             R"(# Run it here:  snakemake --cores 2
# Another program than the selvedge of the path:  --config selvedge=/where/it/is
# One job a cell, each in its own processes; times of jobs that share a machine disturb each other.
SELVEDGE = config.get("selvedge", "selvedge")
CELLS = [
)" + cells + R"(]

rule page:
    input: expand("cells/{id}/done", id=CELLS)
    output: "compare.html", "compare.csv", "compare.json"
    shell: "{SELVEDGE} compare --in ."

rule cell:
    output: touch("cells/{id}/done")
    shell: "{SELVEDGE} compare --in . --only {wildcards.id}"
)");
  file.commit();
}

}  // namespace selvedge
