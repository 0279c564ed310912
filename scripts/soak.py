#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""soak.py HOURS: random scenes, one after another, each run and then judged by `selvedge check`.

    scripts/soak.py 2                       # two hours, seeds 1, 2, 3, ...
    scripts/soak.py 0.1 --seed 1000         # six minutes, seeds 1000, 1001, ...
    scripts/soak.py 0 --only 17             # seed 17 once
    scripts/soak.py 0 --again out/soak/17   # a kept failure once more

The scenes draw from every broad phase, narrow phase, response, fail-safe, integrator, strain limiter and cloth pattern
that `selvedge list` has, with random options, shapes, motions, materials and start velocities. A seed gives the same
scene on every machine. A scene fails if
- the program ends by a signal, with an exit code other than 0, 1 or 2, or takes more than --budget seconds of processor time;
- it is refused (exit code 2) with more or less than one sentence;
- its result is called clean, or its methods promise to miss nothing, and the judge finds an intersection in a state or,
  if the methods promise that, on a path: a method that may miss collisions may leave some on paths of a clean run;
- its memory grows above --memory MB, or it holds more files at the end than at its middle.
Every failure stays in out/soak/SEED: the scene, what happened, and a smaller scene that fails alike. The last lines say
how many scenes ran and how they ended. Exit code 1: a scene failed.
"""
import argparse
import collections
import copy
import json
import math
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def registry(program):
    methods = json.loads(subprocess.run([program, "list", "--json"], capture_output=True, text=True, check=True).stdout)
    families = collections.defaultdict(list)
    for method in methods["methods"]:
        if method["available"]:
            families[method["family"]].append(method)
    return families


class Draw:
    """Random values of one seed. Only random(), whose bits Python guarantees, is used."""

    def __init__(self, seed):
        self.random = random.Random(seed).random

    def uniform(self, low, high):
        return low + (high - low) * self.random()

    def power(self, low, high):
        """Of any size between low and high."""
        return low * (high / low) ** self.random()

    def integer(self, low, high):
        return low + int(self.random() * (high - low + 1))

    def chance(self, share):
        return self.random() < share

    def choice(self, values):
        return values[int(self.random() * len(values))]

    def vector(self, size):
        return [round(self.uniform(-size, size), 4) for _ in range(3)]

    def rotation(self):
        axis = self.vector(1.0)
        return {"axis": axis if any(axis) else [0, 0, 1], "angle_deg": round(self.uniform(-180, 180), 2)}

    def option(self, option):
        """A value near the default of an option, now and then one at its bounds."""
        low, high, default = option["min"], option["max"], option["default"]
        if option["type"] == "boolean":
            return self.chance(0.5)
        if option["type"] == "integer":
            near = self.integer(max(int(low), min(500, int(default) // 2)), min(int(high), 1000, 2 * int(default) + 2))
            return int(self.choice([low, min(high, 64)])) if self.chance(0.1) else near
        near = default * self.power(0.3, 3.0) if default > 0 else default
        return min(high, max(low, near)) if near > low or not option["above_min"] else default

    def method(self, family):
        method = self.choice(family)
        options = {o["name"]: self.option(o) for o in method["options"] if self.chance(0.3)}
        return {"type": method["name"], **options}


def shape(draw):
    kind = draw.choice(["plane", "box", "sphere", "capsule", "cylinder", "cone", "torus"])
    resolution = draw.integer(6, 24)
    radius = round(draw.uniform(0.05, 0.35), 3)
    if kind == "plane":
        return {"type": kind, "size": round(draw.uniform(0.5, 4.0), 2)}
    if kind == "box":
        return {"type": kind, "size": [round(draw.uniform(0.05, 0.6), 3) for _ in range(3)]}
    if kind == "sphere":
        return {"type": kind, "radius": radius, "resolution": resolution}
    if kind == "torus":
        return {"type": kind, "radius": radius + 0.1, "tube": round(radius / 3, 3), "resolution": resolution}
    return {"type": kind, "radius": radius, "height": round(draw.uniform(0.05, 0.8), 3), "resolution": resolution}


def motion(draw, seconds):
    keys, at = [{"time": 0}], 0.0
    for _ in range(draw.integer(1, 3)):
        at += round(draw.uniform(0.1, 0.6) * seconds, 4) + 1e-3
        key = {"time": at, "translation": draw.vector(0.3)}
        if draw.chance(0.4):
            key["rotation"] = draw.rotation()
        keys.append(key)
    return keys


def random_scene(seed, families, longest):
    draw = Draw(seed)
    frames = longest if draw.chance(0.03) else draw.integer(3, 24)
    fps = draw.choice([30, 60, 60, 120])
    seconds = frames / fps
    detectors = families["broad_phase"]
    scene = {"name": f"soak_{seed}", "geometry": [], "obstacles": [], "materials": {}}
    for i in range(draw.integer(1, 3)):
        stretch = draw.power(10.0, 1e5)
        pattern = draw.method(families["pattern_of_grids"]) if draw.chance(0.5) else {"type": "rectangular"}
        name = pattern["type"]
        material = {
            "density": draw.power(0.02, 2.0),
            "stretch_stiffness": stretch,
            "bending_stiffness": draw.power(1e-7, 1e-2),
            "friction": draw.choice([0, 0.3, 1.0, 5.0]),
            "strain_limit": draw.power(0.01, 1.0),
        }
        # What a pattern cannot serve is refused; these laws are those that it can.
        if not name.endswith("_net"):
            material["shear_stiffness"] = stretch * draw.uniform(0.01, 0.15)
            laws = {"rectangular": ["shape_operator", "hinge", "bridson", "buckling", "twisting", "beam"],
                    "triangular": ["shape_operator", "hinge", "bridson"]}
            if name in laws and draw.chance(0.4):
                material["bending_law"] = draw.choice(laws[name])
            if name == "rectangular" and draw.chance(0.4):
                material["stretch_law"] = draw.choice(
                    ["tension_only", "biphasic", "kawabata", "st_venant_kirchhoff", "corotated"])
            if "bending_law" not in material and draw.chance(0.2):
                material["bending_friction"] = draw.power(1e-6, 1e-3)
        scene["materials"][f"m{i}"] = material
        columns, cell = draw.integer(1, 14), round(draw.uniform(0.01, 0.08), 4)
        rows = max(1, columns + draw.integer(-3, 3))
        if name == "bilayered":
            ratio = pattern.get("ratio", 4)
            columns = rows = ratio * max(1, columns // ratio)
        if name == "arc":
            rows = columns
        scene["geometry"].append({
            "name": f"cloth{i}",
            "material": f"m{i}",
            "size": [round(cell * columns, 4), round(cell * rows * (1.0 if name == "arc" else draw.uniform(0.9, 1.1)), 4)],
            "cells": [columns, rows],
            "pattern": pattern,
            "velocity": draw.vector(draw.choice([0, 1, 10])),
            # above each other and above the bodies, so that nothing crosses at the start
            "transformation": {"translation": [round(draw.uniform(-0.1, 0.1), 3), 0, round(1.0 + 1.2 * i, 3)],
                               "rotation": draw.rotation()},
        })
    for i in range(draw.integer(0, 3)):
        body = {"name": f"body{i}", "shape": shape(draw), "friction": draw.choice([0, 0.3, 1.0]),
                "transformation": {"translation": [round(draw.uniform(-0.3, 0.3), 3), round(draw.uniform(-0.3, 0.3), 3),
                                                   round(draw.uniform(-0.7, -0.2), 3)], "rotation": draw.rotation()}}
        if draw.chance(0.4):
            body["motion"] = motion(draw, seconds)
        scene["obstacles"].append(body)
    # Falling takes long; bodies and cloth meet within the few frames of a scene.
    for piece in scene["geometry"]:
        piece["velocity"][2] -= round(draw.uniform(1.0, 8.0), 2)
    if draw.chance(0.3):
        scene["handles"] = [{"geometry": "cloth0", "select": ["x0y0"],
                             **({"motion": motion(draw, seconds)} if draw.chance(0.5) else {})}]
    if draw.chance(0.3):
        scene["air"] = {"wind": draw.vector(10.0), "normal_drag": draw.power(0.01, 2.0),
                        "gusts": {"speed": draw.uniform(0.0, 5.0)}}
    if draw.chance(0.3):
        scene["perturbation"] = {"speed": draw.power(0.01, 5.0), "seed": draw.integer(1, 1000)}
    if draw.chance(0.1):
        scene["gravity"] = draw.vector(100.0)
    scene["time"] = {"frames": frames, "fps": fps, "steps_per_frame": draw.choice([1, 2, 2, 4, 16])}
    scene["contact"] = {"rest_gap": draw.power(2e-4, 5e-3)}
    if draw.chance(0.7):
        scene["contact"]["broad_phase"] = draw.method(detectors)
    if draw.chance(0.3):
        scene["contact"]["narrow_phase"] = draw.method(families["narrow_phase"])
    if draw.chance(0.6):
        scene["contact"]["response"] = draw.method(families["response"])
    if draw.chance(0.6):
        scene["contact"]["fail_safe"] = draw.method(families["fail_safe"])
    scene["solver"] = {}
    if draw.chance(0.6):
        scene["solver"]["integrator"] = draw.method(families["integrator"])
    if draw.chance(0.5):
        scene["solver"]["strain_limiter"] = draw.method(families["strain_limiter"])
    return scene


def misses_nothing(scene, families):
    def of(family, default):
        value = scene["contact"].get(family, default)
        name = value["type"] if isinstance(value, dict) else value
        return next(m["guarantee"] for m in families[family] if m["name"] == name)

    return (of("broad_phase", "bvh_aabb").startswith("conservative")
            and of("narrow_phase", "ccd_exact").startswith("misses nothing"))


class Watched:
    """A process with a budget of processor time: its most memory (MB), and whether it opened more and more files."""

    def __init__(self, command, budget):
        begin = time.monotonic()
        samples = []
        self.memory = 0.0
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(budget), math.ceil(budget) + 1))
        with open(os.devnull, "w") as nowhere, subprocess.Popen(
                command, stdout=nowhere, stderr=subprocess.PIPE, preexec_fn=limit) as child:
            os.set_blocking(child.stderr.fileno(), False)
            said = b""
            while child.poll() is None:
                said += child.stderr.read() or b""
                self._sample(child.pid, samples)
                if time.monotonic() - begin > 20 * budget:  # hangs without computing
                    child.kill()
                time.sleep(0.02)
            said += child.stderr.read() or b""
            self.code = child.returncode
        self.too_long = self.code == -signal.SIGXCPU or time.monotonic() - begin > 20 * budget
        self.said = said.decode(errors="replace").strip()
        half = len(samples) // 2
        self.files_leak = half > 50 and max(samples[half:]) > max(samples[:half]) + 2

    def _sample(self, pid, samples):
        try:
            samples.append(len(os.listdir(f"/proc/{pid}/fd")))
            with open(f"/proc/{pid}/status") as status:
                for line in status:
                    if line.startswith("VmHWM"):
                        self.memory = max(self.memory, int(line.split()[1]) / 1024)
        except OSError:
            pass  # it has just ended


def attempt(scene, families, config, folder):
    """(kind of failure or "", a sentence, exit code) of a scene; what it leaves is in `folder`."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    file, out = os.path.join(folder, "scene.json"), os.path.join(folder, "result")
    with open(file, "w") as text:
        json.dump(scene, text, indent=1)
    run = Watched([config.program, "run", file, "--out", out, "--every-step", "--no-pictures", "--threads",
                   str(config.threads), "--max-steps", str(config.steps)], config.budget)
    end = run.said.splitlines()[-1] if run.said else ""
    if run.too_long:
        return "slow", f"still ran after {config.budget:g} s", run.code
    if run.code not in (0, 1, 2):
        return "crash", f"ended with {run.code}: {end}", run.code
    if run.code == 2:
        sentences = [line for line in run.said.splitlines() if not line.startswith("warning")]
        return ("", end, 2) if len(sentences) == 1 else ("words", f"{len(sentences)} lines: {run.said}", 2)
    if run.memory > config.memory:
        return "memory", f"took {run.memory:.0f} MB", run.code
    if run.files_leak:
        return "files", "held more and more files", run.code
    if not os.path.exists(os.path.join(out, "result.json")):
        return ("", end, 1) if run.code == 1 and run.said else ("words", "left neither a result nor a sentence", run.code)
    with open(os.path.join(out, "result.json")) as text:
        result = json.load(text)
    if run.code == 0 and result.get("clean") is not True:
        return "words", f"exit code 0, and clean is {result.get('clean')}", 0
    if not os.path.isdir(os.path.join(out, "steps")):
        return "", end, run.code
    judged = subprocess.run([config.program, "check", out, "--json", "--threads", str(config.threads)],
                            capture_output=True, text=True, check=False)
    if judged.returncode not in (0, 1):
        return "judge", f"check ended with {judged.returncode}: {judged.stderr.strip()}", run.code
    promised = misses_nothing(scene, families)
    verdict = json.loads(judged.stdout)
    wrong = {key: verdict[key] for key in ("self_intersections", "body_intersections", "inside_vertices",
                                           "path_self_collisions", "path_body_collisions") if verdict.get(key)}
    if not promised:
        wrong = {key: value for key, value in wrong.items() if not key.startswith("path_")}
    if judged.returncode == 1 and (promised or wrong and result.get("clean")):
        return "unclean", f"clean is {result.get('clean')}, and the judge counts {wrong}", run.code
    return "", end, run.code


def smaller(scene):
    """Scenes that have a little less each."""
    def without(*path):
        less = copy.deepcopy(scene)
        at = less
        for key in path[:-1]:
            at = at[key]
        del at[path[-1]]
        return less

    def with_value(value, *path):
        less = copy.deepcopy(scene)
        at = less
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = value
        return less

    if len(scene["geometry"]) > 1:
        for i in range(len(scene["geometry"])):
            if not (i == 0 and "handles" in scene):
                yield without("geometry", i)
    for i in range(len(scene["obstacles"])):
        yield without("obstacles", i)
    for key in ("handles", "air", "perturbation", "gravity"):
        if key in scene:
            yield without(key)
    frames = scene["time"]["frames"]
    if frames > 1:
        yield with_value(frames // 2, "time", "frames")
        yield with_value(frames - 1, "time", "frames")
    for part in ("contact", "solver"):
        for key in scene[part]:
            yield without(part, key)
    for i, piece in enumerate(scene["geometry"]):
        if max(piece["cells"]) > 1:
            yield with_value([max(1, c // 2) for c in piece["cells"]], "geometry", i, "cells")
        if piece["pattern"]["type"] != "rectangular":
            yield with_value({"type": "rectangular"}, "geometry", i, "pattern")
        if piece["material"] in scene["materials"]:
            for key in scene["materials"][piece["material"]]:
                yield without("materials", piece["material"], key)
    for i, body in enumerate(scene["obstacles"]):
        if "motion" in body:
            yield without("obstacles", i, "motion")
        if body["shape"].get("resolution", 0) > 6:
            yield with_value(6, "obstacles", i, "shape", "resolution")


def minimise(scene, kind, families, config, folder, seconds):
    """The smallest scene found in `seconds` that fails in the same way."""
    end = time.monotonic() + seconds
    shrunk = True
    while shrunk:
        shrunk = False
        for less in smaller(scene):
            if time.monotonic() > end:
                return scene
            if attempt(less, families, config, folder)[0] == kind:
                scene, shrunk = less, True
                break
    return scene


def keep(scene, seed, kind, sentence, families, config, bundles):
    bundle = os.path.join(bundles, str(seed))
    shutil.rmtree(bundle, ignore_errors=True)
    os.makedirs(bundle)
    small = minimise(scene, kind, families, config, os.path.join(bundles, "work"), config.minimise)
    for name, content in (("scene.json", scene), ("smaller.json", small)):
        with open(os.path.join(bundle, name), "w") as text:
            json.dump(content, text, indent=1)
    with open(os.path.join(bundle, "failure.txt"), "w") as text:
        text.write(f"{kind}: {sentence}\n")
    print(f"seed {seed}: {kind}: {sentence} (kept in {os.path.relpath(bundle)})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("hours", type=float)
    parser.add_argument("--program", default=os.path.join(ROOT, "build/release/apps/selvedge"))
    parser.add_argument("--seed", type=int, default=1, help="of the first scene (default 1)")
    parser.add_argument("--only", type=int, help="runs the scene of this seed and prints how it ends")
    parser.add_argument("--again", help="runs the scene of this kept failure and prints how it ends")
    parser.add_argument("--budget", type=float, default=120, help="s of processor time, for one scene (default 120)")
    parser.add_argument("--memory", type=float, default=600, help="MB, for one scene (default 600)")
    parser.add_argument("--minimise", type=float, default=120, help="s, for making a failure smaller (default 120)")
    parser.add_argument("--threads", type=int, default=1, help="of each run (default 1)")
    parser.add_argument("--steps", type=int, default=800, help="a run stops after this many (default 800)")
    parser.add_argument("--longest", type=int, default=240, help="frames of a long scene, one in 33 (default 240)")
    parser.add_argument("--out", default="out/soak", help="folder for failures (default out/soak)")
    config = parser.parse_args()
    families = registry(config.program)
    # a weave is a swatch at the scale of yarns
    families["pattern_of_grids"] = [m for m in families["pattern"] if m["key"].endswith(".pattern") and m["name"] != "weave"]
    # and biphasic is a law of the material
    families["strain_limiter"] = [m for m in families["strain_limiter"] if m["key"] == "solver.strain_limiter"]
    bundles = os.path.abspath(config.out)
    work = os.path.join(bundles, "work")
    os.makedirs(bundles, exist_ok=True)

    if config.again or config.only is not None:
        if config.again:
            with open(os.path.join(config.again, "smaller.json")) as text:
                scene = json.load(text)
        else:
            scene = random_scene(config.only, families, config.longest)
        kind, sentence, code = attempt(scene, families, config, work)
        print(f"{kind or 'passed'} (exit code {code}): {sentence}\nThe scene and its result are in {os.path.relpath(work)}.")
        return 1 if kind else 0

    end = time.monotonic() + 3600 * config.hours
    seed, failed = config.seed, 0
    ended = collections.Counter()
    used = {family: collections.Counter() for family in ("broad_phase", "narrow_phase", "response", "fail_safe",
                                                          "integrator", "strain_limiter")}
    while time.monotonic() < end:
        scene = random_scene(seed, families, config.longest)
        kind, sentence, code = attempt(scene, families, config, work)
        ended[kind or {0: "clean", 1: "stopped and said so", 2: "refused"}[code]] += 1
        for family, count in used.items():
            value = scene["contact"].get(family) or scene["solver"].get(family)
            if value and code != 2:
                count[value["type"]] += 1
        if kind:
            failed += 1
            keep(scene, seed, kind, sentence, families, config, bundles)
        seed += 1
    shutil.rmtree(work, ignore_errors=True)
    print(f"{seed - config.seed} scenes, seeds {config.seed} to {seed - 1}: "
          + ", ".join(f"{count} {name}" for name, count in ended.most_common()))
    for family, count in used.items():
        never = [m["name"] for m in families[family] if m["name"] not in count]
        print(f"{family}: {len(count)} of {len(families[family])} methods" + (f", without {', '.join(never)}" if never else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
