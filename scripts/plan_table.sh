#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# plan_table.sh [--print] [FRAMES]: measures how much time `selvedge plan` saves on every scene of data/scenes,
# data/extreme and data/experiments, over its first FRAMES frames (default 10), and writes docs/lab/tables/plan.csv.
# --print: prints the table instead. SELVEDGE names the program (default: build/release/apps/selvedge). Takes minutes on
# one core. Fails if a scene ends with different bits without proofs than with them.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
print=
if [ "${1:-}" = --print ]; then
  print=yes
  shift
fi
PRINT=$print FRAMES=${1:-10} PROGRAM=${SELVEDGE:-build/release/apps/selvedge} python3 - <<'PYTHON'
import csv, glob, json, os, subprocess, sys

FRAMES, PROGRAM = os.environ["FRAMES"], os.environ["PROGRAM"]
REPEATS = "3"
PARTS = {"self": ["self_collision"], "bodies": ["body_collision"],
         "frame_checks": ["crossings_self", "crossings_body"], "strain_limit": ["strain_limit"]}
COLUMNS = ["scene", "outcome", "steps", "speedup_median", "speedup_q1", "speedup_q3",
           *(f"{part}_{count}" for part in PARTS for count in ("left_out", "asked")), "proving_percent"]


def row(name, m):
    cells = {"scene": name, "outcome": "measured", "steps": m["steps"],
             "proving_percent": f'{100 * m["proving_share"]:.1f}'}
    for column, value in zip(("speedup_median", "speedup_q1", "speedup_q3"), m["gain"]):
        cells[column] = f"{value:.2f}"
    for part, names in PARTS.items():
        there = [m["parts"][n] for n in names if n in m["parts"] and m["parts"][n]["asked"] > 0]
        if there:  # a part that the scene lacks stays empty
            cells[f"{part}_left_out"] = sum(p["left_out"] for p in there)
            cells[f"{part}_asked"] = sum(p["asked"] for p in there)
    return cells


rows, unmeasured, broken = [], [], []
for folder in ("scenes", "extreme", "experiments"):
    for file in sorted(glob.glob(f"data/{folder}/*.json")):
        name = os.path.splitext(os.path.basename(file))[0]
        if name == "scene.schema":
            continue
        done = subprocess.run([PROGRAM, "plan", file, "--measure", FRAMES, "--repeats", REPEATS, "--json"],
                              capture_output=True, text=True)
        if done.returncode == 1 and done.stdout:
            broken.append(name)
        if done.returncode == 0:
            rows.append(row(name, json.loads(done.stdout)["measured"]))
        else:
            unmeasured.append({"scene": name, "outcome": "refused" if done.returncode == 2 else "stops"})
        print(name, file=sys.stderr)

out = sys.stdout if os.environ["PRINT"] else open("docs/lab/tables/plan.csv", "w", newline="")
writer = csv.DictWriter(out, COLUMNS, restval="", lineterminator="\n")
writer.writeheader()
writer.writerows(rows + unmeasured)
out.close()
sys.exit(f"plan_table.sh: other bits without proofs: {', '.join(broken)}" if broken else 0)
PYTHON
