#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# survey_figures.sh: redraws figures 11, 12, 22 and 27 of the survey with this library, as
# docs/images/survey_figures.svg. Figure 12 reads docs/lab/tables/mesh_hang.csv (scripts/mesh_table.sh); the script measures
# the others, which takes minutes. SELVEDGE names the program (default: build/release/apps/selvedge).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
WORK=$work PROGRAM=${SELVEDGE:-build/release/apps/selvedge} python3 - <<'PYTHON'
import csv, json, math, os, subprocess

WORK, PROGRAM = os.environ["WORK"], os.environ["PROGRAM"]
PATTERNS = ["triangular", "simplified", "rectangular", "responsive"]  # in the survey's order
REST = 1e-7  # J: a fifth of a kilogram at 1 mm/s


def run(*words):
    return subprocess.run([PROGRAM, *words], check=True, capture_output=True, text=True).stdout


def seconds_to_balance(pattern):
    out = os.path.join(WORK, pattern)
    run("run", "data/meshes/hang.json", "--threads", "1", "--no-picture", "--set", "geometry.0.cells=[36,36]",
        "--set", f"geometry.0.pattern={pattern}", "--set", "time.frames=300", "--out", out)
    run("measure", out, "--no-picture")
    with open(os.path.join(out, "measures", "energy.csv")) as table:
        return max(float(row["time_s"]) for row in csv.DictReader(table) if float(row["kinetic_J"]) > REST)


def distances():
    with open("docs/lab/tables/mesh_hang.csv") as table:
        rows = [row for row in csv.DictReader(table) if row["cells"] == "36" and row["mesh"] != "rectangular"]
    return [(row["mesh"], float(row["rms_to_finest_rectangular_mm"])) for row in rows]


def limiters():
    names = "position,ordered_position,position_velocity,ordered_position_velocity,priority_position_velocity,velocity"
    out = os.path.join(WORK, "limiters")
    run("compare", "data/scenes/flag.json", "--no-reference", "--judge", "0", "--no-pictures", "--repeats", "15", "--set",
        "geometry.0.cells=[24,24]", "--set", "time.frames=8", "--set", "materials.default.stretch_stiffness=60",
        "--vary", f"strain_limiter={names}", "--out", out)
    with open(os.path.join(out, "compare.csv")) as table:
        return [(row["strain_limiter"], float(row["ratio_of_s"])) for row in csv.DictReader(table)]


def largest_steps():
    def of(integrators, *words):
        return json.loads(run("stability", "data/scenes/flag.json", "--set", "geometry.0.cells=[19,19]", "--steps", "500", "--integrator",
                              integrators, "--stiffness", "1000", "--damping", "0.001", "--json", *words))["results"]

    # Adaptive Runge-Kutta divides a long step into as many as its error asks for, so one second of them is enough.
    rows = of("forward_euler,midpoint,verlet,runge_kutta_4") + of("rkf45", "--seconds", "1") + of("implicit_euler")
    return [(r["integrator"] + (" (any)" if r["measured_s"] >= 1 else ""), r["measured_s"]) for r in rows]


WIDTH, ROW, LABEL, BAR = 460, 22, 190, 200


def panel(x, y, title, unit, values, logarithmic=False):
    low = min(v for _, v in values) / 3 if logarithmic else 0.0
    top = max(v for _, v in values)
    share = (lambda v: math.log(v / low) / math.log(top / low)) if logarithmic else (lambda v: v / top)
    parts = [f'<text x="{x}" y="{y}" class="title">{title}</text>']
    for k, (name, v) in enumerate(values):
        at = y + 14 + ROW * k
        parts += [f'<text x="{x + LABEL - 8}" y="{at + 14}" text-anchor="end">{name}</text>',
                  f'<rect x="{x + LABEL}" y="{at + 2}" width="{BAR * share(v):.1f}" height="{ROW - 6}"/>',
                  f'<text x="{x + LABEL + BAR * share(v) + 5:.1f}" y="{at + 14}">{v:.3g} {unit}</text>']
    return "\n".join(parts)


picture = "\n".join([
    f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH + 20} 360" font-family="sans-serif" font-size="12">',
    "<style>.title{font-size:14px;font-weight:bold} rect{fill:#4477aa}</style>",
    f'<rect width="{2 * WIDTH + 20}" height="360" style="fill:#ffffff"/>',
    panel(15, 30, "Figure 11: motion until balance, 36 × 36 cells", "s", [(p, seconds_to_balance(p)) for p in PATTERNS]),
    panel(WIDTH + 15, 30, "Figure 12: distance from the rectangular hang", "mm", distances()),
    panel(15, 195, "Figure 22: time of a run over that with “position”", "", limiters()),
    panel(WIDTH + 15, 195, "Figure 27: largest stable step (logarithmic)", "s", largest_steps(), True),
    "</svg>", ""])
with open("docs/images/survey_figures.svg", "w") as file:
    file.write(picture)
PYTHON
