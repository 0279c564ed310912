#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# plan_table.sh [--print] [FRAMES]: measures what `selvedge plan` saves on every scene of data/scenes, data/extreme and
# data/experiments, over its first FRAMES frames (default 10), and writes the table of docs/plan.md between its markers;
# --print: to the standard output alone. SELVEDGE names the program (default: build/release/apps/selvedge). One core, minutes.
# Fails if a scene ends in other bits without proofs than with them.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
print=
if [ "${1:-}" = --print ]; then
  print=yes
  shift
fi
PRINT=$print FRAMES=${1:-10} PROGRAM=${SELVEDGE:-build/release/apps/selvedge} python3 - <<'PYTHON'
import datetime, glob, json, os, subprocess, sys

FRAMES, PROGRAM = os.environ["FRAMES"], os.environ["PROGRAM"]
REPEATS = "3"
PARTS = ["self_collision", "body_collision", ("crossings_self", "crossings_body"), "strain_limit"]
BEGIN, END = "<!-- table: saved -->\n", "<!-- end of table: saved -->"


def left_out(parts, names):
    """'20 of 20' of the parts of that name that the scene has; nothing if it has none."""
    names = names if isinstance(names, tuple) else (names,)
    there = [parts[n] for n in names if n in parts and parts[n]["asked"] > 0]
    return f'{sum(p["left_out"] for p in there)} of {sum(p["asked"] for p in there)}' if there else ""


def row(name, m):
    gain = "{:.2f} ({:.2f} to {:.2f})".format(*m["gain"])
    cells = [left_out(m["parts"], part) for part in PARTS]
    return "| " + " | ".join([f"`{name}`", str(m["steps"]), gain, *cells, f'{100 * m["proving_share"]:.1f} %']) + " |"


rows, without, broken = [], [], []
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
            without.append(f"`{name}` ({'refused' if done.returncode == 2 else 'stops'})")
        print(name, file=sys.stderr)

text = "\n".join([
    "| scene | steps | times as fast (quartiles) | cloth with itself | with bodies | check of frames | strain limit | proving |",
    "| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |", *rows, "",
    f"`scripts/plan_table.sh {FRAMES}`, {datetime.date.today()}: the first {FRAMES} frames, one thread, {REPEATS} repeats in turns; the"
    " columns in the middle say how often a part was left out. Not in it: " + ", ".join(without) + ".", ""])
if os.environ["PRINT"]:
    print(text)
else:
    with open("docs/plan.md") as file:
        page = file.read()
    before, rest = page.split(BEGIN)
    with open("docs/plan.md", "w") as file:
        file.write(before + BEGIN + text + END + rest.split(END)[1])
sys.exit(f"plan_table.sh: other bits without proofs: {', '.join(broken)}" if broken else 0)
PYTHON
