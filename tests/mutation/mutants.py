#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Mutation testing: draws changes of the library's sources and counts those that no test notices. scripts/mutants.sh
compiles them in between:

    mutants.py draw WORK BUILD [OPTIONS]   # changed sources in WORK/changed, and mutants.json
    mutants.py drop WORK UNIT              # drops the changes that do not compile
    mutants.py run WORK BUILD [OPTIONS]    # runs the tests, prints the table

A change turns < into <=, == into !=, + into -, min into max; alters a constant (0.5 to 0.25, 1 to 0); drops a condition
of && or ||, a negation, a `continue`, a `break` or a statement. The draw takes the same number from each module, from
--files of its sources, and goes round the kinds of changes. It leaves out comments, strings, messages, assertions,
validation, constant expressions, templates and sources for one instruction set or one external library.

One run of each test program finds the tests that reach a change, and their time. A test that fails unchanged or takes
over --longest seconds is left out. A change that crashes a test, or takes it ten times as long, is noticed, too.
tests/mutation/mutants_equivalent.csv explains changes that no test can notice.
"""
import argparse
import collections
import csv
import json
import os
import random
import re
import resource
import subprocess
import sys
import time

MODULES = ("core", "bodies", "broadphase", "narrowphase", "detection", "response", "judge", "scene", "simulation",
           "garment", "dress", "run")
UNNOTICED = ("survived", "not reached")
# Programs that link the libraries and need neither `selvedge` nor a list of scenes.
PROGRAMS = ("cloth", "forces", "integrators", "bodies", "broadphase", "detectors", "narrowphase", "judge", "response",
            "detection_stage", "simulation", "run", "scene", "files", "garments", "lab")
SPECIAL = re.compile(r"_avx|_sse|adapter_|cgal|osmesa|assimp|validate|_generated")
# What the statement of a change must not hold.
EXCLUDED = re.compile(r"\b(static_assert|template|using|throw|case|constexpr|consteval|enum|operator|typename|concept|"
                      r"requires|goto|SELVEDGE_\w+|to_string|message|refuse)\b|std::format|fmt::|<<|>>")
# An assignment or a call in a line of its own.
STATEMENT = (r"(?<=[;{})]\n) +((?!return|delete|if|for|while|switch|else)[\w.\->\[\]]+"
             r"(?: [-+*/|&]?= [^;\n{}]*|\([^;\n{}]*\));)(?=\n)")
# What several units include; the rest of our own headers may hold names of unnamed namespaces of another unit.
SHARED = r"^#include <(?!selvedge/)[a-z].*|^#include <selvedge/core/base/types.h>"
EQUIVALENT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "mutants_equivalent.csv")


# ---- draw

def blank(text):
    """The text without comments, strings and preprocessor lines, each of whose characters becomes a space."""
    def spaces(match):
        return re.sub(r"[^\n]", " ", match[0])
    literals = r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\''
    text = re.sub(literals, spaces, text, flags=re.S)
    text = re.sub(r"^[ ]*#if[^\n]*VALIDAT.*?^[ ]*#endif", spaces, text, flags=re.S | re.M)
    text = re.sub(r"^[ ]*#(?:[^\n]*\\\n)*[^\n]*", spaces, text, flags=re.M)
    return re.sub(r"^[^\n]*\bvalidate\w*\([^;{]*\{\n.*?^\}", spaces, text, flags=re.S | re.M)


def operand_end(text, start):
    """Where the operand of && or || that begins at `start` ends."""
    depth = 0
    for i in range(start, len(text)):
        c = text[i]
        if c in "([{":
            depth += 1
        elif c in ")]}":
            depth -= 1
            if depth < 0:
                return i
        elif depth == 0 and (c in ",;?" or text[i:i + 2] in ("&&", "||") or
                             c == ":" and "::" not in (text[i:i + 2], text[i - 1:i + 1])):
            return i
    return len(text)


def other_number(word):
    if "." in word:
        value = {"0.0": "1.0", "1.0": "0.0", "2.0": "1.0"}.get(word)
        return value or repr(0.5 * float(word))
    return {"0": "1", "1": "0", "2": "1"}.get(word) or str(int(word) + 1)


OTHER = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+", "min": "max", "max": "min",
         "true": "false", "false": "true"}


def changes(text):
    """All changes of a source: its kind, what it does, and edits (start, end, new text), where @ stands for its number."""
    bare = blank(text)
    found = []

    def add(kind, at, what, *edits):
        begin = max(bare.rfind(c, 0, at) for c in ";{}") + 1
        end = bare.find("\n", at)
        if not EXCLUDED.search(text[begin:end]):
            found.append({"kind": kind, "at": at, "change": what, "edits": edits})

    def matches(pattern):
        return re.finditer(pattern, bare, re.M)

    for m in matches(r"(?<= )(<=?|>=?|==|!=)(?=\s)"):
        add("comparison", m.start(), f"{m[1]} to {OTHER[m[1]]}", (m.start(), m.end(), f"{m[1]} SelvedgeInfix<@>() {m[1]}"))
    for m in matches(r"(?<= )[+-](?=\s)"):
        add("sign", m.start(), f"{m[0]} to {OTHER[m[0]]}", (m.start(), m.end(), f"{m[0]} SelvedgeInfix<@>() {m[0]}"))
    for m in matches(r"\bstd::(min|max)(?=[(<{])"):
        add("extreme", m.start(), f"{m[1]} to {OTHER[m[1]]}", (m.start(), m.end(), f"SelvedgeExtreme<@>::{m[1]}"))
    for m in matches(r"(?<![\w.\[<'])(\d+\.\d+|\d)(?![\w.'\]>])"):
        add("constant", m.start(), f"{m[1]} to {other_number(m[1])}",
            (m.start(), m.end(), f"(selvedge_mutant_reached(@) ? {other_number(m[1])} : {m[1]})"))
    for m in matches(r"\b(true|false)\b"):
        add("constant", m.start(), f"{m[1]} to {OTHER[m[1]]}",
            (m.start(), m.end(), f"(selvedge_mutant_reached(@) != {m[1]})"))
    for m in matches(r"(?<=\s)(&&|\|\|)\s"):
        end = operand_end(bare, m.end())
        dropped = " ".join(text[m.end():end].split())
        opening = "(selvedge_mutant_reached(@) || (" if m[1] == "&&" else "(!selvedge_mutant_reached(@) && ("
        add("condition", m.start(), f"{m[1]} {dropped} dropped", (m.end(), m.end(), opening), (end, end, "))"))
    for m in matches(r"(?<![\w)])!(?=[\w(])"):
        add("negation", m.start(), "! dropped", (m.start(), m.start(), "selvedge_mutant_reached(@) != "))
    for m in matches(r"\b(continue|break);"):
        add("jump", m.start(), f"{m[1]} dropped", (m.start(), m.start(), "{ if (!selvedge_mutant_reached(@)) "),
            (m.end(), m.end(), " }"))
    for m in matches(STATEMENT):
        if m[1].count("(") == m[1].count(")"):
            add("statement", m.start(1), "dropped", (m.start(1), m.start(1), "{ if (!selvedge_mutant_reached(@)) "),
                (m.end(1), m.end(1), " }"))
    return found


def compile_commands(build):
    """For each source of the library: its target and the options of its command that name headers and definitions."""
    listed = subprocess.run(["ninja", "-C", build, "-t", "compdb"], capture_output=True, text=True, check=True)
    database = json.loads(listed.stdout)
    sources = {}
    for entry in database:
        target = re.search(r"CMakeFiles/selvedge_(\w+)\.dir/", entry["output"])
        if not target or SPECIAL.search(target[1]) or not entry["file"].endswith((".cpp", ".cxx")):
            continue
        path = os.path.join(entry["directory"], entry["file"])
        options = re.findall(r"-isystem \S+|-D\S+", entry["command"])
        files = [path]
        if "/Unity/unity_" in path and os.path.exists(path):
            files = re.findall(r'#include "([^"]+)"', open(path).read())
        for file in files:
            sources[os.path.realpath(file)] = (target[1], options)
    return sources


def shuffled(items, chance):
    return sorted(items, key=lambda _: chance())


def draw_module(module, count, files, chance, known):
    """Mutants of a module: its kinds of changes in turn, in at most `files` sources, one change in a line."""
    paths = sorted(os.path.join(folder, name) for folder in (module, f"{module}/detail") if os.path.isdir(folder)
                   for name in os.listdir(folder) if name.endswith(".cpp") and not SPECIAL.search(name))
    kinds = collections.defaultdict(list)
    taken = 0
    for path in shuffled(paths, chance):
        found = changes(open(path).read())
        if len(found) < 8 or os.path.realpath(path) not in known or taken == files:
            continue
        taken += 1
        for change in found:
            kinds[change["kind"]].append(dict(change, module=module, file=path))
    queues = [shuffled(kinds[kind], chance) for kind in sorted(kinds)]
    drawn, lines = [], set()
    while len(drawn) < count and any(queues):
        for queue in queues:
            while queue and len(drawn) < count:
                change = queue.pop()
                text = open(change["file"]).read()
                line = text.count("\n", 0, change["at"]) + 1
                if (change["file"], line) not in lines:
                    lines.add((change["file"], line))
                    drawn.append(dict(change, line=line, text=text.split("\n")[line - 1].strip()))
                    break
    return drawn


def rows_of(table):
    with open(table, newline="") as text:
        return list(csv.DictReader(text))


def draw_again(table, known):
    """The changes of a table that no test has noticed or reached, where their sources still have them."""
    drawn = []
    for row in rows_of(table):
        path = row["file"]
        if row["result"] not in UNNOTICED or not os.path.exists(path) or os.path.realpath(path) not in known:
            continue
        text = open(path).read()
        lines = text.split("\n")
        same = [dict(change, module=row["module"], file=path, line=text.count("\n", 0, change["at"]) + 1)
                for change in changes(text) if (change["kind"], change["change"]) == (row["kind"], row["change"])]
        same = [change for change in same if lines[change["line"] - 1].strip() == row["text"]]
        if not same:
            print(f"{path}: the sources have no such line now: {row['text']}")
            continue
        nearest = min(abs(change["line"] - int(row["line"])) for change in same)
        drawn += [dict(change, text=row["text"]) for change in same if abs(change["line"] - int(row["line"])) == nearest]
    return drawn


def write_source(work, file, mutants):
    text = open(file).read()
    edits = sorted((edit[0], k, edit) for m in mutants if m["file"] == file and m["state"] == "drawn"
                   for k, edit in enumerate((e[0], e[1], e[2].replace("@", str(m["number"]))) for e in m["edits"]))
    for _, _, (start, end, new) in reversed(edits):
        text = text[:start] + new + text[end:]
    path = f"{work}/changed/selvedge/{file}"
    os.makedirs(os.path.dirname(path), exist_ok=True)
    open(path, "w").write(text)


def draw(options):
    random_number = random.Random(options.seed).random
    known = compile_commands(options.build)
    modules = options.modules.split(",")
    if options.again:
        return write_units(options, draw_again(options.again, known), known)
    share = [options.count // len(modules) + (k < options.count % len(modules)) for k in range(len(modules))]
    each = [draw_module(module, n, options.files, random_number, known) for module, n in zip(modules, share)]
    # Modules take turns, so that a run that is cut short has some of each.
    write_units(options, [m[k] for k in range(max(map(len, each))) for m in each if k < len(m)], known)


def write_units(options, mutants, known):
    flags, units = set(), collections.defaultdict(set)
    for number, mutant in enumerate(mutants, 1):
        target, commands = known[os.path.realpath(mutant["file"])]
        mutant.update(number=number, unit=f"{target}_unit", state="drawn", by="")
        flags.update(commands)
        units[mutant["unit"]].add(mutant["file"])
    includes = set()
    for unit, files in units.items():
        with open(f"{options.work}/{unit}.cpp", "w") as out:
            for file in sorted(files):
                write_source(options.work, file, mutants)
                includes.update(re.findall(SHARED, open(file).read(), re.M))
                out.write(f'#include "{os.path.abspath(options.work)}/changed/selvedge/{file}"\n')
    here = os.path.dirname(os.path.abspath(__file__))
    with open(f"{options.work}/headers.h", "w") as out:
        out.write(open(f"{here}/mutants_switch.h").read() + "\n".join(sorted(includes)) + "\n")
    open(f"{options.work}/flags", "w").write(" ".join(sorted(flags)))
    open(f"{options.work}/units", "w").write("".join(f"{unit}\n" for unit in sorted(units)))
    open(f"{options.work}/programs", "w").write("".join(f"{name}_tests\n" for name in PROGRAMS))
    save(options.work, mutants)
    drawn = f"again from {options.again}" if options.again else f"seed {options.seed}"
    print(f"{len(mutants)} changes in {sum(map(len, units.values()))} sources, {drawn}")


def save(work, mutants):
    with open(f"{work}/mutants.json.new", "w") as out:
        json.dump(mutants, out)
    os.replace(f"{work}/mutants.json.new", f"{work}/mutants.json")


# ---- drop

def drop(options):
    """Two compilers may run at once, so each unit keeps the numbers of its dropped changes in a file of its own."""
    mutants = load(options.work)
    unit = [m for m in mutants if m["unit"] == options.build and m["state"] == "drawn"]
    log = open(f"{options.work}/{options.build}.log").read()
    places = re.findall(r"changed/selvedge/([\w/.]+):(\d+):(?:\d+:)? *(?:error|  required)", log)
    places += re.findall(r"changed/selvedge/([\w/.]+):(\d+):\d+: +required from here", log)
    bad = {m["number"] for m in unit if (m["file"], str(m["line"])) in places}
    if not bad:  # an error in the rest of a statement, or of a file
        bad = {m["number"] for m in unit for file, line in places
               if m["file"] == file and 0 <= int(line) - m["line"] < 4}
    if not bad:
        bad = {m["number"] for m in unit if m["file"] in {file for file, _ in places}}
    if not bad:
        sys.exit(f"mutants.py: {options.build} does not compile:\n{log[:2000]}")
    with open(f"{options.work}/{options.build}.dropped", "a") as out:
        out.write("".join(f"{number}\n" for number in sorted(bad)))
    mutants = load(options.work)
    for file in {m["file"] for m in mutants if m["number"] in bad}:
        write_source(options.work, file, mutants)


def load(work):
    mutants = json.load(open(f"{work}/mutants.json"))
    dropped = {int(line) for name in os.listdir(work) if name.endswith(".dropped") for line in open(f"{work}/{name}")}
    for mutant in mutants:
        if mutant["number"] in dropped:
            mutant["state"] = "not compiled"
    return mutants


# ---- run

class Program:
    """A test program with all changes in it."""

    def __init__(self, options, name):
        self.options, self.name = options, name
        self.path = os.path.abspath(f"{options.work}/{name}")
        self.folder = f"{options.build}/tests"

    def tests(self):
        listed = subprocess.run([self.path, "--gtest_list_tests"], capture_output=True, text=True, check=True,
                                cwd=self.folder)
        suite, names = "", []
        for line in listed.stdout.split("\n"):
            word = line.split("#")[0].rstrip()
            if word.endswith(".") and not word.startswith(" "):
                suite = word
            elif word.startswith("  ") and "DISABLED" not in word:
                names.append(suite + word.strip())
        return names

    def start(self, tests, mutant=0, record=""):
        environment = dict(os.environ, SELVEDGE_MUTANT=str(mutant))
        environment.pop("SELVEDGE_REACHED", None)
        if record:
            environment["SELVEDGE_REACHED"] = record
        with open(f"{self.path}.log", "w") as log:
            return subprocess.Popen(
                [self.path, "--gtest_filter=" + ":".join(tests), "--gtest_brief=1"] +
                ([] if record else ["--gtest_fail_fast"]), cwd=self.folder, env=environment, stdout=log, stderr=log,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30)))

    def reach(self):
        """For each test that passes in time: its time in seconds, and the numbers of the changes that it reaches."""
        left, reached, skipped = self.tests(), {}, []
        while left:
            record = f"{self.path}.reached"
            open(record, "w").close()
            process = self.start(left, record=record)
            running, since = "", time.monotonic()
            while process.poll() is None:
                time.sleep(0.1)
                last = open(record).read().rstrip().split("\n")[-1]
                if last != running:
                    running, since = last, time.monotonic()
                if time.monotonic() - since > self.options.longest:
                    process.kill()
            process.wait()
            started = set()
            for line in open(record):
                words = line.split()
                if words[0] == "start":
                    started.add(words[1])
                elif words[3] == "1":
                    reached[words[1]] = (float(words[2]), {int(word) for word in words[4:]})
            if not started:
                break
            skipped += sorted(started - set(reached))
            left = [test for test in left if test not in started]
        if skipped:
            print(f"{self.name}: left out: {', '.join(skipped)}", flush=True)
        return reached

    def notices(self, mutant, tests, seconds):
        """The test that fails with the change, or an empty string."""
        limit = 10.0 * seconds + 2.0
        process = self.start(tests, mutant)
        try:
            status = process.wait(limit)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return f"{self.name}: no end within {limit:.0f} s"
        if status == 0:
            return ""
        failed = re.search(r"^\[  FAILED  \] ([\w./]+)", open(f"{self.path}.log", errors="replace").read(), re.M)
        if failed:
            return failed[1]
        return f"{self.name}: ends by signal {-status}" if status < 0 else f"{self.name}: exit code {status}"


def try_mutant(number, programs, reach, most):
    """Tests that reach the change, the fastest first, in batches of growing length."""
    tests = sorted((seconds, k, name) for k, tests in enumerate(reach) for name, (seconds, reached) in tests.items()
                   if number in reached)
    spent = 0.0
    for budget in (0.3, 2.0, 8.0, most):
        batch = collections.defaultdict(list)
        used = 0.0
        while tests and (not batch or used + tests[0][0] <= budget) and spent + tests[0][0] <= most:
            seconds, k, name = tests.pop(0)
            batch[k].append((seconds, name))
            used += seconds
            spent += seconds
        for k, some in batch.items():
            by = programs[k].notices(number, [name for _, name in some], sum(seconds for seconds, _ in some))
            if by:
                return by
    return ""


def equivalents():
    if not os.path.exists(EQUIVALENT):
        return {}
    lines = [line for line in open(EQUIVALENT) if not line.startswith("#")]
    return {(row["file"], row["text"], row["change"]): row["reason"] for row in csv.DictReader(lines)}


def write_table(path, mutants):
    with open(path, "w", newline="") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["module", "file", "line", "kind", "change", "text", "result", "by"])
        for m in sorted(mutants, key=lambda m: (MODULES.index(m["module"]), m["file"], m["line"])):
            table.writerow([m[key] for key in ("module", "file", "line", "kind", "change", "text", "state", "by")])


def merged(table, mutants):
    """The rows of a table with the results of the changes that were tried again. Of several in one line with the same
    description, the first that no test notices counts. What stays unnoticed keeps the reason that its row gives."""
    order = {"survived": 0, "not reached": 1}
    results = {}
    for m in sorted(mutants, key=lambda m: order.get(m["state"], 2), reverse=True):
        results[m["file"], m["text"], m["change"]] = m
    rows = []
    for row in rows_of(table):
        state = dict(row, line=int(row["line"]), state=row["result"])
        again = results.get((row["file"], row["text"], row["change"]))
        if row["result"] in UNNOTICED and again:
            explained = row["by"] if again["state"] == row["result"] else ""
            state.update(line=again["line"], state=again["state"], by=again["by"] or explained)
        rows.append(state)
    return rows


def print_table(mutants):
    states = ("not compiled", "not reached", "killed", "survived", "equivalent")
    print(f'{"module":<12}{"drawn":>7}' + "".join(f"{state:>14}" for state in states) + f'{"share killed":>14}')
    modules = [module for module in MODULES if any(m["module"] == module for m in mutants)]
    for module in modules + ["all"]:
        own = [m for m in mutants if module in ("all", m["module"])]
        count = collections.Counter(m["state"] for m in own)
        tried = count["killed"] + count["survived"] + count["not reached"]
        share = f'{100.0 * count["killed"] / tried:.0f} %' if tried else "-"
        print(f"{module:<12}{len(own):>7}" + "".join(f"{count[state]:>14}" for state in states) + f"{share:>14}")
    for m in mutants:
        if m["state"] in ("survived", "not reached"):
            print(f'{m["file"]}:{m["line"]}: {m["state"]}: {m["change"]}: {m["text"]}')


def run(options):
    mutants = load(options.work)
    programs = [Program(options, name) for name in open(f"{options.work}/programs").read().split()
                if os.path.exists(f"{options.work}/{name}")]
    reach = [program.reach() for program in programs]
    known = equivalents()
    for mutant in mutants:
        if mutant["state"] == "drawn":
            key = (mutant["file"], mutant["text"], mutant["change"])
            if key in known:
                mutant.update(state="equivalent", by=known[key])
            elif not any(mutant["number"] in reached for tests in reach for _, reached in tests.values()):
                mutant["state"] = "not reached"
            else:
                mutant["by"] = try_mutant(mutant["number"], programs, reach, options.seconds)
                mutant["state"] = "killed" if mutant["by"] else "survived"
            print(f'{mutant["number"]} {mutant["file"]}:{mutant["line"]}: {mutant["state"]}: {mutant["change"]}: '
                  f'{mutant["by"] or mutant["text"]}', flush=True)
            if not options.again:
                write_table(options.table or f"{options.work}/mutants.csv", [m for m in mutants if m["state"] != "drawn"])
    if options.again:
        mutants = merged(options.again, mutants)
        write_table(options.table or f"{options.work}/mutants.csv", mutants)
    print_table(mutants)
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=("draw", "drop", "run"))
    parser.add_argument("work", help="folder for the results")
    parser.add_argument("build", help="build folder; for `drop` the unit")
    parser.add_argument("--count", type=int, default=200, help="changes to draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--modules", default=",".join(MODULES))
    parser.add_argument("--files", type=int, default=8, help="sources of each module to draw from")
    parser.add_argument("--longest", type=float, default=10.0, help="seconds that a test may take, unchanged")
    parser.add_argument("--seconds", type=float, default=60.0, help="seconds of tests for a change, unchanged")
    parser.add_argument("--again", default="", metavar="TABLE",
                        help="tries the changes of this table again that no test noticed or reached, and draws no others")
    parser.add_argument("--table", default="", help="CSV file to write (default: mutants.csv in WORK)")
    options = parser.parse_args()
    return {"draw": draw, "drop": drop, "run": run}[options.command](options)


if __name__ == "__main__":
    sys.exit(main())
