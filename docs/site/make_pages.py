# SPDX-License-Identifier: MIT
"""make_pages.py SOURCE_TREE SITE METHODS.json: the pages of the site that follow from the program and the headers."""
import json
import pathlib
import sys

MODULES = {
    "core": "Cloth: meshes, fabrics, forces, integrators, strain limiters.",
    "bodies": "Bodies: analytic shapes, meshes from files, motion, exact predicates.",
    "broadphase": "Pairs of points, edges and triangles that may meet during a step.",
    "narrowphase": "Whether a pair collides during a step, and when.",
    "response": "Contact responses, and the fail-safes that remove the collisions that a response leaves.",
    "detection": "Collisions, crossings and contacts of plain arrays, one call each.",
    "garment": "Sewing patterns: reading, checks, meshes of the panels.",
    "scene": "Scenes: from a file or made in code, checked and built.",
    "simulation": "Steps of a scene in memory: contacts, crossings, untangling, refinement, plan.",
    "run": "Scenes into result folders: frames, checkpoint, result, replay, failure bundle.",
    "judge": "The independent exact check of states and motions.",
    "render": "Pictures and animations.",
    "view": "Pages that show results in a browser.",
    "dress": "Garments from sewing patterns, put on bodies.",
    "lab": "Drape tests of fabrics, identification of constants, measures of results.",
    "compare": "Error against run time, stability, ablation, checks of result folders.",
}

FAMILIES = {
    "pattern": "Meshes of cloth",
    "force": "Forces",
    "strain_limiter": "Strain limiters",
    "integrator": "Integrators",
    "broad_phase": "Broad phase",
    "narrow_phase": "Narrow phase",
    "response": "Response",
    "fail_safe": "Fail-safe",
    "body": "Bodies",
    "output_format": "Output formats",
    "drape": "Drape by geometry",
    "identification": "Identification of constants",
}


def cell(text):
    return text.replace("|", "\\|").replace("\n", " ")


def methods_page(methods):
    lines = ["# All methods", "", "The methods of the build that made this site, as `selvedge list` prints them.", ""]
    families = list(FAMILIES) + sorted({m["family"] for m in methods} - set(FAMILIES))
    for family in families:
        rows = [m for m in methods if m["family"] == family]
        if not rows:
            continue
        lines += [f"## {FAMILIES.get(family, family)}", "", "| name | guarantee | source |", "| --- | --- | --- |"]
        for m in rows:
            absent = "" if m["available"] else " (not in this build)"
            lines.append(f"| `{m['name']}`{absent} | {cell(m['guarantee'])} | {cell(m['source'])} |")
        lines.append("")
    return "\n".join(lines)


def module_page(tree, module, says):
    lines = [f"# {module}", "", says, ""]
    for header in sorted((tree / module).glob("*.h")):
        include = f"selvedge/{module}/{header.name}"
        lines += [f"## {header.name}", "", f"`#include <{include}>`", "",
                  f"```{{doxygenfile}} {module}/{header.name}", ":sections: briefdescription detaileddescription "
                  "innernamespace innerclass public-attrib public-func public-static-func public-type enum func "
                  "typedef var define", "```", ""]
    return "\n".join(lines)


def head_of(source):
    """The comment at the head of a file, below the licence: what it implements, by which equation, what it promises."""
    lines = source.read_text().splitlines()
    head = []
    for line in lines[1:]:
        if not line.startswith("//"):
            break
        head.append(line[2:].removeprefix(" "))
    return "\n".join(head).strip()


def heads_page(tree, module):
    """Empty for a module whose files have no such comment; docs/site/index.md lists the others."""
    lines = [f"# Implementation notes: {module}", "",
             "Paper, equation, deviations and guarantee of each method, from the comment at the head of its file.", ""]
    for source in sorted((tree / module).glob("*.cpp")):
        head = head_of(source)
        if head.count("\n") < 2:
            continue
        lines += [f"## {source.stem}", "", "```text", head, "```", ""]
    return "\n".join(lines) if len(lines) > 4 else ""


def main():
    tree, site, listing = (pathlib.Path(p) for p in sys.argv[1:])
    (site / "all_methods.md").write_text(methods_page(json.loads(listing.read_text())["methods"]))
    (site / "api").mkdir(exist_ok=True)
    index = ["# Headers", "", "Public headers by module. The page \"The library\" shows which module uses which.", "",
             "```{toctree}", ":maxdepth: 1", ""]
    (site / "heads").mkdir(exist_ok=True)
    for module, says in MODULES.items():
        if heads := heads_page(tree, module):
            (site / "heads" / f"{module}.md").write_text(heads)
        (site / "api" / f"{module}.md").write_text(module_page(tree, module, says))
        index.append(module)
    (site / "api" / "index.md").write_text("\n".join(index + ["```", ""]))
    bib = (tree / "docs" / "references.bib").read_text()
    (site / "references.md").write_text(f"# References\n\nKeys as the sources cite them.\n\n```bibtex\n{bib}\n```\n")


main()
