#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""house.py [--program SELVEDGE] [--unused]: counts what a newcomer has to learn of this repository.

The largest room in lines and its ratio to the smallest (base, system and detection left out), top-level folders, paths of a scene, options of the program,
scripts, public headers, headers that simulation/simulation.h includes, and words of docs/. With --unused it also lists
the options of each command that no page, script, test, example or binding of the repository uses.
"""
import argparse
import json
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCHEMA = "data/scenes/scene.schema.json"
SIMULATION = "simulation/simulation.h"
SMALL_BY_NATURE = {"core/base", "core/system", "detection"}  # what all others share, and the face of the detectors


def tracked():
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return [name for name in listing.splitlines() if (ROOT / name).is_file()]


def text(name):
    return (ROOT / name).read_text(errors="replace")


def rooms(files):
    """Lines of sources by room. A room is a folder whose CMakeLists.txt makes libraries; its subfolders belong to it."""
    homes = [str(Path(name).parent) for name in files
             if name.endswith("CMakeLists.txt") and re.search(r"selvedge_(library|adapter)\(", text(name))]
    lines = dict.fromkeys(homes, 0)
    for name in files:
        home = max((h for h in homes if name.startswith(h + "/")), key=len, default=None)
        if home and name.endswith((".h", ".cpp", ".inc")):
            lines[home] += text(name).count("\n")
    return lines


def scene_paths(schema):
    """Every path to a key of a scene, an alternative of an object at the same place counted once."""
    found = set()

    def walk(node, path, above):
        while "$ref" in node:
            if node["$ref"] in above:
                return
            above = above | {node["$ref"]}
            target = schema
            for part in node["$ref"].lstrip("#/").split("/"):
                target = target[part]
            node = target
        for key, value in node.get("properties", {}).items():
            found.add(f"{path}.{key}")
            walk(value, f"{path}.{key}", above)
        for part in ("items", "additionalProperties"):
            if isinstance(node.get(part), dict):
                walk(node[part], path, above)
        for part in ("oneOf", "anyOf", "allOf"):
            for alternative in node.get(part, []):
                walk(alternative, path, above)

    walk(schema, "", frozenset())
    return found


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True).stdout


def options(program):
    """The options of each command, the help itself left out."""
    found = {"": re.findall(r"^ +(?:-\w,)?(--[\w-]+)", help_of(program), re.M)}
    commands = help_of(program).split("Subcommands:")[1]
    for command in re.findall(r"^  (\w+) ", commands, re.M):
        found[command] = re.findall(r"^ +(?:-\w,)?(--[\w-]+)", help_of(program, command), re.M)
    return {command: [o for o in names if o != "--help"] for command, names in found.items()}


def uses(files):
    """What may use an option: everything but the definitions of the commands and the list of changes."""
    return "\n".join(text(name) for name in files
                     if not name.startswith("apps/") and name != "CHANGELOG.md"
                     and name.endswith((".md", ".sh", ".py", ".cpp", ".h", ".txt", ".csv", ".json", ".mjs")))


def included(name, seen):
    """Own headers that a header includes, itself left out."""
    for header in re.findall(r"#include <selvedge/([\w/.]+)>", text(name)):
        if header not in seen:
            seen.add(header)
            included(header, seen)
    return seen


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--program", default=str(ROOT / "build/release/apps/selvedge"))
    parser.add_argument("--unused", action="store_true", help="list the options that nothing uses")
    chosen = parser.parse_args()

    files = tracked()
    lines = rooms(files)
    largest = max(lines, key=lines.get)
    smallest = min(lines.keys() - SMALL_BY_NATURE, key=lines.get)
    folders = {name.split("/")[0] for name in files if "/" in name}
    headers = [n for n in files if Path(n).suffix == ".h" and not {"detail", "internal"} & set(Path(n).parts) and any(n.startswith(r + "/") for r in lines)]
    simulation = next(n for n in files if n.endswith(SIMULATION))
    rows = [
        ("largest room, lines", f"{lines[largest]} ({largest})"),
        ("smallest room, lines", f"{lines[smallest]} ({smallest})"),
        ("ratio", f"{lines[largest] / lines[smallest]:.1f}"),
        ("top-level folders", len([f for f in folders if not f.startswith(".")])),
        ("scene paths", len(scene_paths(json.loads(text(SCHEMA))))),
        ("scripts", len([n for n in files if n.startswith("scripts/")])),
        ("public headers", len(headers)),
        (f"headers included by {SIMULATION}", len(included(simulation, set()))),
        ("pages of the manual, docs/", len([n for n in files if re.fullmatch(r"docs/[^/]*\.md", n)])),
        ("words of the manual, docs/",
         sum(len(text(n).split()) for n in files if re.fullmatch(r"docs/[^/]*\.md", n))),
        ("words in docs/lab/", sum(len(text(n).split()) for n in files if re.fullmatch(r"docs/lab/.*\.md", n))),
    ]
    if Path(chosen.program).is_file():
        known = options(chosen.program)
        rows.insert(5, ("options of the program", sum(len(names) for names in known.values())))
    for name, value in rows:
        print(f"{name:42} {value}")
    if chosen.unused and Path(chosen.program).is_file():
        everything = uses(files)
        for command, names in known.items():
            unused = [o for o in names if not re.search(re.escape(o) + r"(?![\w-])", everything)]
            if unused:
                print(f"{command}: {' '.join(unused)}")


if __name__ == "__main__":
    main()
