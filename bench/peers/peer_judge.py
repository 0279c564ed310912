# SPDX-License-Identifier: MIT
"""peer_judge.py FOLDER SELVEDGE SCENE...: judges the frames that peers.sh has made and writes peers.json and peers.md."""
import json
import math
import shutil
import struct
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

GRAVITY = 9.81  # m/s^2
FPS = 60
BATCH = 40  # meshes of one call
HOLDS_M = 0.001  # m: a strip that moves less holds
EYE = (0.55, -0.95, 0.55)  # m, from the middle of the cloth
AT_END = ("jaws", "floor", "seam")  # without crossings, their picture is the last frame
# What a program cannot say of a scene of its own. A body that moves as prescribed is possible in all.
CANNOT = {
    ("jaws", "blender"): "cannot load an edge: the load is spread over the strip; its friction is no coefficient",
    ("jaws", "mujoco_ipc"): "has no friction",
}


def check(selvedge, frames, bodies):
    """`bodies`: one for all frames, or one for each."""
    found = []
    for k in range(0, len(frames), BATCH):
        against = bodies if len(bodies) == 1 else bodies[k:k + BATCH]
        command = [selvedge, "check", *map(str, frames[k:k + BATCH]), "--against", *map(str, against), "--rest",
                   str(frames[0]), "--json"]
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
        if answer.returncode not in (0, 1):
            raise SystemExit(answer.stderr.strip())
        found += json.loads(answer.stdout)["results"]
    return found


def points_of_ply(file):
    """A binary little-endian PLY file of selvedge: double x, y, z first."""
    head, data = file.read_bytes().split(b"end_header\n", 1)
    sizes = {"double": 8, "float": 4, "int": 4, "uchar": 1}
    count, stride = 0, 0
    for line in head.decode("ascii").splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[0] == "element":
            break
        elif words[0] == "property":
            if stride < 24 and words[1:] != ["double", "xyz"[stride // 8]]:
                raise SystemExit("%s: unexpected property %s" % (file, line))
            stride += sizes[words[1]]
    return [struct.unpack_from("<3d", data, i * stride) for i in range(count)]


def points_of(file):
    return points_of_ply(file) if file.suffix == ".ply" else read_obj(file)[0]


def centre_of(file):
    points = points_of(file)
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def read_obj(file):
    points, faces = [], []
    for line in file.read_text(encoding="ascii").splitlines():
        words = line.split()
        if words[0] == "v":
            points.append(tuple(map(float, words[1:4])))
        elif words[0] == "f":
            faces.append([int(w) - 1 for w in words[1:4]])
    return points, faces


def write_ply(file, points, faces):
    head = ["ply", "format ascii 1.0", "element vertex %d" % len(points), "property double x", "property double y",
            "property double z", "element face %d" % len(faces), "property list uchar int vertex_indices", "end_header"]
    rows = ["%.17g %.17g %.17g" % p for p in points] + ["3 %d %d %d" % tuple(f) for f in faces]
    file.write_text("\n".join(head + rows) + "\n", encoding="ascii")


def shift_at(keys, time):
    """Where the keys [time, x, y, z] of a program have taken a body."""
    for a, b in zip(keys, keys[1:]):
        if time < b[0]:
            return [p + (time - a[0]) / (b[0] - a[0]) * (q - p) for p, q in zip(a[1:], b[1:])]
    return keys[-1][1:] if keys else [0.0, 0.0, 0.0]


def write_bodies(folder, case, name, count, work):
    """The bodies of each frame of a program as one file, or of all frames if nothing moves."""
    parts = [(read_obj(folder / ("part_%d.obj" % k)), part["motion"].get(name, []))
             for k, part in enumerate(case["parts"])]
    files = []
    for frame in range(count if any(keys for _, keys in parts) else 1):
        points, faces = [], []
        for (own, triangles), keys in parts:
            by = shift_at(keys, frame / FPS)
            faces += [[i + len(points) for i in f] for f in triangles]
            points += [tuple(a + b for a, b in zip(p, by)) for p in own]
        files.append(work / ("bodies_%04d.ply" % frame))
        write_ply(files[-1], points, faces)
    return files


def draw(selvedge, frame, body, picture, at, near):
    """Draws a frame with its body, as the only frame of a result folder."""
    with tempfile.TemporaryDirectory() as work:
        frames = Path(work) / "frames"
        frames.mkdir()
        if frame.suffix == ".ply":
            shutil.copy(frame, frames / "cloth_00000.ply")
        else:
            write_ply(frames / "cloth_00000.ply", *read_obj(frame))
        shutil.copy(body, frames / "bodies_00000.ply")
        eye = [a + near * d for a, d in zip(at, EYE)]
        command = [selvedge, "render", work, "--out", str(Path(work) / "pictures"), "--size", "480x360",
                   "--target", ",".join(map(str, at)), "--eye", ",".join(map(str, eye))]
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
        if answer.returncode != 0:
            raise SystemExit(answer.stderr.strip())
        (drawn,) = (Path(work) / "pictures").glob("*.png")
        shutil.copy(drawn, picture)


def slide(frames, slope):
    a, b = centre_of(frames[0]), centre_of(frames[-1])
    angle = math.radians(slope)
    return (b[0] - a[0]) * math.cos(angle) - (b[2] - a[2]) * math.sin(angle)


def sunk(case, frames):
    """How far the vertices that are between the jaws when the handle lets go sink until the end, m; all if there are none."""
    start, end = points_of(frames[round(case["release_s"] * FPS)]), points_of(frames[-1])
    low, high = case["gripped_m"]
    gripped = [i for i, p in enumerate(start) if low <= p[2] <= high] or range(len(start))
    return sum(start[i][2] - end[i][2] for i in gripped) / len(gripped)


def runs_of(folder, selvedge):
    """Name, frames and report of each program that has finished."""
    if (folder / "selvedge" / "result.json").exists():
        seconds = sum(map(float, (folder / "selvedge.seconds").read_text(encoding="ascii").split()))
        version = subprocess.run([selvedge, "--version"], capture_output=True, text=True, check=True).stdout
        yield ("selvedge", sorted((folder / "selvedge" / "frames").glob("cloth_*.ply")),
               {"program": version.splitlines()[0], "seconds": seconds,
                "settings": "the defaults of a scene; self-collision; the time includes reading and writing"})
    for name in ("blender", "bullet", "mujoco", "mujoco_ipc"):
        report = folder / name / "report.json"
        if report.exists():
            yield (name, sorted((folder / name).glob("frame_*.obj")), json.loads(report.read_text(encoding="utf-8")))


def coulomb(case, seconds):
    angle = math.radians(case["slope_deg"])
    pull = max(0.0, math.sin(angle) - case["friction"] * math.cos(angle))
    # Constant friction from the start, less that of the way down, on which the sheet touches nothing.
    return 0.5 * GRAVITY * pull * seconds ** 2 + case["friction"] * case["clearance"]


def measures_of(scene, case, frames):
    """What only this scene measures."""
    if scene == "incline":
        return {"slid_m": slide(frames, case["slope_deg"]), "coulomb_m": coulomb(case, case["frames"] / FPS)}
    if scene == "jaws":
        return {"sunk_m": sunk(case, frames), "seconds": case["frames"] / FPS - case["release_s"]}
    if scene in ("floor", "seam"):
        return {"slid_m": centre_of(frames[-1])[0] - centre_of(frames[0])[0],
                "free_m": 0.5 * case["gravity"][0] * (case["frames"] / FPS) ** 2}
    return {}


def judge(out, scene, selvedge):
    folder = out / scene
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    for name, frames, report in runs_of(folder, selvedge):
        if len(frames) != case["frames"] + 1:
            raise SystemExit("%s of %s has %d frames, not %d" % (name, scene, len(frames), case["frames"] + 1))
        with tempfile.TemporaryDirectory() as work:
            bodies = write_bodies(folder, case, name, len(frames), Path(work))
            found = check(selvedge, frames, bodies)
            crossings = [f["self_intersections"] + f["body_intersections"] for f in found]
            badness = [(c, f["max_penetration_m"], f["max_stretch"]) for c, f in zip(crossings, found)]
            worst = badness.index(max(badness))
            if scene in AT_END and max(crossings) == 0:
                worst = len(frames) - 1
            picture = folder / (name + "_worst.png")
            at, near = (case["centre"], 0.55) if scene == "jaws" else (centre_of(frames[worst]), 1.0)
            draw(selvedge, frames[worst], bodies[min(worst, len(bodies) - 1)], picture, at, near)
        yield {
            "scene": scene, "name": name, "program": report["program"], "settings": report["settings"],
            "frames": len(frames) - 1, "frames_with_crossings": sum(c > 0 for c in crossings),
            "most_body_crossings": max(f["body_intersections"] for f in found),
            "most_self_crossings": max(f["self_intersections"] for f in found),
            "deepest_penetration_m": max(f["max_penetration_m"] for f in found),
            "largest_stretch": max(f["max_stretch"] for f in found),
            "seconds_a_frame": report["seconds"] / case["frames"],
            "cannot": CANNOT.get((scene, name), ""),
            **measures_of(scene, case, frames),
            "worst_frame": worst, "picture": str(picture.relative_to(out)),
        }


def friction_table(rows):
    own = [r for r in rows if r["scene"] == "incline"]
    if not own:
        return []
    return ["", "Friction on the incline:", "", "| program | slid, m | Coulomb, m |", "| --- | --: | --: |"] + [
        "| %s | %.3f | %.3f |" % (r["program"], r["slid_m"], r["coulomb_m"]) for r in own]


def grip_word(row):
    if abs(row["sunk_m"]) < HOLDS_M:
        return "holds"
    return "falls out" if row["sunk_m"] > 0.2 else "creeps"


def grip_table(rows):
    own = [r for r in rows if r["scene"] == "jaws"]
    if not own:
        return []
    head = ["", "The strip in the jaws, %.2f s after its handle has let go (negative: it rises):" % own[0]["seconds"], "",
            "| program | sank, mm | | largest stretch, % | limits |", "| --- | --: | --- | --: | --- |"]
    return head + ["| %s | %.2f | %s | %.1f | %s |" % (
        r["program"], 1e3 * r["sunk_m"], grip_word(r), 100 * r["largest_stretch"], r["cannot"]) for r in own]


def short(two, one):
    """By how much the slide over two boxes is shorter, or why that says nothing."""
    if one["slid_m"] < 0.5 * one["free_m"]:
        return "does not slide on one box"
    return "%.2f" % (100 * (1 - two["slid_m"] / one["slid_m"]))


def seam_table(rows):
    whole = {r["name"]: r for r in rows if r["scene"] == "floor"}
    own = [r for r in rows if r["scene"] == "seam" and r["name"] in whole]
    if not own:
        return []
    head = ["", "The sheet on one box and on two flush boxes, without friction; free, it slides %.3f m:" % own[0]["free_m"], "",
            "| program | one box, m | two boxes, m | short, % |", "| --- | --: | --: | --: |"]
    return head + ["| %s | %.4f | %.4f | %s |" % (
        r["program"], whole[r["name"]]["slid_m"], r["slid_m"], short(r, whole[r["name"]])) for r in own]


def page(rows, missing):
    text = ["# The same cloth in several programs", "",
            "%s. %d frames and more at 60 frames/s; the scenes are `scene.json` in the folders." %
            (date.today().isoformat(), min(r["frames"] for r in rows)),
            "Every frame was judged by `selvedge check`; strain is relative to frame 0.", "",
            "| scene | program | frames with crossings | most with the body | most with itself | deepest, mm | "
            "largest stretch, % | processor s a frame | worst frame |",
            "| --- | --- | --: | --: | --: | --: | --: | --: | --- |"]
    for r in rows:
        text.append("| %s | %s | %d of %d | %d | %d | %.2f | %.1f | %.4f | [%d](%s) |" % (
            r["scene"], r["program"], r["frames_with_crossings"], r["frames"] + 1, r["most_body_crossings"],
            r["most_self_crossings"], 1e3 * r["deepest_penetration_m"], 100 * r["largest_stretch"],
            r["seconds_a_frame"], r["worst_frame"], r["picture"]))
    text += friction_table(rows) + grip_table(rows) + seam_table(rows)
    text += ["", "The frame with the most crossings of each run; without any, the frame with the largest stretch, or the last "
             "frame of %s:" % ", ".join(AT_END), ""]
    for scene in dict.fromkeys(r["scene"] for r in rows):
        of = [r for r in rows if r["scene"] == scene]
        text += ["| " + " | ".join("%s, %s" % (scene, r["program"]) for r in of) + " |", "| --- " * len(of) + "|",
                 "| " + " | ".join("![frame %d](%s)" % (r["worst_frame"], r["picture"]) for r in of) + " |", ""]
    text += ["Settings:", ""]
    for name in dict.fromkeys(r["program"] for r in rows):
        text.append("- %s: %s" % (name, next(json.dumps(r["settings"]) for r in rows if r["program"] == name)))
    text += ["- not run: " + line for line in missing]
    return "\n".join(text) + "\n"


def main():
    out, selvedge, scenes = Path(sys.argv[1]), sys.argv[2], sys.argv[3:]
    rows = [row for scene in scenes for row in judge(out, scene, selvedge)]
    if not rows:
        raise SystemExit("no program has finished a run; see the logs in " + str(out))
    missing = (out / "missing.txt").read_text(encoding="utf-8").splitlines()
    (out / "peers.json").write_text(json.dumps({"rows": rows, "missing": missing}, indent=1) + "\n", encoding="utf-8")
    (out / "peers.md").write_text(page(rows, missing), encoding="utf-8")
    print("judged: " + ", ".join(dict.fromkeys(r["program"] for r in rows)))


main()
