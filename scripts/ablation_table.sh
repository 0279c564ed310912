#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# ablation_table.sh [--print] [FRAMES]: measures for every scene of data/scenes and data/experiments which optional parts
# it can do without over its first FRAMES frames (default 30), with `selvedge plan --ablate` and SEEDS seeds (default 3),
# and writes docs/lab/tables/ablation.csv: a row for each scene, a column for each part. --print: prints the table instead.
# SELVEDGE names the program (default: build/release/apps/selvedge). Takes half an hour on one core.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
print=
if [ "${1:-}" = --print ]; then
  print=yes
  shift
fi
PRINT=$print FRAMES=${1:-30} SEEDS=${SEEDS:-3} PROGRAM=${SELVEDGE:-build/release/apps/selvedge} python3 - <<'PYTHON'
import csv, glob, json, os, subprocess, sys

PARTS = ["self_collision", "strain_limit", "air", "bending"]


def cell(row):
    """The verdict; for a part that could go also the time without it over the time with it."""
    verdict = row["verdict"].split(",")[0]
    if verdict == "needed" and not row["clean"]:
        return "needed: not clean"
    if verdict == "needed":
        return f'needed: {row["worst_measure"]} {row["difference"]:+.2g}'
    return f'{verdict}: time x {row["time_ratio"][0]:.2f}' if verdict == "could go" else verdict


rows = []
for folder in ("scenes", "experiments"):
    for file in sorted(glob.glob(f"data/{folder}/*.json")):
        name = os.path.splitext(os.path.basename(file))[0]
        if name == "scene.schema":
            continue
        scene = {"scene": name}
        done = subprocess.run([os.environ["PROGRAM"], "plan", file, "--ablate", "--seeds", os.environ["SEEDS"], "--json",
                               "--set", f'time.frames={os.environ["FRAMES"]}'], capture_output=True, text=True)
        if done.returncode == 0:
            scene |= {row["part"]: cell(row) for row in json.loads(done.stdout)["ablation"]}
        else:
            reason = done.stderr.strip().splitlines()[-1].removeprefix("selvedge: ")
            scene[PARTS[0]] = "not run: " + reason.replace(os.getcwd() + "/", "")
        rows.append(scene)
        print(name, file=sys.stderr)

out = sys.stdout if os.environ["PRINT"] else open("docs/lab/tables/ablation.csv", "w", newline="")
writer = csv.DictWriter(out, ["scene", *PARTS], restval="", lineterminator="\n")
writer.writeheader()
writer.writerows(rows)
out.close()
PYTHON
