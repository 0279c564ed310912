# SPDX-License-Identifier: MIT
"""selvedge: exact cloth collision and cloth that passes through nothing.

Detection on arrays, exact and in one call:
    find_collisions(x0, x1, triangles)    collisions during a step, with times of impact
    find_crossings(x, triangles)          triangles that cross in one state
    find_touches(x, triangles)            triangles that only touch
    find_contacts(x, triangles, d)        primitives nearer than d
    find_candidates(x0, x1, triangles)    pairs of a broad phase
    Detector(broad_phase, narrow_phase)   the same with methods that are kept between calls
    ccd.point_triangle(q), ccd.edge_edge(q)   single pairs, in batches

Simulation:
    Scene(file_or_dict), Simulation(scene)    steps in memory: arrays in and out
    Batch(scenes)                             many scenes, stepped together on all cores
    run(scene, folder)                        a run with files, as `selvedge run`
    dress(pattern, body, folder)              a garment on a body, as `selvedge dress`

Results:
    check(mesh or folder)     the exact check, which shares no code with the simulation
    measure(folder)           strains, energies, drape
    compare(scene, vary, folder)   error against run time of methods
    render(x, triangles), render_result(folder), write_png(file, image)

Tasks:
    tasks.FoldTowel(), HangTowel(), PullSleeve()   environments for hands: reset(seed), step(action)

Methods:
    list_methods()    every method of this build, with promise, source and options
    licence()         version, licence and libraries of this build

Arrays: vertices are float64 (n, 3) in metres, triangles int32 (m, 3). Arrays of that type and in C
order are used without a copy, others are copied; anything else is refused in one sentence. All
quantities are in SI units. Errors of the input are ValueError or TypeError, other errors
RuntimeError or SimulationFailed. Long calls let other Python threads run. All results are the same
for any number of threads.
"""

from __future__ import annotations

from typing import Any

from . import _core, ccd, tasks
from ._arrays import whole
from ._batch import Batch
from ._detection import (
    Candidates,
    Collisions,
    ContactKind,
    Contacts,
    Detector,
    find_candidates,
    find_collisions,
    find_contacts,
    find_crossings,
    find_touches,
)
from ._dress import dress
from ._results import check, compare, measure, render, render_result, run, write_png
from ._simulation import Scene, Simulation, SimulationFailed, State, VertexFlags

__all__ = [
    "Batch",
    "Candidates",
    "Collisions",
    "ContactKind",
    "Contacts",
    "Detector",
    "Scene",
    "Simulation",
    "SimulationFailed",
    "State",
    "ThreadLimit",
    "VertexFlags",
    "ccd",
    "check",
    "compare",
    "dress",
    "find_candidates",
    "find_collisions",
    "find_contacts",
    "find_crossings",
    "find_touches",
    "licence",
    "list_methods",
    "measure",
    "render",
    "render_result",
    "run",
    "tasks",
    "write_png",
]

__version__: str = _core.version_text().split("\n", 1)[0].split()[-1]


def list_methods() -> list[dict[str, Any]]:
    """Every method of this build, from the registry that scenes, messages and `compare` use.

    Returns:
        A list of dicts: "family" ("broad_phase", "narrow_phase", "response", ...), "name", "key"
        of scene files that selects it, "promise", "source", "library" that it comes from ("" for
        selvedge itself), "available" (False: this build lacks the library), and "options", a list
        of dicts with "name", "default", "unit", "least", "most", "meaning".
    """
    return _core.list_methods()


def licence() -> str:
    """Version and licence of this build, and its libraries with their versions and licences."""
    return _core.version_text()


class ThreadLimit:
    """Limits the threads of selvedge while a `with` block runs; results do not change.

    Args:
        threads: number of threads; 0: all cores.
    """

    def __init__(self, threads: int) -> None:
        self._scope = _core.ThreadScope(whole(threads, "threads"))

    def __enter__(self) -> ThreadLimit:
        self._scope.enter()
        return self

    def __exit__(self, *_: object) -> None:
        self._scope.leave()
