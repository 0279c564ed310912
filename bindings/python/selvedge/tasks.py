# SPDX-License-Identifier: MIT
"""Hands that handle cloth: a gripper, and three tasks with a measure of success.

Each task is an environment in the form that libraries for learning share: `reset(seed)` and
`step(action)`. It needs NumPy alone.

    task = selvedge.tasks.FoldTowel()
    observation, info = task.reset(seed=3)
    policy = task.scripted_policy()
    while not (terminated or truncated):
        observation, reward, terminated, truncated, info = task.step(policy(observation))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arrays import numbers
from ._simulation import Scene, Simulation, SimulationFailed

__all__ = ["ClothTask", "FoldTowel", "Gripper", "HangTowel", "PullSleeve", "TASKS"]

Array = NDArray[np.float64]
Observation = dict[str, Array]
Policy = Callable[[Observation], Array]


class Waypoint(NamedTuple):
    """A target of a scripted policy."""

    tips: Union[Array, Callable[[Observation], Array]]  #: (g, 3) metres, fixed or from what is seen
    closed: bool
    pace: float = 1.0  #: share of the longest displacement that an action makes
    wait: int = 0  #: actions at the target


_GAP = 0.002  # m, that cloth keeps from bodies and from itself


class Gripper:
    """A hand of a simulation. Closing, it holds the cloth that is within `radius` of its tip; held
    cloth moves with the tip until it opens.

    Args:
        simulation: the simulation with the cloth.
        tip: (3,) metres.
        radius: metres.
    """

    def __init__(self, simulation: Simulation, tip: ArrayLike, radius: float = 0.015) -> None:
        self.simulation = simulation
        self.radius = float(radius)
        self.tip: Array = numbers(tip, "tip", 3).copy()
        self.held: NDArray[np.int32] = np.zeros(0, np.int32)
        self._offset: Array = np.zeros((0, 3))

    def close(self) -> int:
        """Holds the vertices within reach; returns how many they are. A closed hand stays as it
        is."""
        if not len(self.held):
            x = self.simulation.positions
            near = np.linalg.norm(x - self.tip, axis=1) < self.radius
            self.held = np.flatnonzero(near).astype(np.int32)
            self._offset = x[self.held] - self.tip
            self.simulation.hold(self.held)
        return len(self.held)

    def open(self) -> None:
        """Lets go."""
        self.simulation.release(self.held)
        self.held = np.zeros(0, np.int32)

    def move(self, tip: ArrayLike) -> None:
        """Moves the tip, and what it holds, to a place by the end of the present nominal step."""
        self.tip = numbers(tip, "tip", 3).copy()
        if len(self.held):
            self.simulation.hold(self.held, self.tip + self._offset)


class ClothTask:
    """A task with hands, as an environment. The derived classes set the scene and the measure.

    Actions are arrays (g, 4), a row for each hand: the displacement of its tip during the next
    `1 / fps` seconds, metres, at most `reach` long (longer ones are shortened), and a number that
    closes the hand if it is positive and opens it otherwise.

    Observations are dicts of arrays, copied from the simulation: "cloth" (n, 3) and "velocity"
    (n, 3) of its vertices, m and m/s; "tips" (g, 3), m; "holding" (g,), 1 while a hand holds cloth;
    "time" (1,), s. `info` has the dict "measure" of the task and "failure", the sentence of a
    step that no clean motion allowed.

    The reward is `score()`, from 0 to 1. An episode is terminated by a failure and truncated after
    `steps` actions; `success()` then says whether the task is done.

    Args:
        cells: cells along the shorter side of the cloth.
    """

    fps = 30
    hands = 2
    steps = 120  #: actions of an episode
    reach = 0.03  #: m, longest displacement of a tip in one action
    least = 0.9  #: score of a success

    simulation: Simulation
    grippers: list[Gripper]

    def __init__(self, cells: int = 12) -> None:
        self.cells = cells

    # What a task defines.

    def draw_scene(self, rng: np.random.Generator) -> tuple[dict[str, Any], Array]:
        """A scene as a dict, and the tips (g, 3) at its start; both drawn at random."""
        raise NotImplementedError

    def measure(self) -> dict[str, float]:
        """How far the task is done, by name."""
        raise NotImplementedError

    def score(self) -> float:
        """From 0 to 1: done."""
        raise NotImplementedError

    def waypoints(self, observation: Observation) -> list[Waypoint]:
        """Where a scripted policy takes the tips."""
        raise NotImplementedError

    # The environment.

    def reset(self, seed: Optional[int] = None) -> tuple[Observation, dict[str, Any]]:
        """Starts an episode. The same seed gives the same scene, to the bit."""
        scene, tips = self.draw_scene(np.random.default_rng(seed))
        scene["time"] = {"fps": self.fps, "frames": self.steps, "steps_per_frame": 4}
        scene["contact"] = {"rest_gap": _GAP}
        self.simulation = Simulation(Scene(scene))
        self.grippers = [Gripper(self.simulation, tip) for tip in tips]
        self._done = 0
        self._start = self._observe()
        return self._start, self._info("")

    def step(
        self, action: ArrayLike
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Makes one action: observation, reward, terminated, truncated, info.

        Raises:
            ValueError: the action has another shape or a number that is not finite.
        """
        given = numbers(action, "action", self.hands, 4)
        if not np.isfinite(given).all():
            raise ValueError("action: has a number that is not finite")
        moves = given[:, :3].copy()
        length = np.linalg.norm(moves, axis=1, keepdims=True)
        moves *= np.minimum(1.0, self.reach / np.maximum(length, 1e-12))
        for gripper, closing in zip(self.grippers, given[:, 3]):
            gripper.close() if closing > 0.0 else gripper.open()
        begin, tips = self._done / self.fps, [g.tip for g in self.grippers]

        def follow(simulation: Simulation) -> None:
            share = min(1.0, (simulation.nominal_end - begin) * self.fps)
            for gripper, tip, move in zip(self.grippers, tips, moves):
                gripper.move(tip + share * move)

        failure = ""
        try:
            self.simulation.advance_to_frame(self._done + 1, before_step=follow)
        except SimulationFailed as error:
            failure = str(error)
        self._done += 1
        over = self._done >= self.steps and not failure
        return self._observe(), self.score(), bool(failure), over, self._info(failure)

    def success(self) -> bool:
        """Whether the task is done: enough score, open hands, and clean at all times."""
        opened = all(not len(g.held) for g in self.grippers)
        return self.score() >= self.least and opened and self.simulation.clean

    def scripted_policy(self) -> Policy:
        """A policy for the present episode: it takes the tips from waypoint to waypoint."""
        left = self.waypoints(self._start)
        waited = [0]

        def wanted(observation: Observation) -> Array:
            return left[0].tips(observation) if callable(left[0].tips) else left[0].tips

        def act(observation: Observation) -> Array:
            tips, holding = observation["tips"], observation["holding"]
            move = wanted(observation) - tips
            # What slides away before a tip is never reached to the millimetre.
            near = 5e-3 if callable(left[0].tips) else 1e-3
            there = np.abs(move).max() < near and holding.all() == left[0].closed
            waited[0] += int(there)
            if there and len(left) > 1 and waited[0] > left[0].wait:
                left.pop(0)
                waited[0] = 0
                move = wanted(observation) - tips
            longest = max(np.linalg.norm(move, axis=1).max() / (left[0].pace * self.reach), 1.0)
            grip = np.full((len(tips), 1), 1.0 if left[0].closed else -1.0)
            return np.hstack([move / longest, grip])

        return act

    def run(self, seed: int, watch: Optional[Callable[[ClothTask], None]] = None) -> bool:
        """One episode with the scripted policy; returns its success. `watch` is called after every
        action."""
        observation, _ = self.reset(seed)
        policy = self.scripted_policy()
        terminated = truncated = False
        while not (terminated or truncated):
            observation, _, terminated, truncated, _ = self.step(policy(observation))
            if watch is not None:
                watch(self)
        return not terminated and self.success()

    def _observe(self) -> Observation:
        simulation = self.simulation
        return {
            "cloth": simulation.positions.copy(),
            "velocity": simulation.velocities.copy(),
            "tips": np.array([g.tip for g in self.grippers]),
            "holding": np.array([float(len(g.held) > 0) for g in self.grippers]),
            "time": np.array([simulation.time]),
        }

    def _info(self, failure: str) -> dict[str, Any]:
        return {"measure": self.measure(), "failure": failure}


def _fabric(rng: np.random.Generator) -> dict[str, float]:
    return {"density": rng.uniform(0.15, 0.3), "bending_stiffness": 10 ** rng.uniform(-5, -4)}


def _turned(points: Array, degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turned: Array = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return turned


def _grid(width: float, length: float, cells: int) -> tuple[Array, NDArray[np.int32], int]:
    """Vertices of a flat rectangle about the origin, row by row along x, triangles, and the number
    of vertices of a row."""
    across, along = cells, max(1, round(cells * length / width))
    x = np.linspace(-width / 2, width / 2, across + 1)
    y = np.linspace(-length / 2, length / 2, along + 1)
    vertices = np.array([[a, b, 0.0] for b in y for a in x])
    n = across + 1
    corner = np.array([j * n + i for j in range(along) for i in range(across)])
    a, b, c, d = corner, corner + 1, corner + n, corner + n + 1
    triangles = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])
    return vertices, triangles.astype(np.int32), n


def _mesh(vertices: Array, triangles: NDArray[np.int32]) -> dict[str, Any]:
    return {"vertices": vertices, "triangles": triangles}


def _path(points: Sequence[Array], closed: bool, pace: float = 1.0, wait: int = 0) -> list[Waypoint]:
    """Through these places; `wait` actions at the last one."""
    return [Waypoint(p, closed, pace) for p in points[:-1]] + [
        Waypoint(points[-1], closed, pace, wait)
    ]


class FoldTowel(ClothTask):
    """Fold a towel on a table once: bring its near edge, held by two hands, over the far edge.

    Drawn at random: place and turn of the towel, its weight, bending stiffness and friction.
    Measure: "distance", of the near edge from the far edge, seen from above, m (mean); "shadow", the
    area seen from above as a share of that of the open towel; "height" above the table, m.
    """

    side = 0.36
    steps = 110

    def draw_scene(self, rng: np.random.Generator) -> tuple[dict[str, Any], Array]:
        x, triangles, n = _grid(self.side, self.side, self.cells)
        place = np.array([rng.uniform(-0.03, 0.03), rng.uniform(-0.03, 0.03), 1.1 * _GAP])
        x = _turned(x, rng.uniform(-20, 20)) + place
        self._near, self._far = np.arange(n), np.arange(len(x) - n, len(x))
        self._triangles = triangles
        scene = {
            "name": "fold",
            "geometry": [{"name": "towel", "mesh": _mesh(x, triangles)}],
            "materials": {"default": {**_fabric(rng), "friction": rng.uniform(0.3, 0.6)}},
            "obstacles": [
                {
                    "name": "table",
                    "shape": {"type": "box", "size": [0.9, 0.9, 0.04]},
                    "transformation": {"translation": [0, 0, -0.02]},
                }
            ],
        }
        corners = x[[self._near[0], self._near[-1]]]
        return scene, corners + np.array([0.0, 0.0, 0.05])

    def measure(self) -> dict[str, float]:
        x = self.simulation.positions
        t = x[self._triangles][:, :, :2]
        a, b = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
        up = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]  # twice the area, negative where folded over
        distance = np.linalg.norm((x[self._near] - x[self._far])[:, :2], axis=1).mean()
        return {
            "distance": float(distance),
            "shadow": float(0.5 * up[up > 0].sum() / self.side**2),
            "height": float(x[:, 2].max()),
        }

    def score(self) -> float:
        return max(0.0, 1.0 - self.measure()["distance"] / self.side)

    def success(self) -> bool:
        measure = self.measure()
        return super().success() and measure["shadow"] < 0.6 and measure["height"] < 0.05

    def waypoints(self, observation: Observation) -> list[Waypoint]:
        x = observation["cloth"]
        start, end = x[[self._near[0], self._near[-1]]], x[[self._far[0], self._far[-1]]]
        middle, half = 0.5 * (start + end), 0.5 * (start - end)
        up = np.array([0.0, 0.0, 0.3 * self.side])  # lower than taut cloth would be
        arc = [
            middle + 0.98 * np.cos(angle) * half + np.sin(angle) * up
            for angle in np.linspace(0.0, np.pi, 13)[1:]
        ]
        away = end - 0.3 * half + np.array([0.0, 0.0, 0.06])

        def far_corners(now: Observation) -> Array:  # the towel may slide on the table
            return now["cloth"][[self._far[0], self._far[-1]]] + [0.0, 0.0, 4 * _GAP]

        return (
            _path([start], False)
            + _path([start, *arc[:-1]], True, 0.4)
            + [Waypoint(far_corners, True, 0.4, wait=3)]
            + _path([away], False)
        )


class HangTowel(ClothTask):
    """Hang a towel from a table over a bar: two hands take its near edge across the bar, until half
    of it hangs on each side, and let go.

    Drawn at random: place of the towel, height of the bar, weight, bending stiffness and friction.
    Measure: "near" and "far", the shares of the towel on the two sides of the bar, 0 if it does not
    lie on it; "lowest" vertex above the floor, m; "speed", the largest of a vertex, m/s.
    """

    width, length = 0.24, 0.44
    radius = 0.015  #: m, of the bar
    steps = 190

    def draw_scene(self, rng: np.random.Generator) -> tuple[dict[str, Any], Array]:
        x, triangles, n = _grid(self.width, self.length, self.cells)
        # The near edge, row 0, is next to the bar, which is at y = 0.
        x[:, 1] = -x[:, 1] - self.length / 2 - 0.06
        x = x + [rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.0), 0.1 + 1.1 * _GAP]
        self._bar = rng.uniform(0.42, 0.5)  # m, height of its axis
        self._near, self._triangles = np.arange(n), triangles[:, ::-1].copy()
        scene = {
            "name": "hang",
            "geometry": [{"name": "towel", "mesh": _mesh(x, self._triangles)}],
            "materials": {"default": {**_fabric(rng), "friction": rng.uniform(0.4, 0.6)}},
            "obstacles": [
                {
                    "name": "table",
                    "shape": {"type": "box", "size": [0.6, 0.6, 0.1]},
                    "transformation": {"translation": [0, -0.34, 0.05]},
                },
                {
                    "name": "bar",
                    "shape": {"type": "capsule", "radius": self.radius, "length": 0.5, "resolution": 24},
                    "transformation": {
                        "translation": [0, 0, self._bar],
                        "rotation": {"axis": [0, 1, 0], "angle_deg": 90},
                    },
                },
            ],
        }
        corners = x[[0, n - 1]]
        return scene, corners + np.array([0.0, 0.0, 0.05])

    def measure(self) -> dict[str, float]:
        x = self.simulation.positions
        heights = x[:, 2].reshape(-1, len(self._near)).mean(axis=1)  # of each row across
        top = int(heights.argmax())
        on_bar = abs(heights[top] - self._bar) < self.radius + 0.02
        share = top / (len(heights) - 1)
        return {
            "near": share if on_bar else 0.0,
            "far": 1.0 - share if on_bar else 0.0,
            "lowest": float(x[:, 2].min()),
            "speed": float(np.linalg.norm(self.simulation.velocities, axis=1).max()),
        }

    def score(self) -> float:
        measure = self.measure()
        return min(1.0, min(measure["near"], measure["far"]) / 0.3)

    def success(self) -> bool:
        measure = self.measure()
        return super().success() and measure["lowest"] > 0.15 and measure["speed"] < 1.0

    def waypoints(self, observation: Observation) -> list[Waypoint]:
        start = observation["cloth"][[self._near[0], self._near[-1]]]

        def at(y: float, z: float) -> Array:
            return np.array([[tip[0], y, z] for tip in start])

        top = self._bar + 0.5 * self.length
        lift = [at(float(start[0, 1]), self._bar), at(-0.04, top), at(0.05, top)]
        over = [at(0.08, self._bar + 0.06), at(0.03, self._bar - 0.42 * self.length)]
        let_go = [over[-1], over[-1] + np.array([0.0, 0.12, 0.0])]
        return (
            _path([start], False)
            + _path([start, *lift], True, 0.7)
            + _path(over, True, 0.3, wait=15)
            + _path(let_go, False)
        )


class PullSleeve(ClothTask):
    """Pull a sleeve over an arm that is stretched out: two hands hold its hem above and below and
    draw it from the hand of the arm to the shoulder.

    Drawn at random: the arm's radius, the place of the sleeve, weight and stiffness of its fabric.
    Measure: "covered", the length of the arm's axis that rings of the sleeve go around, as a share of
    the length of the sleeve.
    """

    length, radius = 0.24, 0.07  # m, of the sleeve
    steps = 110
    least = 0.75

    def draw_scene(self, rng: np.random.Generator) -> tuple[dict[str, Any], Array]:
        around = 2 * self.cells
        rings = max(2, round(self.length / (2 * np.pi * self.radius / around))) + 1
        angle = 2 * np.pi * np.arange(around) / around
        circle = self.radius * np.stack([0 * angle, np.sin(angle), np.cos(angle)], axis=1)
        begin = -0.05 - self.length
        x = np.concatenate(
            [circle + [begin + self.length * k / (rings - 1), 0, 0] for k in range(rings)]
        )
        i, k = np.meshgrid(np.arange(around), np.arange(rings - 1))
        a, b = (k * around + i).ravel(), (k * around + (i + 1) % around).ravel()
        triangles = np.concatenate(
            [np.stack([a, b + around, b], 1), np.stack([a, a + around, b + around], 1)]
        ).astype(np.int32)
        x = x + [0.0, rng.uniform(-0.01, 0.01), rng.uniform(-0.01, 0.01)]
        self._rings = np.arange(len(x)).reshape(rings, around)
        self._arm = 0.4  # m
        scene = {
            "name": "sleeve",
            "geometry": [{"name": "sleeve", "mesh": _mesh(x, triangles)}],
            "materials": {
                "default": {
                    "density": rng.uniform(0.1, 0.2),
                    "bending_stiffness": rng.uniform(2e-4, 6e-4),
                    "friction": 0.2,
                }
            },
            "obstacles": [
                {
                    "name": "arm",
                    "shape": {
                        "type": "capsule",
                        "radius": rng.uniform(0.03, 0.04),
                        "length": self._arm,
                        "resolution": 32,
                    },
                    "transformation": {
                        "translation": [0.04 + self._arm / 2, 0, 0],
                        "rotation": {"axis": [0, 1, 0], "angle_deg": 90},
                    },
                }
            ],
        }
        hem = self._rings[-1]
        self._held = hem[[0, around // 2]]  # above and below
        return scene, x[self._held]

    def measure(self) -> dict[str, float]:
        rings = self.simulation.positions[self._rings]
        angle = np.arctan2(rings[:, :, 1], rings[:, :, 2])
        turn = np.diff(np.concatenate([angle, angle[:, :1]], axis=1), axis=1)
        turns = np.round(((turn + np.pi) % (2 * np.pi) - np.pi).sum(axis=1) / (2 * np.pi))
        along = rings[:, :, 0].mean(axis=1)
        on = (np.abs(turns) == 1) & (along > 0.04) & (along < 0.04 + self._arm)
        covered = np.ptp(along[on]) if on.sum() > 1 else 0.0
        return {"covered": float(covered / self.length)}

    def score(self) -> float:
        return min(1.0, self.measure()["covered"])

    def waypoints(self, observation: Observation) -> list[Waypoint]:
        start = observation["cloth"][self._held]
        centred = start.copy()
        centred[:, 1] = 0.0
        centred[:, 2] = [self.radius, -self.radius]
        end = centred + [0.05 + 0.04 + self.length + 0.04, 0, 0]
        away = end + np.array([[0, 0, 0.05], [0, 0, -0.05]])
        return _path([start], False) + _path([start, centred, end], True, 0.6) + _path(
            [end, away], False
        )


#: The tasks by name.
TASKS: dict[str, type[ClothTask]] = {"fold": FoldTowel, "hang": HangTowel, "sleeve": PullSleeve}
