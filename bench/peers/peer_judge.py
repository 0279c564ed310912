# SPDX-License-Identifier: MIT
"""peer_judge.py FOLDER SELVEDGE SCENE...: judges the frames that peers.sh has made and writes peers.json and peers.md."""
import json
import math
import shutil
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

GRAVITY = 9.81  # m/s^2
BATCH = 40  # meshes of one call


def check(selvedge, frames, body):
    found = []
    for k in range(0, len(frames), BATCH):
        command = [selvedge, "check", *map(str, frames[k:k + BATCH]), "--against", str(body), "--rest",
                   str(frames[0]), "--json"]
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
        if answer.returncode not in (0, 1):
            raise SystemExit(answer.stderr.strip())
        found += json.loads(answer.stdout)["results"]
    return found


def centre_of_obj(file):
    points = [[float(w) for w in line.split()[1:4]] for line in file.read_text(encoding="ascii").splitlines()
              if line.startswith("v ")]
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def centre_of_ply(file):
    """A binary little-endian PLY file of selvedge: double x, y, z first."""
    import struct
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
    total = [0.0, 0.0, 0.0]
    for i in range(count):
        for k, value in enumerate(struct.unpack_from("<3d", data, i * stride)):
            total[k] += value
    return [t / count for t in total]


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


def draw(selvedge, frame, body, picture):
    """Draws a frame with its body, as the only frame of a result folder."""
    with tempfile.TemporaryDirectory() as work:
        frames = Path(work) / "frames"
        frames.mkdir()
        if frame.suffix == ".ply":
            shutil.copy(frame, frames / "cloth_00000.ply")
        else:
            write_ply(frames / "cloth_00000.ply", *read_obj(frame))
        write_ply(frames / "bodies_00000.ply", *read_obj(body))
        at = (centre_of_ply if frame.suffix == ".ply" else centre_of_obj)(frame)
        eye = [a + d for a, d in zip(at, (0.55, -0.95, 0.55))]
        command = [selvedge, "render", work, "--out", str(Path(work) / "pictures"), "--size", "480x360",
                   "--target", ",".join(map(str, at)), "--eye", ",".join(map(str, eye))]
        answer = subprocess.run(command, capture_output=True, text=True, check=False)
        if answer.returncode != 0:
            raise SystemExit(answer.stderr.strip())
        (drawn,) = (Path(work) / "pictures").glob("*.png")
        shutil.copy(drawn, picture)


def slide(frames, slope):
    centre = centre_of_ply if frames[0].suffix == ".ply" else centre_of_obj
    a, b = centre(frames[0]), centre(frames[-1])
    angle = math.radians(slope)
    return (b[0] - a[0]) * math.cos(angle) - (b[2] - a[2]) * math.sin(angle)


def runs_of(folder, selvedge):
    """Name, frames and report of each program that has finished."""
    if (folder / "selvedge" / "result.json").exists():
        seconds = sum(map(float, (folder / "selvedge.seconds").read_text(encoding="ascii").split()))
        version = subprocess.run([selvedge, "--version"], capture_output=True, text=True, check=True).stdout
        yield ("selvedge", sorted((folder / "selvedge" / "frames").glob("cloth_*.ply")),
               {"program": version.splitlines()[0], "seconds": seconds,
                "settings": "the defaults of a scene; friction 0.3; self-collision; the time includes reading and writing"})
    for name in ("blender", "bullet", "mujoco", "mujoco_ipc"):
        report = folder / name / "report.json"
        if report.exists():
            yield (name, sorted((folder / name).glob("frame_*.obj")), json.loads(report.read_text(encoding="utf-8")))


def judge(out, scene, selvedge):
    folder = out / scene
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    for name, frames, report in runs_of(folder, selvedge):
        if len(frames) != case["frames"] + 1:
            raise SystemExit("%s of %s has %d frames, not %d" % (name, scene, len(frames), case["frames"] + 1))
        found = check(selvedge, frames, folder / "body.obj")
        crossings = [f["self_intersections"] + f["body_intersections"] for f in found]
        badness = [(c, f["max_penetration_m"], f["max_stretch"]) for c, f in zip(crossings, found)]
        worst = badness.index(max(badness))
        picture = folder / (name + "_worst.png")
        draw(selvedge, frames[worst], folder / "body.obj", picture)
        seconds = case["frames"] / 60
        angle = math.radians(case["slope_deg"])
        pull = max(0.0, math.sin(angle) - case["friction"] * math.cos(angle))
        # Constant friction from the start, less that of the way down, on which the sheet touches nothing.
        coulomb = 0.5 * GRAVITY * pull * seconds ** 2 + case["friction"] * case["clearance"]
        yield {
            "scene": scene, "name": name, "program": report["program"], "settings": report["settings"],
            "frames": len(frames) - 1, "frames_with_crossings": sum(c > 0 for c in crossings),
            "most_body_crossings": max(f["body_intersections"] for f in found),
            "most_self_crossings": max(f["self_intersections"] for f in found),
            "deepest_penetration_m": max(f["max_penetration_m"] for f in found),
            "largest_stretch": max(f["max_stretch"] for f in found),
            "seconds_a_frame": report["seconds"] / case["frames"],
            "slid_m": slide(frames, case["slope_deg"]) if scene == "incline" else None,
            "coulomb_m": coulomb if scene == "incline" else None,
            "worst_frame": worst, "picture": str(picture.relative_to(out)),
        }


def page(rows, missing, case):
    text = ["# The same sheet in several programs", "",
            "%s. A sheet of %g m with %d x %d cells and %g kg/m² falls for %d frames at 60 frames/s." %
            (date.today().isoformat(), case["size"], case["cells"], case["cells"], case["density"], case["frames"]),
            "Every frame was judged by `selvedge check`; strain is relative to frame 0.", "",
            "| scene | program | frames with crossings | most with the body | most with itself | deepest, mm | "
            "largest stretch, % | processor s a frame | worst frame |",
            "| --- | --- | --: | --: | --: | --: | --: | --: | --- |"]
    for r in rows:
        text.append("| %s | %s | %d of %d | %d | %d | %.2f | %.1f | %.4f | [%d](%s) |" % (
            r["scene"], r["program"], r["frames_with_crossings"], r["frames"] + 1, r["most_body_crossings"],
            r["most_self_crossings"], 1e3 * r["deepest_penetration_m"], 100 * r["largest_stretch"],
            r["seconds_a_frame"], r["worst_frame"], r["picture"]))
    text += ["", "Friction %g on an incline of %g degrees:" % (case["friction"], case["slope_deg"]), "",
             "| program | slid, m | Coulomb, m |", "| --- | --: | --: |"]
    for r in rows:
        if r["slid_m"] is not None:
            text.append("| %s | %.3f | %.3f |" % (r["program"], r["slid_m"], r["coulomb_m"]))
    text += ["", "The frame with the most crossings of each run; without any, the frame with the largest stretch:", ""]
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
    case = json.loads((out / "ball" / "case.json").read_text(encoding="utf-8"))
    (out / "peers.json").write_text(json.dumps({"rows": rows, "missing": missing}, indent=1) + "\n", encoding="utf-8")
    (out / "peers.md").write_text(page(rows, missing, case), encoding="utf-8")


main()
