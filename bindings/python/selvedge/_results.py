# SPDX-License-Identifier: MIT
"""Runs into folders, exact checks, measures, comparisons and pictures."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import callback, mesh as _mesh, number, numbers, path, positions, triangles as _triangles, whole
from ._simulation import PathLike, Scene, overrides

__all__ = ["check", "compare", "measure", "render", "render_result", "run", "write_png"]

Progress = Optional[Callable[[int, int], None]]


def run(
    scene: Union[Scene, PathLike, Mapping[str, Any]],
    out: PathLike,
    *,
    resume: bool = False,
    overwrite: bool = False,
    every_step: bool = False,
    progress: Optional[Callable[[int, float], None]] = None,
) -> dict[str, Any]:
    """Runs a scene into a result folder, as `selvedge run` does: frames, checkpoint, result.json.

    Args:
        scene: a Scene, or what Scene takes.
        out: result folder, made if it does not exist.
        resume: continue from the checkpoint in the folder.
        overwrite: replace the results of an earlier run in the folder.
        every_step: also write every accepted state, which `check` then checks with its paths.
        progress: called with the number of each frame and the seconds since the start.

    Returns:
        The content of result.json.

    Raises:
        ValueError: the scene cannot start, or the folder holds something else, or the results of
            an earlier run without `resume` or `overwrite`.
        SimulationFailed: the run failed; the folder has a failure bundle.
        KeyboardInterrupt: after Ctrl-C and the end of the present frame; `resume` continues.
    """
    given = scene if isinstance(scene, Scene) else Scene(scene)
    options = {
        "out": path(out, "out"),
        "resume": resume,
        "overwrite": overwrite,
        "every_step": every_step,
    }
    return dict(json.loads(_core.run(given._core, options, callback(progress, "progress"))))


def check(
    what: Any,
    triangles: Optional[ArrayLike] = None,
    *,
    against: Any = None,
    rest: Any = None,
    next: Optional[ArrayLike] = None,  # noqa: A002
    against_next: Optional[ArrayLike] = None,
    paths: bool = False,
    progress: Progress = None,
) -> Any:
    """Checks meshes exactly, whoever made them. Shares no code with the simulation.

    Args:
        what: (n, 3) vertices in metres, with `triangles`; or the name of a mesh file; or a list
            of them in order of time; or the name of a result folder.
        triangles: (m, 3) vertex indices.
        against: the body: (vertices, triangles), or the name of a mesh file.
        rest: the rest shape, from which strains are measured: (vertices, triangles) or a file.
        next: (n, 3) metres; arrays only: also checks the straight path to these positions.
        against_next: the vertices of the body at the end of the path; default: it rests.
        paths: files only: also checks the path from each file to the next.
        progress: result folders only: called with the number of checked states and of all.

    Returns:
        A dict: self_intersections and body_intersections (pairs of triangles that cross),
        self_touches and body_touches (those that only touch), inside_vertices,
        max_penetration_m, max_stretch, max_compression and, with paths, path_self_collisions and
        path_body_collisions. For a result folder these are the worst of all states, with the
        number of states and paths and the first_wrong and last_wrong file. For a list of files: a
        list of dicts.

    Raises:
        ValueError: a mesh cannot be read or checked.
    """
    if triangles is not None:
        cloth = (positions(what, "x"), _triangles(triangles, "triangles"))
        return _core.check_arrays(
            cloth,
            None if against is None else _mesh(against, "against"),
            None if rest is None else _mesh(rest, "rest"),
            None if next is None else positions(next, "next"),
            None if against_next is None else positions(against_next, "against_next"),
        )
    if next is not None or against_next is not None:
        raise ValueError("check: `next` goes with arrays; use `paths` for files")
    name_of_rest = "" if rest is None else path(rest, "rest")
    if isinstance(what, (str, os.PathLike)) and os.path.isdir(what):
        if against is not None or paths:
            raise ValueError("check: a result folder contains its bodies and its paths")
        return _core.check_folder(path(what, "what"), name_of_rest, callback(progress, "progress"))
    single = isinstance(what, (str, os.PathLike))
    if not single and isinstance(what, np.ndarray):
        raise TypeError("check: vertices need `triangles`")
    files = [path(what, "what")] if single else [path(name, "what") for name in what]
    bodies = [] if against is None else [path(against, "against")]
    rows = _core.check_files(files, bodies, name_of_rest, paths)
    return rows[0] if single else rows


def measure(
    folder: PathLike,
    frame: int = -1,
    *,
    support_radius: Optional[float] = None,
    support_centre: Optional[tuple[float, float]] = None,
) -> dict[str, Any]:
    """Measures a frame of a result folder: strains, energies, drape coefficient, folds.

    Args:
        folder: result folder of a run.
        frame: number of the frame; -1: the last one.
        support_radius: metres, radius of the drape support; default: the scene's first upright
            cylinder.
        support_centre: metres, its centre (x, y).

    Returns:
        The content of measures.json (docs/fabrics.md), and under "arrays": "x" (n, 3),
        "triangles" (m, 3), "triangle_strain" (m, 2) smaller and larger principal strain,
        "spring_vertices" (k, 2) and "spring_strain" (k,).

    Raises:
        ValueError: the folder has no scene or frames, or no such frame.
    """
    text, arrays = _core.measure(
        path(folder, "folder"), whole(frame, "frame"), support_radius, support_centre
    )
    out: dict[str, Any] = json.loads(text)
    out["arrays"] = arrays
    return out


def compare(
    scene: PathLike,
    vary: Union[str, Sequence[str]],
    out: PathLike,
    *,
    changes: Optional[Mapping[str, Any]] = None,
    design: str = "product",
    reference: bool = True,
    error: str = "position",
    repeats: int = 7,
    threads: int = 1,
    budget: float = 300.0,
    progress: Progress = None,
) -> dict[str, Any]:
    """Measures error against run time while values of a scene vary, as `selvedge compare` does.

    Args:
        scene: name of a scene file.
        vary: "broad_phase=bvh_aabb,sweep", "dt=1e-3..1e-2:5", "integrator=all", or a list.
        out: folder of the comparison; a second call continues it. Gets compare.html, .csv, .json.
        changes: replaces values of the scene in all cells, as in Scene.
        design: "product" for every combination, or "one" to vary one value at a time.
        reference: compute a converged reference, from which errors are measured.
        error: quantity of the errors, such as "position", "drape", "strain", "energy".
        repeats: runs of each cell.
        threads: threads of a run; 0: all.
        budget: seconds allowed for a run.
        progress: called with the number of finished runs and of all.

    Returns:
        The content of compare.json; "rows" has a dict for each cell.

    Raises:
        ValueError: the scene or a value cannot be used.
        KeyboardInterrupt: after Ctrl-C; a second call continues.

    Every run has a process of its own, which a process with several threads cannot start. The
    function therefore starts a second Python process that only compares.
    """
    if design not in ("product", "one"):
        raise ValueError(f'compare: design must be "product" or "one", is {design!r}')
    if error not in _core.error_names():
        raise ValueError(f"compare: error must be one of {_core.error_names()}, is {error!r}")
    axes = [vary] if isinstance(vary, str) else list(vary)
    command = " ".join(["selvedge compare", path(scene, "scene")] + [f"--vary {a}" for a in axes])
    request: dict[str, Any] = {
        "scene": os.path.abspath(path(scene, "scene")),
        "set": overrides(changes),
        "vary": axes,
        "design": design,
        "reference": reference,
        "error": error,
        "repeats": repeats,
        "threads": threads,
        "budget": budget,
        "command": command,
        "out": os.path.abspath(path(out, "out")),
    }
    for job in ("plan", "run"):
        _work(job, request, progress)
    return dict(json.loads(_core.compare_table(request["out"])))


def _work(job: str, request: Mapping[str, Any], progress: Progress) -> None:
    """One job of a comparison in a process that loads nothing but the compiled half."""
    worker = Path(__file__).with_name("_worker.py")
    with subprocess.Popen(
        [sys.executable, "-I", os.fspath(worker), job],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(json.dumps(dict(request)))
            process.stdin.close()
            fault = None
            for line in process.stdout:
                message = json.loads(line)
                if "fault" in message:
                    fault = message
                elif progress is not None:
                    progress(message["done"], message["all"])
        except BaseException:
            process.terminate()
            raise
    if fault is not None:
        raise (ValueError if fault["is_value"] else RuntimeError)(fault["fault"])
    if process.returncode != 0:
        raise RuntimeError(f"the process that compares ended with {process.returncode}")


Colour = Optional[tuple[float, float, float]]


def _camera(
    eye: Any, target: Any, field_of_view: Optional[float], width: Optional[int], height: Optional[int]
) -> dict[str, Any]:
    def point(value: Any, name: str) -> Any:
        return None if value is None else tuple(numbers(value, name, 3).tolist())

    return {
        "eye": point(eye, "eye"),
        "target": point(target, "target"),
        "field_of_view": None if field_of_view is None else number(field_of_view, "field_of_view"),
        "width": None if width is None else whole(width, "width"),
        "height": None if height is None else whole(height, "height"),
    }


def render(
    x: ArrayLike,
    triangles: ArrayLike,
    *,
    bodies: Sequence[tuple[Any, ...]] = (),
    colour: Colour = None,
    body_colour: Colour = (0.32, 0.34, 0.38),
    eye: Optional[ArrayLike] = None,
    target: Optional[ArrayLike] = None,
    field_of_view: Optional[float] = None,
    width: int = 960,
    height: int = 720,
    ground: bool = True,
) -> NDArray[np.uint8]:
    """Draws meshes with soft shadows; needs no display.

    Args:
        x: (n, 3) metres, vertices of the cloth.
        triangles: (m, 3) vertex indices.
        bodies: pairs (vertices, triangles), or (vertices, triangles, colour).
        colour, body_colour: linear red, green, blue in [0, 1]; None: those of the program.
        eye, target: (3,) metres; default: so that everything just fits.
        field_of_view: degrees, vertical.
        width, height: pixels.
        ground: draw the shadow on the ground.

    Returns:
        (height, width, 3) uint8, sRGB.

    Raises:
        ValueError: a mesh has an invalid index or coordinate, or the camera no size or direction.
    """

    def drawn(vertices: ArrayLike, faces: ArrayLike, name: str, tint: Colour, crease: float) -> Any:
        usual = (-1.0, 0.0, 0.0)
        rgb = usual if tint is None else tuple(numbers(tint, f"{name}: colour", 3).tolist())
        return _core.Drawn(
            positions(vertices, f"{name}: vertices"),
            _triangles(faces, f"{name}: triangles"),
            rgb,
            rgb,
            crease,
        )

    surfaces = [drawn(x, triangles, "cloth", colour, 180.0)]
    for body in bodies:
        tint = body[2] if len(body) == 3 else body_colour
        surfaces.append(drawn(body[0], body[1], "body", tint, 40.0))
    return _core.render(surfaces, _camera(eye, target, field_of_view, width, height), ground)


def render_result(
    folder: PathLike,
    frame: int = -1,
    *,
    eye: Optional[ArrayLike] = None,
    target: Optional[ArrayLike] = None,
    field_of_view: Optional[float] = None,
    width: Optional[int] = None,
    height: Optional[int] = None,
) -> NDArray[np.uint8]:
    """Draws a frame of a result folder, or a mesh file, as `selvedge render` does.

    Args:
        folder: result folder, or a mesh file.
        frame: number of the frame; -1: the last one.
        eye, target, field_of_view, width, height: as in `render`; default: those of the scene.

    Returns:
        (height, width, 3) uint8, sRGB.
    """
    camera = _camera(eye, target, field_of_view, width, height)
    return _core.render_result(path(folder, "folder"), whole(frame, "frame"), camera)


def write_png(file: PathLike, image: ArrayLike) -> None:
    """Writes a picture: (height, width, 3) uint8."""
    picture = np.asarray(image)
    if picture.dtype != np.uint8:
        raise TypeError(f"image: must hold uint8, has the data type {picture.dtype}")
    _core.write_png(path(file, "file"), np.ascontiguousarray(picture))
