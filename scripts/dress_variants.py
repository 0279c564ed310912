#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""dress_variants.py --count N --seed S [--body BODY] [--up y] --out FOLDER PATTERN...
Writes N variants of sewing patterns into FOLDER, in turn of each PATTERN, and FOLDER/list.txt for `selvedge dress --list`.
A PATTERN is a JSON file or a folder of such. In a variant, every edge has another length, by at most 15 % (--change): the
garment and each panel are stretched along both of their axes, and every vertex is moved a little. Curves keep their shape
relative to their edge. The top and the middle of each panel stay at their place. The two edges of a stitch keep the ratio
of their lengths within 15 %, so that one of them is eased or gathered into the other. A seed gives the same variants again.

dress_variants.py --results FOLDER...: counts the garments of `selvedge dress --list --out FOLDER` that are finished, clean,
sewn and good, and prints the verdict of each that is not. Exit code 1: fewer than 97 % end clean (--share), or a garment
that is not clean has no flagged vertex. A garment that is still being put on does not count.
"""
import argparse
import glob
import json
import math
import os
import random
import sys

AXES = {"x": 0, "y": 1, "z": 2}


def rotation(angles):
    """About the fixed axes x, y, z, in turn; degrees."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(math.radians(a)), math.sin(math.radians(a))) for a in angles)
    return [[cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx]]


def anchor(panel, vertices, up):
    """Middle of the box of a panel as it stands, but at its highest point."""
    turn = rotation(panel["rotation"])
    placed = [[turn[k][0] * x + turn[k][1] * y for k in range(3)] for x, y in vertices]
    return [max(p[k] for p in placed) if k == up else (max(p[k] for p in placed) + min(p[k] for p in placed)) / 2.0
            for k in range(3)]


def chords(panel, vertices):
    return [math.dist(vertices[e["endpoints"][0]], vertices[e["endpoints"][1]]) for e in panel["edges"]]


def blended(before, target, share):
    return {name: [[a + share * (b - a) for a, b in zip(u, v)] for u, v in zip(before[name], target[name])]
            for name in before}


def changes(pattern, before, after):
    """Ratios of the lengths of all edges, and of those of the two edges of each stitch; 1: as before."""
    ratio = {name: [b / a for a, b in zip(chords(panel, before[name]), chords(panel, after[name]))]
             for name, panel in pattern["panels"].items()}
    seams = []
    for stitch in pattern["stitches"]:
        a, b = (ratio[side["panel"]][side["edge"]] for side in stitch[:2])
        seams.append(max(a, b) / min(a, b))
    return [r for edges in ratio.values() for r in edges], seams


def is_within(pattern, before, after, change):
    edges, seams = changes(pattern, before, after)
    return max(abs(r - 1.0) for r in edges) <= change and max(seams) <= 1.0 + change


def moved_vertices(pattern, draw, change):
    """Of a garment that is stretched, with panels and vertices of their own changes."""
    garment = [1.0 + draw.uniform(-change, change) for _ in range(2)]
    target = {}
    for name, panel in pattern["panels"].items():
        stretch = [s * (1.0 + draw.uniform(-change, change) / 4.0) for s in garment]
        near = [change / 8.0 * min(length for length, edge in zip(chords(panel, panel["vertices"]), panel["edges"])
                                   if i in edge["endpoints"]) for i in range(len(panel["vertices"]))]
        target[name] = [[s * p + draw.uniform(-d, d) for s, p in zip(stretch, point)]
                        for point, d in zip(panel["vertices"], near)]
    return target


def variant(text, draw, change, up):
    """A changed copy of a pattern, and the largest change of an edge."""
    file = json.loads(text)
    pattern = file["pattern"]
    before = {name: panel["vertices"] for name, panel in pattern["panels"].items()}
    target = moved_vertices(pattern, draw, change)
    share = 1.0
    while not is_within(pattern, before, blended(before, target, share), change):
        share *= 0.98
    after = blended(before, target, share)
    for name, panel in pattern["panels"].items():
        old, new = anchor(panel, before[name], up), anchor(panel, after[name], up)
        panel["translation"] = [t + a - b for t, a, b in zip(panel["translation"], old, new)]
        panel["vertices"] = after[name]
    return file, max(abs(r - 1.0) for r in changes(pattern, before, after)[0])


def files_of(patterns):
    found = []
    for pattern in patterns:
        found += sorted(glob.glob(os.path.join(pattern, "*.json"))) if os.path.isdir(pattern) else [pattern]
    return found


def write_variants(options):
    patterns = files_of(options.pattern)
    draw = random.Random(options.seed)
    os.makedirs(options.out, exist_ok=True)
    rows = [f"# seed {options.seed}, edges changed by at most {100 * options.change:g} %"]
    for k in range(options.count):
        source = patterns[k % len(patterns)]
        with open(source) as text:
            file, largest = variant(text.read(), draw, options.change, AXES[options.up])
        name = f"{os.path.splitext(os.path.basename(source))[0]}_{k // len(patterns):02d}.json"
        with open(os.path.join(options.out, name), "w") as out:
            json.dump(file, out, indent=1)
        body = f",{os.path.abspath(options.body)}" if options.body else ""
        rows += [f"# {name}: {100 * largest:.1f} %", name + body]
    with open(os.path.join(options.out, "list.txt"), "w") as out:
        out.write("\n".join(rows) + "\n")
    print(f"{options.count} variants of {len(patterns)} patterns; list {os.path.join(options.out, 'list.txt')}")
    return 0


def print_results(options):
    counts = dict.fromkeys(("garments", "finished", "clean", "sewn", "good"), 0)
    hidden = 0
    for folder in options.results:
        for name in sorted(glob.glob(os.path.join(folder, "*", "result.json"))):
            with open(name) as text:
                result = json.load(text)
            if result["dress"] == "unfinished":
                continue
            counts["garments"] += 1
            counts["finished"] += result["dress"] == "finished"
            for key in ("clean", "sewn", "good"):
                counts[key] += result.get(key, False)
            hidden += result["dress"] == "finished" and not result["clean"] and not result.get("flagged_vertices", 0)
            if not result.get("good", False):
                clean = "clean" if result.get("clean", False) else "NOT CLEAN" if "clean" in result else "not finished"
                print(f"{os.path.basename(os.path.dirname(name))}: {clean}; {result['verdict']}")
    print(", ".join(f"{key} {count}" for key, count in counts.items()))
    return 0 if counts["clean"] >= options.share * counts["garments"] and not hidden else 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pattern", nargs="*")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--change", type=float, default=0.15)
    parser.add_argument("--body", default="", help="for the list; without it, name the body behind --list")
    parser.add_argument("--up", choices=AXES, default="y", help="axis of the patterns that points up")
    parser.add_argument("--out", default="out/variants")
    parser.add_argument("--results", nargs="+", default=[])
    parser.add_argument("--share", type=float, default=0.97)
    options = parser.parse_args()
    if options.results:
        return print_results(options)
    if not options.pattern or options.count < 1 or not 0.0 < options.change < 0.5:
        parser.error("give patterns, a count of at least 1, and a change between 0 and 0.5")
    return write_variants(options)


if __name__ == "__main__":
    sys.exit(main())
