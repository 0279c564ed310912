#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# tables.sh NAME [OPTIONS]: measures and writes a table of the pages. NAME is one of the functions below, and its options
# stand above each.
set -euo pipefail

# tables.sh ablation [SCENE...]: measures for every shipped scene (data/scenes, experiments, extreme, validation) what each
# part of it costs and what leaving it out changes, with `selvedge plan --ablate` and SEEDS seeds (default 2), over as many
# frames as a run makes in BUDGET seconds (default 1). Writes docs/lab/tables/ablation.csv (a row for each scene and part) and
# the matrix of docs/lab/ablation.md. Scenes that out/ablation has are not run again; SCENE: files to run again, none else.
# SELVEDGE names the program (default: build/release/apps/selvedge). Takes half an hour of the processor.
table_ablation() (
cd "$(dirname "${BASH_SOURCE[0]}")/.."
BUDGET=${BUDGET:-1} SEEDS=${SEEDS:-2} PROGRAM=${SELVEDGE:-build/release/apps/selvedge} python3 - "$@" <<'PYTHON'
import csv, glob, json, os, pathlib, statistics, subprocess, sys, tempfile

PARTS = ["self_collision", "friction", "response", "frame_check", "strain_limit", "shear", "bending", "air", "steps_at_rest",
         "joined_steps"]
PROGRAM, BUDGET, SEEDS = (os.environ[name] for name in ("PROGRAM", "BUDGET", "SEEDS"))
KEPT = pathlib.Path("out/ablation")
KEPT.mkdir(parents=True, exist_ok=True)


def program(*words):
    return subprocess.run([PROGRAM, *words], capture_output=True, text=True)


def reason(done):
    last = (done.stderr.strip().splitlines() or ["exit code " + str(done.returncode)])[-1]
    return last.removeprefix("selvedge: ").replace(os.getcwd() + "/", "")


def measure(file):
    """Frames, and rows of `plan --ablate`; or why there are none."""
    total = json.load(open(file)).get("time", {}).get("frames", 120)
    with tempfile.TemporaryDirectory() as folder:
        tried = program("run", file, "--budget", BUDGET, "--threads", "1", "--no-pictures", "--out", folder + "/run", "--json")
    if not tried.stdout.startswith("{"):
        return {"fault": reason(tried)}
    frames = min(total, max(2, json.loads(tried.stdout)["frames"] - 1))
    done = program("plan", file, "--ablate", "--seeds", SEEDS, "--json", "--set", f"time.frames={frames}")
    if done.returncode != 0:
        return {"fault": reason(done)}
    return {"frames": frames, "total": total, "rows": json.loads(done.stdout)["ablation"]}


files = [file for folder in ("scenes", "experiments", "extreme", "validation") for file in sorted(glob.glob(f"data/{folder}/*.json"))
         if not file.endswith("schema.json")]
for file in sys.argv[1:] or files:
    kept = KEPT / (pathlib.Path(file).stem + ".json")
    if sys.argv[1:] or not kept.exists():
        kept.write_text(json.dumps(measure(file)))
        print(file, file=sys.stderr, flush=True)

found = {file: json.loads(kept.read_text()) for file in files if (kept := KEPT / (pathlib.Path(file).stem + ".json")).exists()}
with open("docs/lab/tables/ablation.csv", "w", newline="") as out:
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["scene", "frames", "of", "part", "verdict", "time_ratio", "error_percent", "spread_of_seeds_percent", "crossings",
                     "clean", "same_bits", "worst_measure", "difference", "why"])
    for file, scene in found.items():
        name = pathlib.Path(file).stem
        if "fault" in scene:
            writer.writerow([name, "", "", "", "not run", *[""] * 8, scene["fault"]])
        for row in scene.get("rows", []):
            ran = row["time_ratio"][0] > 0
            writer.writerow([name, scene["frames"], scene["total"], row["part"], row["verdict"].split(",")[0],
                             *([f'{row["time_ratio"][0]:.2f}', f'{100 * row["distance"]:.2g}', f'{100 * row["spread_of_seeds"]:.2g}',
                                row["crossings"]] if ran else [""] * 4), "yes" if row["clean"] else "no",
                             ("yes" if row["same_bits"] else "no") if ran else "", row["worst_measure"],
                             f'{row["difference"]:.2g}' if ran else "", row["why"]])


def cell(row):
    """Time over that of the whole scene, and the distance to it in percent of the extent; x: crossings."""
    if row is None:
        return ""
    if row["time_ratio"][0] == 0:
        return "refused" if row["why"].startswith("refused") else "**stops**"
    text = f'{row["time_ratio"][0]:.2f}' + ("" if row["same_bits"] else f'; {100 * row["distance"]:.1g}')
    if row["crossings"]:
        return f'**{text}; x {row["crossings"]}**'
    return f"**{text}**" if row["verdict"].startswith("needed") else text


def summary(part, scenes):
    rows = [row for scene in scenes for row in scene["rows"] if row["part"] == part]
    counts = [sum(row["verdict"].startswith(word) for row in rows) for word in ("needed", "not decided", "could go")]
    bits = sum(row["same_bits"] and row["clean"] for row in rows)
    times = [row["time_ratio"][0] for row in rows if row["time_ratio"][0] > 0]
    quarter = statistics.quantiles(times, n=4) if len(times) > 1 else [float("nan")] * 3
    return (f"| `{part}` | {len(rows)} | {counts[0]} | {sum(not row['clean'] for row in rows)} | {counts[1]} | {counts[2]} | {bits} | "
            f"{quarter[1]:.2f} ({quarter[0]:.2f} to {quarter[2]:.2f}) |")


measured = {file: scene for file, scene in found.items() if "rows" in scene}
lines = ["", "| part | scenes that have it | needed | of them not clean without it | not decided | could go | same bits without it | "
         "time without it over with it: median, quartiles |", "| --- |" + " ---: |" * 7]
lines += [summary(part, measured.values()) for part in PARTS]
lines += ["", "| scene | frames | seeds differ by | " + " | ".join(part.replace("_", " ") for part in PARTS) + " |",
          "| --- | ---: | ---: |" + " --- |" * len(PARTS)]
for file, scene in measured.items():
    rows = {row["part"]: row for row in scene["rows"]}
    spread = max((row["spread_of_seeds"] for row in scene["rows"]), default=0.0)
    lines.append(f"| `{pathlib.Path(file).stem}` | {scene['frames']} of {scene['total']} | {100 * spread:.1g} | "
                 + " | ".join(cell(rows.get(part)) for part in PARTS) + " |")
refused = [f"`{pathlib.Path(file).stem}`" for file, scene in found.items() if "fault" in scene]
lines += ["", f"Not run, since the program refuses them or their body has to be fetched: {', '.join(refused) or 'none'}.", ""]
page = pathlib.Path("docs/lab/ablation.md")
begin, end = "<!-- table by scripts/tables.sh ablation -->\n", "<!-- end of table -->"
before, rest = page.read_text().split(begin)
page.write_text(before + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1])
PYTHON
)

# tables.sh broad_phase [--quick | --only NAME]: measures every broad phase that this machine can build. It writes each
# table to docs/lab/tables/broad_phase_NAME.csv, and a short form into docs/lab/broad_phase.md between the markers of that name,
# with the machine, the date and the command. --quick: small scenes and few repeats as a quick check; prints the tables
# and writes no file of docs/. --only: one of detectors, libraries, spikes, scaling, memory and frames.
table_broad_phase() (
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
quick=false
names=(detectors libraries spikes scaling memory frames)
case "${1:-}" in
  "") ;;
  --quick) quick=true ;;
  --only) names=("${2:?which table?}") ;;
  *) echo "usage: scripts/tables.sh broad_phase [--quick | --only NAME]" >&2; exit 2 ;;
esac

build=build/release
if [ -z "${SELVEDGE_BENCH:-}" ]; then
  configure=(cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DSELVEDGE_UNITY=ON -DSELVEDGE_BENCH=ON)
  if [ ! -f "$build/CMakeCache.txt" ] && command -v ninja >/dev/null; then configure+=(-G Ninja); fi
  scripts/quietly.sh "${configure[@]}"
  scripts/quietly.sh cmake --build "$build" --target selvedge_bench --parallel "$(nproc)"
fi
bench=${SELVEDGE_BENCH:-$build/bench/bench}
page=docs/lab/broad_phase.md
tables=$(mktemp -d)
trap 'rm -rf "$tables"' EXIT

# table NAME ARGUMENTS...: measures the table NAME.csv and records the command and the machine.
table() {
  local name=$1
  shift
  echo "Measuring: $name" >&2
  "$bench" broadphase "$@" --csv "$tables/$name.raw" >/dev/null
  sed '/^$/d' "$tables/$name.raw" >"$tables/$name.csv"
  echo "\`bench broadphase $*\` on $(nproc) cores of $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1)," \
    "$(date -u +%Y-%m-%d), load $(cut -d' ' -f1 /proc/loadavg)." >"$tables/$name.how"
}

if $quick; then
  table detectors detectors --size 30 --repeats 1
  table libraries libraries --size 30 --repeats 1
  table spikes spikes --size 30 --repeats 1
  table scaling scaling --size 20,40 --repeats 1
  table memory memory --size 30
  table frames frames --size 30 --frames 5
  cat "$tables"/*.csv
  exit 0
fi
for name in "${names[@]}"; do
  case "$name" in
    detectors) table detectors detectors --size 50,200 --threads 1,2 --repeats 3 ;;
    libraries) table libraries libraries --size 200 --threads 1,2 --repeats 9 ;;
    spikes) table spikes spikes --size 100 --smaller 1e5,1e7 --repeats 3 --limit 10 ;;
    scaling)
      table scaling scaling --size 50,100,200,400 --repeats 3 --limit 15 --detectors \
        bvh_aabb,bvh_kdop14,curvature_cone,sweep_and_prune,uniform_grid,verlet_bvh
      ;;
    memory) table memory memory --size 200 --large --detectors bvh_aabb,bvh_kdop14 ;;
    frames) table frames frames --size 100 --frames 200 --detectors bvh_aabb,verlet_bvh ;;
    *) echo "tables.sh broad_phase: there is no table '$name'" >&2; exit 2 ;;
  esac
done

# columns FILE.csv NUMBERS...: prints these columns as a Markdown table.
columns() {
  local file=$1
  shift
  awk -F, -v list="$*" '
    BEGIN { count = split(list, column, " ") }
    {
      row = rule = "|"
      for (i = 1; i <= count; ++i) {
        row = row " " $column[i] " |"
        rule = rule (i < 3 ? " --- |" : " ---: |")
      }
      print row
      if (NR == 1) print rule
    }' "$file"
}

# Columns of detectors.csv: 1 scene, 2 detector, 3 threads, 8 warm ms, 11 share of the box pairs, 12 MB.
short_detectors() {
  echo "| detector | drape, ms | pairs, % | MB | crumple, ms | pairs, % | MB |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $3 != 1 || $1 !~ / 200$/ { next }
    NF < 12 && $1 ~ /^drape/ { next }  # answers particles, not pairs
    $1 ~ /^drape/ { drape[$2] = sprintf("%.1f | %.0f | %.0f", $8, 100 * $11, $12) }
    $1 ~ /^crumple/ { crumple[$2] = NF < 12 ? "- | - | -" : sprintf("%.1f | %.0f | %.0f", $8, 100 * $11, $12) }
    END { for (name in drape) print "| `" name "` | " drape[name] " | " crumple[name] " |" }' "$tables/detectors.csv" |
    sort -t'|' -k3,3n
}

# Columns of frames.csv: 1 scene, 2 detector, 4 speed, 5 mean ms, 7 worst ms.
short_frames() {
  echo "| scene | speed, m/s | bvh_aabb mean, ms | worst, ms | verlet_bvh mean, ms | worst, ms |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $2 == "bvh_aabb" { tree = $5 " | " $7 }
    $2 == "verlet_bvh" { print "| " $1 " | " $4 " | " tree " | " $5 " | " $7 " |" }' "$tables/frames.csv"
}

# Columns of spikes.csv: 1 scene, 2 detector, 3 threads, 4 perturbation, 6 ratio to plain.
short_spikes() {
  echo "| detector | drape: spike | far away | copy 1e5 | copy 1e7 | crumple: spike | far away | copy 1e5 | copy 1e7 |"
  echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
  awk -F, '
    $3 != 1 || NF < 6 { next }
    {
      kind = $4 ~ /^spike/ ? 1 : $4 ~ /away$/ ? 2 : $4 ~ /1e5/ ? 3 : $4 ~ /1e7/ ? 4 : 0
      scene = $1 ~ /^drape/ ? 0 : 4
      known[$2]
      if (NF >= 6 && $6 + 0 > ratio[$2, scene + kind] + 0) ratio[$2, scene + kind] = $6
    }
    END {
      for (name in known) {
        row = "| `" name "` |"
        for (k = 1; k <= 8; ++k) row = row " " ((name, k) in ratio && ratio[name, k] ? ratio[name, k] : "-") " |"
        print row
      }
    }' "$tables/spikes.csv" | sort
}

short() {
  case "$1" in
    detectors) short_detectors ;;
    frames) short_frames ;;
    libraries)
      columns "$tables/libraries.csv" 1 2 3 5 6 8 9 10 |
        sed "1s/.*/| scene | call | threads | bvh_aabb, ms | best library | its ms | ratio of minima | of medians |/"
      ;;
    scaling) columns "$tables/scaling.csv" 1 2 4 5 6 7 8 ;;
    memory) columns "$tables/memory.csv" 1 2 3 4 5 6 7 ;;
    spikes) short_spikes ;;
  esac
}

mkdir -p docs/lab/tables
for name in "${names[@]}"; do
  begin="<!-- table: $name -->"
  end="<!-- end of table: $name -->"
  if ! grep -qF "$begin" "$page" || ! grep -qF "$end" "$page"; then
    echo "tables.sh broad_phase: $page has no markers '$begin' and '$end'" >&2
    exit 1
  fi
  cp "$tables/$name.csv" "docs/lab/tables/broad_phase_$name.csv"
  short "$name" >"$tables/$name.short"
  {
    echo
    cat "$tables/$name.short"
    if [ -s "$tables/$name.short" ]; then echo; fi
    echo "All rows: [docs/lab/tables/broad_phase_$name.csv](tables/broad_phase_$name.csv), by"
    cat "$tables/$name.how"
    echo
  } >"$tables/$name.md"
  awk -v begin="$begin" -v end="$end" -v file="$tables/$name.md" '
    $0 == end { inside = 0 }
    !inside { print }
    $0 == begin { inside = 1; while ((getline line < file) > 0) print line }' "$page" >"$tables/page"
  cp "$tables/page" "$page"
done
echo "Written: $page and docs/lab/tables/broad_phase_*.csv"
)

# tables.sh dress BODY RESOLUTION PATTERN...: puts each garment on a body, one at a time, and prints one CSV row for each:
# pattern, panels, vertices, seconds of wall and processor time, states judged, largest seam opening, stretch and verdict.
# A PATTERN is a file or a folder of *.json files; BODY is in metres with y up; RESOLUTION is the edge length in metres. The
# results go to out/dress_table/RESOLUTION/NAME, or to the folder in OUT. SELVEDGE names the program (default:
# build/release/apps/selvedge); THREADS and LIMIT set the number of threads (default: all) and the longest time of one
# garment in seconds (default: 600). Exit code 1: a garment was not put on as wanted.
# tables.sh dress --results FOLDER...: prints the same of garments that were put on before: result folders of `selvedge dress`,
# or folders of such, as --list makes them. Wall time is without output; processor time stays empty.
table_dress() (
row() { # FOLDER, EXIT CODE, "WALL USER SYSTEM" TIMES or ""
  python3 - "$1/result.json" "$(basename "$1")" "$2" "$3" "${LIMIT:-600}" <<'PYTHON'
import csv, json, os, sys

file, name, code, times, limit = sys.argv[1:]
result = {}
if os.path.exists(file):
    with open(file) as text:
        result = json.load(text)
if code == "124":
    result["verdict"] = f"not finished within {limit} s"
if times:
    wall, user, system = (float(t) for t in times.split())
    seconds = [f"{wall:.1f}", f"{user + system:.1f}"]
else:
    seconds = [f"{sum(s for phase, s in result.get('seconds', {}).items() if phase != 'output' and '/' not in phase):.1f}", ""]
cells = [name, len(result.get("panels", [])) or "", result.get("vertices", ""), *seconds, result.get("states_judged", "")]
finished = "largest_opening_m" in result
cells += [f"{1e3 * result['largest_opening_m']:.2f}", f"{1e2 * result['max_stretch']:.1f}"] if finished else ["", ""]
csv.writer(sys.stdout, lineterminator="\n").writerow(cells + [result.get("verdict", f"no result, exit code {code}")])
PYTHON
}

header="pattern,panels,vertices,wall_s,cpu_s,states,opening_mm,stretch_percent,verdict"
if [ "${1:-}" = --results ] && [ $# -gt 1 ]; then
  echo "$header"
  for folder in "${@:2}"; do
    if [ -f "$folder/result.json" ]; then row "$folder" 0 ""; fi
    for result in "$folder"/*/result.json; do
      if [ -f "$result" ]; then row "$(dirname "$result")" 0 ""; fi
    done
  done
  exit 0
fi
if [ $# -lt 3 ]; then
  echo "usage: scripts/tables.sh dress BODY RESOLUTION PATTERN..., or scripts/tables.sh dress --results FOLDER..." >&2
  exit 2
fi
body=$1 resolution=$2
shift 2
out=${OUT:-out/dress_table/$resolution}
program=${SELVEDGE:-$(dirname "${BASH_SOURCE[0]}")/../build/release/apps/selvedge}
if ! command -v "$program" >/dev/null; then
  echo "tables.sh dress: there is no program '$program'; build it, or name it in SELVEDGE" >&2
  exit 2
fi

patterns=()
for pattern in "$@"; do
  if [ -d "$pattern" ]; then patterns+=("$pattern"/*.json); else patterns+=("$pattern"); fi
done
status=0
TIMEFORMAT='%R %U %S'
echo "$header"
for pattern in "${patterns[@]}"; do
  name=$(basename "$pattern" .json) code=0
  mkdir -p "$out"
  rm -rf "${out:?}/$name"
  { time timeout "${LIMIT:-600}" "$program" dress "$pattern" "$body" --resolution "$resolution" --threads "${THREADS:-0}" \
    --out "$out/$name" >"$out/$name.log" 2>&1; } 2>"$out/$name.times" || code=$?
  if [ "$code" -ne 0 ]; then status=1; fi
  row "$out/$name" "$code" "$(cat "$out/$name.times")"
  rm "$out/$name.times"
done
exit "$status"
)

# tables.sh extreme [--responses | --integrators | --limiters] [OPTION OF selvedge stability]...: runs the scenes of
# data/extreme and writes how each ends, without the answers that the tests know, to docs/lab/tables/extreme_cases.csv.
# With one of the families it runs every scene with each method of it and writes the counts of the answers and the scenes
# whose answers differ, one column for each method, to docs/lab/tables/extreme_responses.csv, extreme_integrators.csv or extreme_limiters.csv. SELVEDGE
# names the program (default: build/release/apps/selvedge). The table includes failed scenes; the script then exits with 1.
table_extreme() (
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${SELVEDGE:-build/release/apps/selvedge}
family= methods=
case ${1:-} in
  --responses | --integrators | --limiters) family=${1#--} methods=all ;;
esac
if [ -n "$family" ]; then shift; fi
printed=$(mktemp)
trap 'rm -f "$printed"' EXIT
status=0
"$program" stability data/extreme ${family:+"--$family" "$methods"} "$@" >"$printed" || status=$?
if [ "$status" -gt 1 ]; then exit "$status"; fi

# Rows have the form "| `case` | answer | ... |"; the program writes "/" for a "|" within a cell.
quote='function quote(cell) { gsub(/`/, "", cell); if (cell ~ /[",]/) { gsub(/"/, "\"\"", cell); cell = "\"" cell "\"" } return cell }'
if [ -z "$family" ]; then
  awk -F ' [|] ' "$quote"'
    BEGIN { print "case,answer,detail,stretch_percent,crossings,worst_speed_m_s,energy_ratio,energy_given_mJ,wall_s" }
    /^[|] `/ {
      sub(/^[|] /, ""); sub(/ [|]$/, "")
      for (i = 1; i <= NF; ++i) printf "%s%s", quote($i), i < NF ? "," : "\n"
    }' "$printed" >docs/lab/tables/extreme_cases.csv
else
  awk -F ' [|] ' "$quote"'
    /^[|] `/ {
      sub(/^[|] /, "")
      if (!($1 in known)) { known[$1]; cases[++rows] = $1 }
      if (!($2 in tried)) { tried[$2]; method[++count] = $2 }
      answer[$1, $2] = $3
      note[$1, $2] = $3 ($3 == "correct" || $4 == "" ? "" : ": " $4)
      ++ends[$2, $3]
    }
    END {
      printf "case"
      for (k = 1; k <= count; ++k) printf ",%s", method[k]
      split("correct degraded refused unfinished FAILED", kind, " ")
      for (e = 1; e in kind; ++e) {
        printf "\nall: %s", kind[e]
        for (k = 1; k <= count; ++k) printf ",%d", ends[method[k], kind[e]]
      }
      print ""
      for (r = 1; r <= rows; ++r) {
        differs = 0
        for (k = 2; k <= count; ++k) differs += answer[cases[r], method[k]] != answer[cases[r], method[1]]
        if (!differs) continue
        printf "%s", quote(cases[r])
        for (k = 1; k <= count; ++k) printf ",%s", quote(note[cases[r], method[k]])
        print ""
      }
    }' "$printed" >"docs/lab/tables/extreme_$family.csv"
fi
tail -n 1 "$printed"
exit "$status"
)

# tables.sh mesh [--quick | --only NAME]: hangs and drapes one fabric on every mesh at three refinements (data/meshes)
# and writes docs/lab/tables/mesh_hang.csv and docs/lab/tables/mesh_drape.csv. SELVEDGE names the program (default:
# build/release/apps/selvedge). --quick: runs two coarse refinements and prints the tables. --only: hang or drape. Uses
# one core and takes minutes.
table_mesh() (
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
names="hang drape"
case "${1:-}" in
  "" | --quick) ;;
  --only) names=${2:?which table?} ;;
  *) echo "usage: scripts/tables.sh mesh [--quick | --only NAME]" >&2; exit 2 ;;
esac
case "$names" in
  "hang drape" | hang | drape) ;;
  *) echo "tables.sh mesh: there is no table '$names'" >&2; exit 2 ;;
esac
program=${SELVEDGE:-build/release/apps/selvedge}
if ! command -v "$program" >/dev/null; then
  echo "tables.sh mesh: there is no program '$program'; build it, or name it in SELVEDGE" >&2
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
    command = [PROGRAM, "run", f"data/meshes/{scene}.json", "--out", out, "--threads", "1", "--no-pictures"]
    for value in settings:
        command += ["--set", value]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"tables.sh mesh: {' '.join(command)}: {done.stdout}")
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
)

# tables.sh narrow_phase FOLDER [OPTION OF selvedge ccd]...: runs every narrow phase of the build on all query files in
# FOLDER and writes docs/lab/tables/narrow_phase.csv: all queries of a kind together, then each family (subfolder of FOLDER)
# alone. Also writes the rows of all queries into docs/lab/narrow_phase.md, between its markers. Builds the program first,
# unless SELVEDGE_PROGRAM names one.
table_narrow_phase() (
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [ $# -eq 0 ] || [ ! -d "$1" ]; then
  echo "usage: scripts/tables.sh narrow_phase FOLDER [OPTION OF selvedge ccd]..., FOLDER with query files; 'selvedge run" \
    "SCENE --record FOLDER' makes some" >&2
  exit 2
fi
folder=$1
shift

program=${SELVEDGE_PROGRAM:-}
if [ -z "$program" ]; then
  cmake --preset release -S "$root" >/dev/null
  cmake --build --preset release --target selvedge_program >/dev/null
  program=$root/build/release/apps/selvedge
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)
for merge in kind family; do
  "$program" ccd "$folder" --narrow-phase all --markdown --merge "$merge" "$@"
done >"$work/tables.md"

# Merges all tables into one: a heading such as "### stress: 300 edge_edge queries, 152 collide" becomes four columns.
csv=$root/docs/lab/tables/narrow_phase.csv
mkdir -p "${csv%/*}"
awk '
  /^### / {
    split(substr($0, 5), part, ": ")
    name = part[1]
    split(part[2], word, " ")
    next
  }
  /^\| *---/ { next }
  /^\| *\|/ {
    if (!seen++) { sub(/^\| *\|/, "| queries | kind | count | collide | method |"); print }
    next
  }
  /^\|/ { print "| " name " | " word[2] " | " word[1] " | " word[4] " " $0 }' "$work/tables.md" |
  "$root/scripts/tables.sh" csv >"$csv"

# Columns of the CSV: 1 queries, 2 kind, 3 count, 4 collide, 5 method, 6 misses, 7 false, 8 late, 10 mean us.
{
  echo
  awk -F, '
    $1 != "all" { next }
    { cells = $6 " | " $7 " | " $8 " | " sprintf("%.3f", $10) }
    $2 == "edge_edge" { edges = $3 " edge-edge queries (" $4 " collide)"; edge[$5] = cells }
    $2 == "point_triangle" { points = $3 " point-triangle queries (" $4 " collide)"; point[$5] = cells; name[++n] = $5 }
    END {
      print "Left: " edges ". Right: " points ".\n"
      print "| method | misses | false | late | mean us | misses | false | late | mean us |"
      print "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
      for (i = 1; i <= n; ++i) print "| `" name[i] "` | " edge[name[i]] " | " point[name[i]] " |"
    }' "$csv"
  echo
  echo "All rows: [docs/lab/tables/narrow_phase.csv](tables/narrow_phase.csv). Measured $(date +%Y-%m-%d) on" \
    "${processor:-an unnamed processor}, one thread."
  echo
} >"$work/short.md"

page=$root/docs/lab/narrow_phase.md
awk -v table="$work/short.md" '
  /<!-- end of the table -->/ { inside = 0 }
  !inside { print }
  /<!-- table by scripts\/tables.sh narrow_phase -->/ {
    inside = 1
    while ((getline line < table) > 0) print line
  }' "$page" >"$work/page.md"
cat "$work/page.md" >"$page"
echo "written: $csv and $page"
)

# tables.sh plan [--print] [FRAMES]: measures how much time `selvedge plan` saves on every scene of data/scenes,
# data/extreme and data/experiments, over its first FRAMES frames (default 10), and writes docs/lab/tables/plan.csv.
# --print: prints the table instead. SELVEDGE names the program (default: build/release/apps/selvedge). Takes minutes on
# one core. Fails if a scene ends with different bits without proofs than with them.
table_plan() (
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
sys.exit(f"tables.sh plan: other bits without proofs: {', '.join(broken)}" if broken else 0)
PYTHON
)

# tables.sh response [OPTION OF bench_response]...: measures every response on scenes with closed forms, and the survey's
# claims on responses. Writes docs/lab/tables/response.csv, a table for each claim (response_c9.csv and so on), and a short
# table into docs/lab/response.md, between its markers. Prints the sentences that are not part of a table. Builds the
# program first, unless SELVEDGE_BENCH names its folder.
table_response() (
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

bench=${SELVEDGE_BENCH:-}
if [ -z "$bench" ]; then
  cmake --preset release -DSELVEDGE_BENCH=ON -S "$root" >/dev/null
  cmake --build --preset release --target selvedge_bench >/dev/null
  bench=$root/build/release/bench
fi

tables=$root/docs/lab/tables
page=$root/docs/lab/response.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
processor=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)

# The table before the first heading becomes response.csv; a heading such as "### C9: ..." starts response_c9.csv.
"$bench/bench" response "$@" | tee "$work/all.md" | awk -v work="$work" '
  BEGIN { name = "response" }
  /^### C[0-9]+:/ { name = "response_" tolower(substr($2, 1, length($2) - 1)); next }
  /^\|/ { print >(work "/" name ".table") }'
mkdir -p "$tables"
for table in "$work"/*.table; do
  name=$(basename "$table" .table)
  "$root/scripts/tables.sh" csv <"$table" >"$tables/$name.csv"
done
grep -v '^|' "$work/all.md" || true

# Cells of a row: 2 scene, 3 response, 4 seconds, 9 error, 13 RMS speed at the end.
if [ -f "$work/response.table" ]; then
  {
    echo
    echo "| response | slope slides, error | slope holds, mm/s | capstan holds, mm/s | ball, s | capstan, s | stack, s |" \
      "stack moves, mm/s |"
    echo "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"
    awk -F' *[|] *' '
      $2 == "incline, slides" { name[++n] = $3; slides[$3] = $9 }
      $2 == "incline, sticks" { sub(/ mm\/s/, "", $9); holds[$3] = $9 }
      $2 == "capstan, holds" { sub(/ mm\/s/, "", $9); capstan[$3] = $9; capstan_s[$3] = $4 }
      $2 == "ball" { ball_s[$3] = $4 }
      $2 ~ /^stack/ { stack_s[$3] = $4; moves[$3] = $13 }
      END {
        for (i = 1; i <= n; ++i) {
          r = name[i]
          print "| `" r "` | " slides[r] " | " holds[r] " | " capstan[r] " | " ball_s[r] " | " capstan_s[r] " | " \
            stack_s[r] " | " moves[r] " |"
        }
      }' "$work/response.table"
    echo
    echo "All columns and scenes: [docs/lab/tables/response.csv](tables/response.csv), by \`bench response${*:+ $*}\`. Measured" \
      "$(date +%Y-%m-%d) on ${processor:-an unnamed processor}, one thread, seconds of processor time."
    echo
  } >"$work/short.md"
  awk -v table="$work/short.md" '
    /<!-- end of table -->/ { inside = 0 }
    !inside { print }
    /<!-- table by scripts\/tables.sh response -->/ {
      inside = 1
      while ((getline line < table) > 0) print line
    }' "$page" >"$work/page.md"
  cat "$work/page.md" >"$page"
fi
echo "written: $tables/response*.csv and $page"
)

# tables.sh size [BUILD_DIR]: prints the size of a program with the lean parts of a finished build (core, broad phase,
# narrow phase; dependent on Eigen only), and the size that each optional library would add: our adapter in BUILD_DIR
# (build/release) and its shared libraries, excluding those that every C++ program uses.
table_size() (
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=${1:-build/release}
compiler=${CXX:-c++}
eigen=${EIGEN_INCLUDE:-/usr/include/eigen3}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

everywhere='linux-vdso|ld-linux|libc\.so|libm\.so|libstdc\+\+|libgcc_s'

# Bytes of the shared libraries that a file needs, excluding those that every C++ program uses.
shared_bytes() {
  { ldd "$1" | grep -Ev "$everywhere" | awk '$2 == "=>" && $3 ~ /^\// {print $3}' || true; } |
    sort -u | xargs -r stat -L -c %s | awk '{sum += $1} END {print sum + 0}'
}
shared_names() {
  { ldd "$1" | grep -Ev "$everywhere" | awk '$2 == "=>" {print $1}' || true; } | sort -u | wc -l
}
kilobytes() { awk -v bytes="$1" 'BEGIN {printf "%.0f", bytes / 1000}'; }

# Links tests/consumer/shards.cpp with the detectors of BUILD_DIR. Only core/base/parallel.cpp uses threads. Compiled without
# threads, it replaces the archive's version, so the lean program needs no separate build.
program() {
  local name=$1 label=$2 threads=$3
  local flags=(-std=c++20 -O3 -DNDEBUG -ffp-contract=off -I "$build/include" -isystem "$eigen")
  local objects=() libraries=("$build"/{broadphase/libselvedge_broadphase,narrowphase/libselvedge_narrowphase,bodies/libselvedge_bodies,core/base/libselvedge_base}.a)
  "$compiler" "${flags[@]}" -c tests/consumer/shards.cpp -o "$work/shards.o"
  objects=("$work/shards.o")
  if [ "$threads" = no ]; then
    "$compiler" "${flags[@]}" -c core/base/parallel.cpp -o "$work/parallel.o"
    objects+=("$work/parallel.o")
  else
    libraries+=(-ltbb)
  fi
  "$compiler" "${objects[@]}" -Wl,--start-group "${libraries[@]}" -Wl,--end-group -o "$work/$name"
  strip "$work/$name"
  "$work/$name" >/dev/null
  echo "| $label | $(kilobytes "$(stat -c %s "$work/$name")") | $(kilobytes "$(shared_bytes "$work/$name")") | $(shared_names "$work/$name") |"
}

echo "| program or library | our code, kB | shared libraries, kB | libraries |"
echo "| --- | ---: | ---: | ---: |"
program lean "detectors alone, no threads: Eigen only" no
program threads "the same with threads (oneTBB)" yes

adapter() {
  local label=$1 archive=$2 library=$3
  local file
  file=$(ldconfig -p | awk -v name="$library" '$1 ~ "^"name && !found {print $NF; found = 1}')
  if [ -z "$file" ]; then echo "| $label | not here | | |"; return; fi
  local ours=0
  if [ -n "$archive" ] && [ -f "$build/$archive" ]; then ours=$(size -t "$build/$archive" | awk 'END {print $4}'); fi
  local bytes=$(($(stat -L -c %s "$file") + $(shared_bytes "$file")))
  echo "| $label | $(kilobytes "$ours") | $(kilobytes "$bytes") | $(($(shared_names "$file") + 1)) |"
}
adapter "FCL, broad phase" broadphase/libselvedge_broadphase_fcl.a 'libfcl\.so'
adapter "FCL, narrow phase" narrowphase/libselvedge_narrowphase_fcl.a 'libfcl\.so'
adapter "libccd" narrowphase/libselvedge_narrowphase_libccd.a 'libccd\.so'
adapter "CGAL (templates; GMP and MPFR)" broadphase/libselvedge_broadphase_cgal.a 'libmpfr\.so'
adapter "Embree" broadphase/libselvedge_broadphase_embree.a 'libembree[34]\.so'
adapter "OSMesa, image space" broadphase/libselvedge_broadphase_osmesa.a 'libOSMesa\.so'
adapter "assimp, meshes of other formats" "" 'libassimp\.so'
)

# tables.sh csv < PAGE.md > TABLE.csv: prints every Markdown table row of the standard input as a CSV row. Drops other
# lines and the rules below table heads. Quotes cells that contain a comma or a quotation mark.
table_csv() (
awk '
  !/^\|/ || /^\|[-: |]+\|$/ { next }
  {
    sub(/^\| */, "")
    sub(/ *\| *$/, "")
    cells = split($0, cell, / *\| */)
    row = ""
    for (i = 1; i <= cells; ++i) {
      if (cell[i] ~ /[",]/) {
        gsub(/"/, "\"\"", cell[i])
        cell[i] = "\"" cell[i] "\""
      }
      row = row (i > 1 ? "," : "") cell[i]
    }
    print row
  }'
)

name=${1:-}
if [ "$(type -t "table_$name")" != function ]; then
  echo "usage: scripts/tables.sh NAME [OPTIONS]; NAME is one of $(compgen -A function table_ | sed 's/table_//' | tr '\n' ' ')" >&2
  exit 2
fi
shift
"table_$name" "$@"
