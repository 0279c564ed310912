#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# mesh_table.sh [--quick | --only NAME]: hangs and drapes one fabric on every mesh at three refinements (data/meshes)
# and writes docs/lab/tables/mesh_hang.csv and docs/lab/tables/mesh_drape.csv. SELVEDGE names the program (default:
# build/release/apps/selvedge). --quick: runs two coarse refinements and prints the tables. --only: hang or drape. Uses
# one core and takes minutes.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
names="hang drape"
case "${1:-}" in
  "" | --quick) ;;
  --only) names=${2:?which table?} ;;
  *) echo "usage: scripts/mesh_table.sh [--quick | --only NAME]" >&2; exit 2 ;;
esac
case "$names" in
  "hang drape" | hang | drape) ;;
  *) echo "mesh_table.sh: there is no table '$names'" >&2; exit 2 ;;
esac
program=${SELVEDGE:-build/release/apps/selvedge}
if ! command -v "$program" >/dev/null; then
  echo "mesh_table.sh: there is no program '$program'; build it, or name it in SELVEDGE" >&2
  exit 2
fi
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

PROGRAM=$program RESULTS=$results python3 - "${1:-}" "$names" <<'PYTHON'
import array, csv, datetime, json, math, os, resource, subprocess, sys

PROGRAM, RESULTS = os.environ["PROGRAM"], os.environ["RESULTS"]
QUICK = sys.argv[1] == "--quick"
CELLS = [6, 9] if QUICK else [9, 18, 36]
PATTERNS = ["rectangular", "simplified", "checkerboard", "triangular", "responsive"]
LATTICE = 9         # shapes are compared at the corners of 9 x 9 cells, which every grid of squares has
BALANCE_SPEED = 0.001  # m/s: the cloth is at balance when no particle is faster
HANG_SECONDS = 8   # of data/meshes/hang.json
VERTEX_DOUBLES = 6  # of a vertex in a frame: position and velocity; then one byte of flags


def frame(path):
    """Positions, velocities and triangles of a frame (binary PLY as the program writes it)."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts = [int(line.split()[2]) for line in data[:end].split(b"\n") if line.startswith(b"element")]
    stride = 8 * VERTEX_DOUBLES + 1
    points, speeds, triangles = [], [], []
    for v in range(counts[0]):
        row = array.array("d", data[end + v * stride:end + v * stride + stride - 1])
        points.append(tuple(row[:3]))
        speeds.append(math.hypot(*row[3:]))
    at = end + counts[0] * stride
    for t in range(counts[1]):
        triangles.append(tuple(array.array("i", data[at + 13 * t + 1:at + 13 * t + 13])))
    return points, speeds, triangles


def lattice(rest, points, triangles):
    """Positions of the same points of the cloth on every mesh: linear in the triangle that holds each at rest."""
    low = [min(p[k] for p in rest) for k in (0, 1)]
    high = [max(p[k] for p in rest) for k in (0, 1)]
    where = {}
    for i in range(LATTICE + 1):
        for j in range(LATTICE + 1):
            x, y = (low[0] + (high[0] - low[0]) * i / LATTICE, low[1] + (high[1] - low[1]) * j / LATTICE)
            best, weights, held = -math.inf, None, None
            for t in triangles:
                a, b, c = (rest[v] for v in t)
                area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
                u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
                w = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
                inside = min(u, w, 1 - u - w)
                if inside > best:
                    best, weights, held = inside, (1 - u - w, u, w), t
            where[i, j] = tuple(sum(weights[k] * points[held[k]][d] for k in range(3)) for d in range(3))
    return where


def rms(pairs):
    pairs = list(pairs)
    return math.sqrt(sum(math.dist(a, b) ** 2 for a, b in pairs) / len(pairs))


def distance(a, b):
    return rms((a[k], b[k]) for k in a)


def asymmetry(shape):
    """Distance of the shape from its mirror image in x, whose plane is that of the scene, x = 0 or the middle."""
    middle = sum(p[0] for p in shape["start"].values()) / len(shape["start"])
    return rms(((2 * middle - p[0], p[1], p[2]), shape["end"][LATTICE - i, j]) for (i, j), p in shape["end"].items())


def run(scene, pattern, cells, *sets):
    out = os.path.join(RESULTS, f"{scene}_{pattern}_{cells[0]}_{'_'.join(sets)}".replace("/", "_"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    settings = [f"geometry.0.pattern={pattern}", f"geometry.0.cells=[{cells[0]},{cells[1]}]", *sets]
    command = [PROGRAM, "run", f"data/meshes/{scene}.json", "--out", out, "--threads", "1", "--no-picture"]
    for value in settings:
        command += ["--set", value]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"mesh_table.sh: {' '.join(command)}: {done.stdout}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([PROGRAM, "measure", out], check=True, stdout=subprocess.DEVNULL)
    result = json.load(open(os.path.join(out, "result.json")))
    frames = sorted(name for name in os.listdir(os.path.join(out, "frames")) if name.startswith("cloth"))
    rest, _, triangles = frame(os.path.join(out, "frames", frames[0]))
    points, speeds, _ = frame(os.path.join(out, "frames", frames[-1]))
    balance = None
    for number in range(len(frames) - 1, 0, -1):
        if max(frame(os.path.join(out, "frames", frames[number]))[1]) > BALANCE_SPEED:
            break
        balance = number
    with open(os.path.join(out, "measures", "springs.csv")) as table:
        springs = sum(1 for row in csv.reader(table)) - 1
    print(f"{scene} {pattern} {cells} {' '.join(sets)}: {result['wall_s']:.1f} s", file=sys.stderr)
    shape = {"start": lattice(rest, rest, triangles), "end": lattice(rest, points, triangles)} if pattern != "arc" else None
    return {
        "shape": shape, "lowest": min(p[2] for p in points), "measures": result["measures"], "clean": result["clean"],
        "balance": balance, "nodes": len(points), "springs": springs, "steps": result["steps"], "frames": result["frames"] - 1,
        "cpu_ms": 1e3 * (after.ru_utime - before.ru_utime) / result["steps"],
        "iterations": result["counters"]["solver_iterations"] / result["steps"], "speed": result["final_max_speed"],
    }


def table(name, head, rows):
    day = f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d}"
    file = sys.stdout if QUICK else open(f"docs/lab/tables/mesh_{name}.csv", "w", newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow([*head, "measured"])
    writer.writerows([*row, day] for row in rows)
    file.flush()


def mm(metres):
    return f"{1e3 * metres:.1f}"


def seconds_of_balance(r, seconds):
    return "" if r["balance"] is None else f"{seconds * r['balance'] / r['frames']:.1f}"


HANG_HEAD = ["mesh", "cells", "lowest_mm", "rms_to_finest_rectangular_mm", "rms_to_own_finest_mm", "rms_to_mirror_image_mm",
             "springs_per_node", "balance_s", "solver_iterations_per_step", "cpu_ms_per_step", "clean"]
DRAPE_HEAD = ["mesh", "cells", "drape_coefficient_percent", "change_from_coarser", "difference_to_finest_rectangular", "folds",
              "rms_to_finest_rectangular_mm", "rms_to_mirror_image_mm", "final_speed_mm_s", "cpu_ms_per_step", "clean"]


def hang_rows(patterns, cells, *sets):
    runs = {(p, c): run("hang", p, (c, c), *sets) for p in patterns for c in cells}
    best = runs["rectangular", cells[-1]]["shape"]["end"]
    rows = []
    for (pattern, c), r in runs.items():
        end = r["shape"]["end"]
        own = "" if c == cells[-1] else mm(distance(end, runs[pattern, cells[-1]]["shape"]["end"]))
        rows.append([pattern, str(c), mm(r["lowest"]), mm(distance(end, best)), own, mm(asymmetry(r["shape"])),
                     f"{r['springs'] / r['nodes']:.2f}", seconds_of_balance(r, HANG_SECONDS), f"{r['iterations']:.1f}",
                     f"{r['cpu_ms']:.2f}", "yes" if r["clean"] else "no"])
    return rows


def draping(cells):
    runs = {(p, c): run("drape", p, (c, c)) for p in PATTERNS for c in cells}
    for c in cells:  # about as many particles as the squares have; the rings are denser in the middle
        runs["arc", c] = run("drape", "arc", (3 * c, c // 2 + c // 3))
    best = runs["rectangular", cells[-1]]
    rows = []
    for (pattern, c), r in runs.items():
        coefficient = r["measures"]["drape_coefficient"]
        before = cells.index(c) - 1
        change = "" if before < 0 else f"{coefficient - runs[pattern, cells[before]]['measures']['drape_coefficient']:+.2f}"
        disc = pattern == "arc"
        rows.append(["arc (disc)" if disc else pattern, str(c), f"{coefficient:.2f}", change,
                     "" if disc else f"{coefficient - best['measures']['drape_coefficient']:+.2f}", f"{r['measures']['folds']:.0f}",
                     "" if disc else mm(distance(r["shape"]["end"], best["shape"]["end"])),
                     "" if disc else mm(asymmetry(r["shape"])), f"{1e3 * r['speed']:.2f}", f"{r['cpu_ms']:.2f}",
                     "yes" if r["clean"] else "no"])
    table("drape", DRAPE_HEAD, rows)


for name in sys.argv[2].split():
    if name == "hang":
        table("hang", HANG_HEAD, hang_rows(PATTERNS, CELLS))
    else:
        draping(CELLS)
PYTHON
