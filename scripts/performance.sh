#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# performance.sh [--quick] [--rows LIST] [--sizes LIST] [--repeats N] [--threads N] [--frames N] [OLD_COMMIT]
# Builds OLD_COMMIT (default: c4aaa8a) and the present tree in build/performance, runs both in turns on the same scene
# files, and prints tables in Markdown: medians, quartiles, and how many times faster the present tree is. A full run
# also writes docs/lab/tables/performance.csv and the tables of docs/lab/performance.md; it takes about two hours on two cores.
# --quick    sizes 50 and 100, one repeat; writes no file of docs/
# --rows     some of body, ball, poncho, skirt and torso, with commas; writes no file of docs/. body is the person of
#            ../shared/data/garments if that file is there, otherwise the mannequin
# --sizes    particles per side (default: 50,100,200; garments: 50,100); writes no file of docs/
# --repeats  runs of each program on each scene (default: 3)
# --threads  threads of each run (default: all)
# --frames   frames of each run (default: 120); writes no file of docs/
# SELVEDGE_OLD and SELVEDGE_NEW name finished build folders to take instead of building. The present one needs the
# targets selvedge_program and selvedge_bench, the old one selvedge_program.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"

fail() {
  echo "performance.sh: $1" >&2
  exit 2
}
old=c4aaa8a rows= sizes= repeats=3 threads=0 frames=120 write=true
while [ $# -gt 0 ]; do
  case "$1" in
    --quick) sizes=50,100 repeats=1 write=false; shift; continue ;;
    --rows | --sizes | --repeats | --threads | --frames) [ $# -gt 1 ] || fail "$1 needs a value" ;;
    -*) fail "there is no option $1; the head of the script describes the options" ;;
    *) old=$1; shift; continue ;;
  esac
  case "$1" in
    --rows) rows=$2 write=false ;;
    --sizes) sizes=$2 write=false ;;
    --repeats) repeats=$2 ;;
    --threads) threads=$2 ;;
    --frames) frames=$2 write=false ;;
  esac
  shift 2
done
[[ "$repeats" =~ ^[1-9][0-9]*$ ]] || fail "--repeats $repeats: write a whole number above 0"
[[ "$frames" =~ ^[1-9][0-9]*$ ]] || fail "--frames $frames: write a whole number above 0"
[[ "$threads" =~ ^[0-9]+$ ]] || fail "--threads $threads: write a whole number"
[[ -z "$sizes" || "$sizes" =~ ^[1-9][0-9]*(,[1-9][0-9]*)*$ ]] || fail "--sizes $sizes: write whole numbers with commas"
for row in ${rows//,/ }; do
  case "$row" in
    body | ball | poncho | skirt | torso) ;;
    *) fail "there is no row $row; there are body, ball, poncho, skirt and torso" ;;
  esac
done
for tool in git cmake c++ python3; do
  command -v "$tool" >/dev/null || fail "$tool is missing; scripts/install_dependencies.sh test installs what a build needs"
done

# build SOURCE FOLDER TARGETS...: builds the targets of a source tree without tests and adapters.
build() {
  local source=$1 folder=$2 configure
  shift 2
  configure=(cmake -S "$source" -B "$folder" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON -DSELVEDGE_BENCH=ON)
  for library in ASSIMP FCL LIBCCD CGAL EMBREE OSMESA PAGMO; do configure+=("-DSELVEDGE_$library=OFF"); done
  if [ ! -f "$folder/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  echo "Building $folder" >&2
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$folder" --parallel "$(nproc)" --target "$@"
}

old_build=${SELVEDGE_OLD:-} new_build=${SELVEDGE_NEW:-}
if [ -z "$old_build" ]; then
  commit=$(git rev-parse --verify --quiet "$old^{commit}") || fail "there is no commit $old in this repository"
  tree=build/performance/$commit
  if [ "$(git -C "$tree" rev-parse HEAD 2>/dev/null || true)" != "$commit" ] || [ ! -f "$tree/.git" ]; then
    rm -rf "$tree"
    git worktree prune
    scripts/quietly.sh git worktree add --detach "$tree" "$commit"
  fi
  old_build=build/performance/old_$commit
  build "$tree" "$old_build" selvedge_program
fi
if [ -z "$new_build" ]; then
  new_build=build/performance/new
  build . "$new_build" selvedge_program selvedge_bench
fi
for program in "$old_build/apps/selvedge" "$new_build/apps/selvedge" "$new_build/bench/bench"; do
  [ -x "$program" ] || fail "$program is not there; build it, or leave SELVEDGE_OLD and SELVEDGE_NEW unset"
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# scenes SIZES OPTIONS...: writes scene files and prints their paths.
scenes() {
  local list=$1
  shift
  "$new_build/bench/bench" drape --write-scenes --out "$work/scenes" --frames "$frames" "$@" ${list//,/ }
}
person=../shared/data/garments/bodies/f_smpl_template.obj
for row in ${rows:-body ball poncho skirt torso}; do
  for one in ${row//,/ }; do
    case "$one" in
      body)
        if [ -f "$person" ]; then
          scenes "${sizes:-50,100,200}" --body "$person" --up y --subdivide 1
        else
          echo "There is no $person; the row body is the mannequin, subdivided once" >&2
          scenes "${sizes:-50,100,200}" --body mannequin --subdivide 1
        fi
        ;;
      ball) scenes "${sizes:-50,100,200}" --body ball ;;
      *) scenes "${sizes:-50,100}" --garment "$one" ;;
    esac
  done
done >"$work/list"

WORK=$work OLD=$old_build NEW=$new_build OLD_NAME=$old REPEATS=$repeats THREADS=$threads WRITE=$write FRAMES=$frames \
  python3 - <<'PYTHON'
import csv, datetime, json, os, shutil, statistics, subprocess, sys

WORK, REPEATS, THREADS = os.environ["WORK"], int(os.environ["REPEATS"]), os.environ["THREADS"]
BENCH = os.path.join(os.environ["NEW"], "bench", "bench")
PROGRAMS = {"old": os.path.join(os.environ["OLD"], "apps", "selvedge"), "new": os.path.join(os.environ["NEW"], "apps", "selvedge")}
SCENES = [line.strip() for line in open(os.path.join(WORK, "list"))]
PAGE, BEGIN, END = "docs/lab/performance.md", "<!-- table by scripts/performance.sh -->", "<!-- end of table -->"


def title(scene):
    name, size = os.path.basename(os.path.dirname(os.path.dirname(scene))).rsplit("_", 1)
    return name, int(size)


def particles_of(frames):
    last = sorted(name for name in os.listdir(frames) if name.startswith("cloth_"))[-1]
    with open(os.path.join(frames, last), "rb") as file:
        for line in file:
            if line.startswith(b"element vertex"):
                return int(line.split()[2])


def run(program, scene):
    out = os.path.join(WORK, "result")
    shutil.rmtree(out, ignore_errors=True)
    with open(os.path.join(WORK, "log"), "w") as log:
        child = subprocess.Popen([program, "run", scene, "--out", out, "--no-pictures", "--threads", THREADS],
                                 stdout=log, stderr=subprocess.STDOUT)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        last = (open(os.path.join(WORK, "log")).read().strip().splitlines() or ["no message"])[-1]
        sys.exit(f"performance.sh: {program} run {scene} ended with {child.returncode}: {last}")
    result = json.load(open(os.path.join(out, "result.json")))
    counters, phases, steps = result["counters"], result["phase_s"], result["steps"]
    parts = ("proximity", "collision")  # which older programs measure as one phase
    if all(part in phases for part in parts):
        phases["narrow_phase"] = sum(phases.pop(part) for part in parts)
    sample = {
        "wall_s": result["wall_s"], "cpu_s": usage.ru_utime + usage.ru_stime, "peak_MB": 1e-6 * result["peak_bytes"],
        "particles": particles_of(os.path.join(out, "frames")), "steps": steps,
        "solves_per_step": counters.get("solves", 0) / steps,
        "iterations_per_step": counters.get("solver_iterations", 0) / steps,
        "solver_bytes": counters.get("solver_bytes", 0), "solver_iterations": counters.get("solver_iterations", 0),
        "stretch_percent": 100 * result["max_stretch"], "rest_speed_mm_s": 1e3 * result["final_max_speed"],
        "clean": result["clean"], **{f"{name}_s": seconds for name, seconds in phases.items()},
    }
    shutil.rmtree(out)
    return sample


def triad():
    answer = subprocess.run([BENCH, "drape", "--triad", "--json", "--threads", THREADS], stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(answer.stdout)


def quartiles(values):
    values = list(values)
    return values * 3 if len(values) == 1 else statistics.quantiles(values, n=4, method="inclusive")


def with_quartiles(values, digits):
    low, middle, high = quartiles(values)
    return f"{middle:.{digits}f}" if REPEATS == 1 else f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def middle(samples, key):
    known = [sample[key] for sample in samples if key in sample]
    return statistics.median(known) if known else None


def shown(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def seconds(value):
    return shown(value, 2 if value is not None and value < 10 else 1)


def divided(a, b):
    return a / b if a and b else None


def markdown(head, rows):
    lines = ["| " + " | ".join(head) + " |", "| --- | --- |" + " --: |" * (len(head) - 2)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


first_triad = triad()
samples = {scene: {"old": [], "new": []} for scene in SCENES}
for repeat in range(REPEATS):
    for scene in SCENES:
        for which in ("old", "new") if repeat % 2 == 0 else ("new", "old"):
            sample = run(PROGRAMS[which], scene)
            samples[scene][which].append(sample)
            name, size = title(scene)
            print(f"{repeat + 1}/{REPEATS} {name} {size} {which}: {sample['wall_s']:.1f} s", file=sys.stderr)
bandwidth = max(first_triad["triad_bytes_per_s"], triad()["triad_bytes_per_s"])


def faster(scene, key):
    """How many times as long the old program took, pair by pair."""
    pairs = zip(samples[scene]["old"], samples[scene]["new"])
    return [divided(a.get(key), b.get(key)) or 0.0 for a, b in pairs]


def heading(scene):
    name, size = title(scene)
    return [name, f"{size} x {size}"]


def per_particle(scene):
    """Solve, s per particle and step."""
    new = samples[scene]["new"]
    return middle(new, "solve_s") / (middle(new, "particles") * middle(new, "steps"))


def grid_of(size):
    """The sheet with which garments of this size are compared: on the body, otherwise on the ball."""
    grids = [scene for scene in SCENES if title(scene)[1] == size and title(scene)[0] not in ("poncho", "skirt", "torso")]
    return grids[0] if grids else None


times, counts, phases, table = [], [], [], []
names = sorted({key for s in samples.values() for runs in s.values() for run_ in runs for key in run_
                if key.endswith("_s") and key not in ("wall_s", "cpu_s")})
share = {name: max(run_.get(name, 0.0) / run_["wall_s"] for s in samples.values() for runs in s.values() for run_ in runs)
         for name in names}
names = [name for name in names if name != "rest_speed_mm_s" and share[name] >= 0.02]
for scene in SCENES:
    old, new = samples[scene]["old"], samples[scene]["new"]
    times.append(heading(scene) + [with_quartiles((s["wall_s"] for s in old), 2), with_quartiles((s["wall_s"] for s in new), 2),
                                   with_quartiles(faster(scene, "wall_s"), 2), with_quartiles(faster(scene, "cpu_s"), 2),
                                   with_quartiles(faster(scene, "solve_s"), 2)])
    moved, iterations, solve = middle(new, "solver_bytes"), middle(new, "solver_iterations"), middle(new, "solve_s")
    grid = grid_of(title(scene)[1])
    over_grid = per_particle(scene) / per_particle(grid) if grid and title(scene)[0] in ("poncho", "skirt", "torso") else None
    megabytes, rate = divided(1e-6 * moved, iterations), divided(1e-9 * moved, solve)
    limit = divided(solve * bandwidth, moved)
    counts.append(heading(scene) + [f"{middle(new, 'particles'):.0f}"] +
                  [f"{middle(old, key):.{digits}f} / {middle(new, key):.{digits}f}"
                   for key, digits in (("solves_per_step", 2), ("iterations_per_step", 1))] +
                  [shown(megabytes, 2), shown(rate, 1), shown(limit, 1), shown(1e6 * per_particle(scene), 2), shown(over_grid, 2)])
    phases.append(heading(scene) + [f"{seconds(middle(old, name))} / {seconds(middle(new, name))}" for name in names] +
                  [f"{middle(old, 'peak_MB'):.0f} / {middle(new, 'peak_MB'):.0f}"] +
                  [f"{middle(old, key):.1f} / {middle(new, key):.1f}" for key in ("stretch_percent", "rest_speed_mm_s")] +
                  [" / ".join("yes" if all(s["clean"] for s in runs) else "NO" for runs in (old, new))])
    row = {"scene": title(scene)[0], "size": title(scene)[1], "repeats": REPEATS, "particles": f"{middle(new, 'particles'):.0f}"}
    for key in ("wall_s", "cpu_s", "solve_s"):
        for which, runs in (("old", old), ("new", new)):
            for quarter, value in zip(("q1", "median", "q3"), quartiles(s.get(key, 0.0) for s in runs)):
                row[f"{which}_{key}_{quarter}"] = f"{value:.2f}"
        for quarter, value in zip(("q1", "median", "q3"), quartiles(faster(scene, key))):
            row[f"times_faster_{key[:-2]}_{quarter}"] = f"{value:.2f}"
    for name in ("solves_per_step", "iterations_per_step", "peak_MB", "stretch_percent", "rest_speed_mm_s", *names):
        for which, runs in (("old", old), ("new", new)):
            row[f"{which}_{name}"] = shown(middle(runs, name), 2)
    for which, runs in (("old", old), ("new", new)):
        row[f"{which}_clean"] = "yes" if all(s["clean"] for s in runs) else "no"
    row |= {"new_MB_per_iteration": shown(megabytes, 3), "new_GB_per_s": shown(rate, 2), "triad_GB_per_s": f"{1e-9 * bandwidth:.2f}",
            "times_the_limit": shown(limit, 2), "new_solve_us_per_particle_and_step": shown(1e6 * per_particle(scene), 3),
            "over_grid": shown(over_grid, 2)}
    table.append(row)

model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "an unnamed processor")
day = f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d}"
plural = "run" if REPEATS == 1 else "runs"
text = "\n".join([
    f"`scripts/performance.sh` with {os.environ['OLD_NAME']} as the old program, {REPEATS} {plural} of each in turns, "
    f"{os.environ['FRAMES']} frames, {first_triad['threads']} threads on {model}, {day}, load {os.getloadavg()[0]:.1f}. "
    f"The triad moves {1e-9 * bandwidth:.1f} GB/s."
    + (" All figures: [tables/performance.csv](tables/performance.csv).\n" if os.environ["WRITE"] == "true" else "\n"),
    "Wall time of the run, and how many times faster the new program is. In brackets: quartiles.\n",
    markdown(["scene", "size", "old s", "new s", "times faster", "in CPU time", "in the solve"], times),
    "The solver: solves and iterations old / new, the others of the new program.\n",
    markdown(["scene", "size", "particles", "solves per step", "iterations per step", "MB per iteration", "GB/s", "times the limit",
              "solve us per particle and step", "by that of the sheet"], counts),
    "Seconds by phase, memory and quality, old / new.\n",
    markdown(["scene", "size", *(name[:-2].replace("_", " ") + " s" for name in names), "peak MB", "stretch %", "rest speed mm/s",
              "clean"], phases)])
print(text)
if os.environ["WRITE"] == "true":
    with open("docs/lab/tables/performance.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(table)
    page = open(PAGE).read()
    head, rest = page.split(BEGIN, 1)
    open(PAGE, "w").write(f"{head}{BEGIN}\n\n{text}\n{END}{rest.split(END, 1)[1]}")
    print(f"Written: docs/lab/tables/performance.csv and {PAGE}", file=sys.stderr)
PYTHON
