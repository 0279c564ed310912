#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Checks docs/lab/survey_claims.md and docs/lab/tables/survey_claims.csv.

    bench/check_claims.py [--run "bench integrators --work 500,2000,8000" ... --programs build/release]

Without --run: every claim has rows and a verdict, the numbers of verdicts in the page are those of its table, and every
command names a program, a part or a claim that exists, with options that it has and a value for each that takes one.
--run: also runs these commands and looks for every exact figure of their rows in what they print.
"""
import argparse
import contextlib
import csv
import importlib.util
import io
import os
import pathlib
import re
import shlex
import subprocess
import sys
import types

ROOT = pathlib.Path(__file__).parent.parent
VERDICTS = ("confirmed", "partly", "refuted", "not decided")
CLAIMS = [f"C{i}" for i in range(1, 31)]


def rows():
    with open(ROOT / "docs/lab/tables/survey_claims.csv", newline="") as text:
        return list(csv.DictReader(text))


def options_of(source):
    """The options in the source of a benchmark or a command; true for those that take a value."""
    text = source.read_text()
    takes = {name: True for name in re.findall(r'option\(\s*"(--[a-z-]+)"', text)}
    flags = re.findall(r'flag\(\s*"(!?--[a-z-]+)"', text)
    return takes | {name.lstrip("!"): False for name in flags}


def fault_of_options(words, takes):
    at = 0
    while at < len(words):
        word = words[at]
        if word.startswith("--"):
            if word not in takes:
                return f"there is no option {word}"
            if takes[word]:
                at += 1
                if at == len(words) or words[at].startswith("--"):
                    return f"{word} has no value"
        at += 1
    return ""


def fault_of_bench(words):
    if not words:
        return "bench has no name"
    if f'{{"{words[0]}",' not in (ROOT / "bench/main.cpp").read_text():
        return f"there is no benchmark {words[0]}"
    return fault_of_options(words[1:], options_of(ROOT / f"bench/{words[0]}.cpp"))


def fault_of_python(name, words):
    """Of the arguments of a Python script in bench/."""
    for missing in ("numpy", "selvedge"):  # only the arguments are read
        sys.modules.setdefault(missing, types.ModuleType(missing))
    sys.path.insert(0, str(ROOT / "bench"))
    spec = importlib.util.spec_from_file_location(name, ROOT / f"bench/{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            module.arguments(words)
    except SystemExit:
        return said.getvalue().strip().splitlines()[-1]
    return ""


def fault_of(claim, command):
    program, *words = shlex.split(command)
    if "/" in program and not os.access(ROOT / program, os.X_OK):
        return f"{program} cannot be run"
    if program == "bench":
        return fault_of_bench(words)
    if program in ("bench/survey_size.py", "bench/survey_figures.py"):
        return fault_of_python(pathlib.Path(program).stem, words)
    if program == "bench/survey_claims.sh":
        return "" if words == [claim] else f"measures {words} and not {claim}"
    if program == "scripts/tables.sh":
        known = words and f"table_{words[0]}()" in (ROOT / "scripts/tables.sh").read_text()
        return "" if known else "tables.sh has no such table"
    if program == "selvedge" and words and (ROOT / f"apps/command_{words[0]}.cpp").exists():
        return fault_of_options(words[1:], options_of(ROOT / f"apps/command_{words[0]}.cpp"))
    return f"there is no program {program}"


def faults_of_table(table):
    for row in table:
        place = f'{row["claim"]}, "{row["quantity"]}"'
        if None in row.values() or None in row or not all(row.values()):
            yield f"{place}: a cell is missing"
        elif fault := fault_of(row["claim"], row["command"]):
            yield f'{place}: {row["command"]}: {fault}'
    for claim in CLAIMS:
        if not any(row["claim"] == claim for row in table):
            yield f"{claim} has no row"


def faults_of_page():
    page = (ROOT / "docs/lab/survey_claims.md").read_text()
    verdicts = dict(re.findall(r"^\| (C\d+) \|[^|]*\| ([^|]*) \|", page, re.M))
    if list(verdicts) != CLAIMS:
        yield "the table of verdicts has other claims than C1 to C30"
    for claim, verdict in verdicts.items():
        if verdict not in VERDICTS:
            yield f'{claim}: the verdict "{verdict}" is none of {", ".join(VERDICTS)}'
    counts = [list(verdicts.values()).count(verdict) for verdict in VERDICTS]
    said = re.search(r"confirm (\d+) claims, confirm (\d+) in part, refute (\d+) and do not\s+decide (\d+)", page)
    if not said or [int(count) for count in said.groups()] != counts:
        yield f"the page does not say that it confirms, confirms in part, refutes and does not decide {counts} claims"


NUMBER = re.compile(r"-?(?:\d[\d,]*\.?\d*|\.\d+)(?:e[-+]?\d+)?", re.I)


def numbers(text):
    """Each number with half of its last digit."""
    found = []
    for word in NUMBER.findall(text):
        digits, _, power = word.replace(",", "").lower().partition("e")
        if digits in ("", "-"):
            continue
        places = len(digits.partition(".")[2])
        scale = 10.0 ** int(power or 0)
        found.append((float(digits) * scale, 0.5 * scale * 10.0**-places))
    return found


def run(command, programs):
    words = shlex.split(command)
    program = {"bench": programs / "bench/bench", "selvedge": programs / "apps/selvedge"}.get(words[0])
    words[0] = str(program or ROOT / words[0])
    environment = dict(os.environ, SELVEDGE_BUILD=str(programs), SELVEDGE=str(programs / "apps/selvedge"),
                       PYTHONPATH=str(programs / "python"))
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def is_exact(row):
    """Whether every run gives the same figure: a count, an error, a mean of fixed draws, or an interval without a width."""
    ends = [value for value, _ in numbers(row["interval"].removeprefix("95 %"))]
    return row["interval"].endswith("exact") or len(ends) == 2 and ends[0] == ends[1]


def faults_of_figures(table, commands, programs):
    """The exact figures of the rows of these commands that the commands do not print."""
    exact = [row for row in table if row["command"] in commands and is_exact(row)]
    printed = {command: numbers(run(command, programs)) for command in commands}
    for command in commands:
        if not any(row["command"] == command for row in exact):
            yield f"{command}: no row with an exact figure has this command"
    for row in exact:
        for value, half in numbers(row["value"]):
            near = (abs(value - other) <= half + other_half * 1.000001 for other, other_half in printed[row["command"]])
            if not any(near):
                yield f'{row["claim"]}, "{row["quantity"]}": {row["command"]} does not print {value:g}'


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", nargs="+", default=[], metavar="COMMAND")
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release")
    options = parser.parse_args()
    table = rows()
    faults = [*faults_of_table(table), *faults_of_page()]
    if options.run:
        faults += faults_of_figures(table, options.run, options.programs.resolve())
    for fault in faults:
        print(fault)
    print(f"{len(table)} rows, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
