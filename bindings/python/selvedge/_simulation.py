# SPDX-License-Identifier: MIT
"""Scenes, and simulations that are stepped in memory."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import callback, indices, path, positions, whole

__all__ = ["Scene", "Simulation", "SimulationFailed", "State", "VertexFlags"]

SimulationFailed = _core.SimulationFailed
SimulationFailed.__module__ = "selvedge"
SimulationFailed.__doc__ = """The simulation cannot continue: no step, however short, is clean, or
a particle has no finite position. `kind`: "not clean", "not finite", "stalled", "unstable step".
The simulation keeps its last good state."""

#: Names of the bits of `Simulation.flags()`, from bit 0 on.
VertexFlags: tuple[str, ...] = tuple(_core.flag_names)

PathLike = Union[str, "os.PathLike[str]"]


def _plain(value: Any) -> Any:
    """NumPy arrays and numbers as JSON has them."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"a scene cannot hold {type(value).__name__}: {value!r}")


def overrides(changes: Optional[Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Changes of a scene as pairs (path, JSON text)."""
    out = []
    if changes is not None and not isinstance(changes, Mapping):
        raise TypeError(f"changes: must be a dict, is {changes!r:.80}")
    for key, value in (changes or {}).items():
        text = value if isinstance(value, str) else json.dumps(value, default=_plain)
        out.append((str(key), text))
    return out


def body_number(scene: Scene, body: Union[str, int]) -> int:
    """The number of a body of a scene, from its name or number."""
    names = scene.bodies
    if isinstance(body, str):
        if body not in names:
            raise ValueError(f"no body is called {body!r}; the scene has {names}")
        return names.index(body)
    number = whole(body, "body")
    if not 0 <= number < len(names):
        raise ValueError(f"there is no body {number}; the scene has {len(names)}, from 0 on")
    return number


class Scene:
    """A scene: cloth, materials, bodies, time and contact, checked and complete.

    Args:
        source: the name of a scene file, or a dict with the same keys (docs/scene_files.md). NumPy
            arrays may stand for lists: {"mesh": {"vertices": x, "triangles": t}} makes a piece of
            cloth or a body from arrays.
        changes: replaces values, {"time.frames": 30, "geometry.0.cells": [50, 50]}.
        folder: folder that relative names of files in a dict start from; default: the present one.

    Raises:
        ValueError: one sentence with place, fault and remedy.
    """

    def __init__(
        self,
        source: Union[PathLike, Mapping[str, Any]],
        changes: Optional[Mapping[str, Any]] = None,
        *,
        folder: Optional[PathLike] = None,
    ) -> None:
        if isinstance(source, Mapping):
            text = json.dumps(source, default=_plain)
            self._place = os.path.abspath(path(folder or "", "folder", "the name of a folder"))
            name = os.path.join(path(folder or "", "folder"), "scene")
            self._core = _core.Scene.from_text(text, name, overrides(changes))
        else:
            file = path(source, "source", "a dict or the name of a file")
            self._place = os.path.dirname(os.path.abspath(file))
            self._core = _core.Scene.from_file(file, overrides(changes))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles keep the scene with all defaults; files of meshes stay where they are."""
        return _scene_from, (self._core.json, self._place)

    @property
    def name(self) -> str:
        """Name of the scene."""
        return self._core.name

    @property
    def frames(self) -> int:
        """Number of frames after the start."""
        return self._core.frames

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self._core.fps

    @property
    def step_length(self) -> float:
        """Length of a nominal step, seconds."""
        return 1.0 / (self._core.fps * self._core.steps_per_frame)

    @property
    def cloths(self) -> list[str]:
        """Names of the pieces of cloth."""
        return self._core.cloths

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies."""
        return self._core.bodies

    def to_dict(self) -> dict[str, Any]:
        """The scene with all defaults, as a scene file holds it."""
        return dict(json.loads(self._core.json))

    def __repr__(self) -> str:
        return (
            f"Scene({self.name!r}, cloths={self.cloths}, bodies={self.bodies}, "
            f"{self.frames} frames)"
        )


class State:
    """All that a simulation carries from one step to the next, from `Simulation.save`."""

    def __init__(self, core: _core.SavedState) -> None:
        self._core = core

    @property
    def time(self) -> float:
        """Seconds."""
        return self._core.time

    def __reduce__(self) -> tuple[Any, ...]:
        return _state_from, (self._core.text(),)


def _scene_from(text: str, place: str) -> Scene:
    """A pickled scene."""
    scene = Scene.__new__(Scene)
    scene._place = place
    scene._core = _core.Scene.from_text(text, os.path.join(place, "scene"), [])
    return scene


def _state_from(text: str) -> State:
    """A pickled state."""
    return State(_core.SavedState.from_text(text))


class Simulation:
    """The cloth of a scene in time, in memory. No file is read or written.

    Args:
        scene: a Scene, or what Scene takes.
        driven: names or numbers of the bodies that `move_body` moves. Their motion in the scene
            is replaced: they start where the scene has them and rest until they are moved.

    Raises:
        ValueError: the scene cannot be built, or cloth crosses something at the start.

    The arrays `positions`, `velocities`, `mass` and `body_positions` are read-only views of the
    simulation's memory: they change with every step. Copy what you keep: `sim.positions.copy()`.
    A view stays valid after the simulation is gone. The mesh changes only in scenes with "refine"
    or "merge", before the first step after a frame; take new views there.

    Ctrl-C works between steps. A simulation belongs to one thread at a time; several simulations
    may run in several threads.
    """

    def __init__(
        self,
        scene: Union[Scene, PathLike, Mapping[str, Any]],
        *,
        driven: Sequence[Union[str, int]] = (),
    ) -> None:
        self.scene = scene if isinstance(scene, Scene) else Scene(scene)
        if isinstance(driven, str) or not isinstance(driven, Iterable):
            raise TypeError(f"driven: must be a list of names or numbers, is {driven!r:.80}")
        numbers = [self._body(name) for name in driven]
        self._core: _core.Simulation = _core.Simulation(self.scene._core, numbers)

    @classmethod
    def _of_member(cls, scene: Scene, core: Any) -> Simulation:
        simulation = cls.__new__(cls)
        simulation.scene = scene
        simulation._core = core
        return simulation

    def _body(self, body: Union[str, int]) -> int:
        return body_number(self.scene, body)

    # -- stepping -----------------------------------------------------------------------------

    def step(self) -> None:
        """Makes one accepted step: a nominal step, the next part of one that was halved, or the
        change of the mesh that is due at a frame.

        Raises:
            SimulationFailed: no clean step is possible.
        """
        self._core.step()

    def advance_to_frame(
        self,
        frame: int,
        before_step: Optional[Callable[[Simulation], None]] = None,
        progress: Optional[Callable[[int, float], None]] = None,
    ) -> None:
        """Advances to the time of a frame (frame / fps seconds), to the same bits as the program.

        Args:
            frame: number of the frame, from 0 at the start; nothing happens if it has passed.
            before_step: called with the simulation before every step. It may call `set_forces`,
                `hold`, `release` and `move_body`.
            progress: called with the frame and the time in seconds after every frame.

        Raises:
            SimulationFailed: no clean step is possible.
            TypeError: the frame is not a whole number.
        """
        core = self._core
        frame = whole(frame, "frame")
        callback(before_step, "before_step")
        callback(progress, "progress")
        for following in range(core.frame + 1, frame + 1):
            while not core.reached(following):
                if before_step is not None:
                    before_step(self)
                core.step_towards(following)
            core.verify_frame()
            if progress is not None:
                progress(following, self.time)

    # -- inputs -------------------------------------------------------------------------------

    def set_forces(self, forces: Optional[ArrayLike]) -> None:
        """Sets forces on the vertices of the cloth, beside those of the scene, until set again.

        Args:
            forces: (n, 3) newtons, one row per vertex; None: no forces. They are constant during a
                step; a force that depends on velocities should change slowly from step to step.
        """
        if forces is None:
            forces = np.zeros((0, 3))
        self._core.set_forces(positions(forces, "forces"))

    def hold(self, vertices: ArrayLike, x: Optional[ArrayLike] = None) -> None:
        """Holds vertices of the cloth. Each moves on a straight line to its position by the end of
        the present nominal step, and rests there until it is held elsewhere or released.

        Args:
            vertices: (k,) indices.
            x: (k, 3) metres; None: where the vertices are now.
        """
        which = indices(vertices, "vertices", None)
        if x is None:
            n = len(self.positions)
            outside = which[(which < 0) | (which >= n)]
            if len(outside):
                raise ValueError(f"vertices: {outside[0]} is not among the {n} of the cloth")
            x = self.positions[which]
        self._core.hold(which, positions(x, "x"))

    def release(self, vertices: Optional[ArrayLike] = None) -> None:
        """Frees vertices that `hold` holds; None: all of them."""
        if vertices is None:
            self._core.release_all()
        else:
            self._core.release(indices(vertices, "vertices", None))

    def move_body(self, body: Union[str, int], x: ArrayLike) -> None:
        """Moves a driven body. Each vertex moves on a straight line to x[i] by the end of the
        present nominal step; then the body rests until it is moved again.

        Args:
            body: name or number, one of `driven`.
            x: (b, 3) metres, all vertices of the body (`body_vertices(body)`).
        """
        self._core.move_body(self._body(body), positions(x, "x"))

    # -- states -------------------------------------------------------------------------------

    def save(self) -> State:
        """The present state, for `restore`: positions, velocities, memory, driven bodies."""
        return State(self._core.save())

    def restore(self, state: State) -> None:
        """Continues from a saved state, to the same bits as if nothing had come between. Forces and
        held vertices have to be set again. Arrays taken before keep the old values.
        """
        if not isinstance(state, State):
            raise TypeError(f"state: must be a State, is {state!r:.80}")
        self._core.restore(state._core)

    # -- reading ------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Time of the state, seconds."""
        return self._core.time

    @property
    def steps(self) -> int:
        """Accepted steps so far."""
        return self._core.steps

    @property
    def nominal_end(self) -> float:
        """Time at which the nominal step ends that comes next or is under way, seconds: where what
        `hold` and `move_body` set arrives."""
        return self._core.nominal_end

    @property
    def last_step(self) -> float:
        """Length of the last step, seconds; 0 before the first one. A joined step has twice the
        nominal length `scene.step_length`, a halved one less."""
        return self._core.last_step

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, 3) metres, vertices of the cloth; a read-only view."""
        return self._core.positions

    @property
    def velocities(self) -> NDArray[np.float64]:
        """(n, 3) m/s; a read-only view."""
        return self._core.velocities

    @property
    def mass(self) -> NDArray[np.float64]:
        """(n,) kilograms; a read-only view."""
        return self._core.mass

    @property
    def triangles(self) -> NDArray[np.int32]:
        """(m, 3) vertices of the triangles of the cloth; a read-only view."""
        return self._core.triangles

    @property
    def body_positions(self) -> NDArray[np.float64]:
        """(b, 3) metres, vertices of all bodies in the order of the scene; a read-only view."""
        return self._core.body_positions

    @property
    def body_triangles(self) -> NDArray[np.int32]:
        """(k, 3) triangles of all bodies, vertices numbered as in `body_positions`."""
        return self._core.body_triangles

    def body_vertices(self, body: Union[str, int]) -> NDArray[np.float64]:
        """(b, 3) metres, vertices of one body; a read-only view."""
        begin = self._core.body_begin
        number = self._body(body)
        return self.body_positions[begin[number] : begin[number + 1]]

    def cloth_vertices(self, piece: Union[str, int]) -> slice:
        """The vertices of one piece of cloth, as a slice of `positions`."""
        names = self.scene.cloths
        if isinstance(piece, str) and piece not in names:
            raise ValueError(f"no piece of cloth is called {piece!r}; the scene has {names}")
        number = names.index(piece) if isinstance(piece, str) else whole(piece, "piece")
        begin = self._core.piece_begin
        if not 0 <= number < len(begin) - 1:
            raise ValueError(f"there is no piece {number}; the scene has {len(begin) - 1}")
        return slice(begin[number], begin[number + 1])

    def contacts(self) -> dict[str, NDArray[Any]]:
        """The contacts of the last step, c rows; empty before the first one.

        Returns:
            dict of arrays: "vertices" (c, 4) numbers cloth vertices first, then body vertices;
            "weights" (c, 4); "normal" (c, 3) unit, towards the first primitive; "gap" (c,) metres
            at the end of the step; "rest_gap" (c,) metres; "impulse" (c, 3) newton seconds on the
            first primitive, those of the contact response without a fail-safe; "kind" (c,) values
            of ContactKind.
        """
        return self._core.contacts()

    def measure_wrenches(self, on: bool = True) -> None:
        """Whether steps from now on measure what bodies, handles and held vertices feel."""
        self._core.measure_wrenches(bool(on))

    def wrenches(self, mean: bool = False, about: ArrayLike = (0.0, 0.0, 0.0)) -> dict[str, Any]:
        """Forces and torques of the last step, after measure_wrenches().

        Args:
            mean: of all steps since the last frame was reached instead of the last step alone.
            about: (3,) metres, the point to which torques belong.

        Returns:
            dict with "h", seconds; "bodies", "handles" and "solids" (bodies with "mass"): each a pair
            (force, torque) of arrays (k, 3) in newtons and newton metres that the cloth exerts, in
            the order of the scene; "body_mass": (mass (b,), centre (b, 3), inertia (b, 3, 3) about it)
            of the cloth that each body carries, kg, m and kg m^2, for engines that move the body and
            solve (m + mass) a' = force + mass a, with the acceleration a of the step before, which
            stays stable where the cloth is heavier than the body; "held" (m,) and
            "held_force" (m, 3): each vertex that handles or hold() keep, and the force on what keeps
            it; "others": by cause, (force, torque) on the cloth; "change": (force, torque), the change
            of its momentum per second. change = sum of others - bodies - held_force; "force_error"
            and "torque_error" say how nearly, as shares.

        Raises:
            RuntimeError: if wrenches are not measured.
        """
        point = [float(c) for c in np.asarray(about, dtype=np.float64).reshape(3)]
        return self._core.wrenches(bool(mean), point)

    def contact_pressure(self) -> NDArray[np.float64]:
        """(n,) pascals: normal contact force of the last step per area of each cloth vertex.

        Impulses of the response along the contact normals, shared among the vertices of the
        primitives by their weights, divided by the length of the step and the present area.
        """
        table = self.contacts()
        h = self._core.last_step
        n = len(self.positions)
        force = np.zeros(n)
        if h > 0.0 and len(table["gap"]):
            along = np.abs(np.einsum("ij,ij->i", table["impulse"], table["normal"])) / h
            shares = np.abs(table["weights"]) * along[:, None]
            of_cloth = table["vertices"] < n
            np.add.at(force, table["vertices"][of_cloth], shares[of_cloth])
        areas = self._core.vertex_areas
        return np.divide(force, areas, out=np.zeros(n), where=areas > 0.0)

    def energies(self) -> dict[str, float]:
        """Energies of the state in joules by name: kinetic, gravity, stretch_and_shear, ..."""
        return self._core.energies()

    def flags(self) -> NDArray[np.uint8]:
        """(n,) guarantees that do not hold at each vertex, as bits named by `VertexFlags`. 0: all
        hold."""
        return self._core.flags()

    def result(self) -> dict[str, Any]:
        """Clean or not, steps, strain, times of phases, counters, as in result.json."""
        return dict(json.loads(self._core.result_text()))

    @property
    def clean(self) -> bool:
        """No accepted state and no path between two of them had an intersection; `result()` says in
        "unchecked" which paths were not searched."""
        return bool(self.result()["clean"])

    @property
    def state_hash(self) -> str:
        """Hash of positions, velocities and water: equal for equal bits."""
        return self._core.state_hash

    @property
    def warnings(self) -> list[str]:
        """One sentence for each possible mistake in the scene, such as a body that is not closed."""
        return self._core.warnings

    def __repr__(self) -> str:
        return (
            f"Simulation({self.scene.name!r}, {self.time:g} s, {len(self.positions)} vertices, "
            f"{self.steps} steps)"
        )
