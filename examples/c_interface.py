# SPDX-License-Identifier: MIT
"""c_interface.py LIBRARY: the C interface from another language by plain foreign calls, without packages.

LIBRARY is the shared library, libselvedge.so. A body that the program moves pushes cloth; each frame is judged.
"""
import ctypes
import json
import sys
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint64, c_void_p

selvedge = ctypes.CDLL(sys.argv[1])


class Surface(ctypes.Structure):
    _fields_ = [("x_t0", POINTER(c_double)), ("x_t1", POINTER(c_double)), ("vertices", c_size_t),
                ("triangles", POINTER(c_int32)), ("triangle_count", c_size_t)]


class Verdict(ctypes.Structure):
    _fields_ = [*((name, c_uint64) for name in ("self_crossings", "body_crossings", "self_touches", "body_touches",
                                                "inside_vertices")),
                *((name, c_double) for name in ("max_penetration", "max_stretch", "max_compression")),
                ("first_self_crossing", c_int32 * 2), ("first_body_crossing", c_int32 * 2)]


def function(name, result, *arguments):
    found = getattr(selvedge, "selvedge_" + name)
    found.restype, found.argtypes = result, arguments
    return found


def checked(name, *arguments):
    inner = function(name, c_int, *arguments)

    def call(*given):
        if inner(*given) != 0:
            raise RuntimeError(last_error().decode())
    return call


last_error = function("last_error", c_char_p)
scene_create = checked("scene_create", c_char_p, c_char_p, POINTER(c_void_p))
scene_free = function("scene_free", None, c_void_p)
create = checked("simulation_create", c_void_p, POINTER(c_size_t), c_size_t, POINTER(c_void_p))
free = function("simulation_free", None, c_void_p)
advance = checked("simulation_advance", c_void_p, c_int)
move_body = checked("simulation_move_body", c_void_p, c_size_t, POINTER(c_double), c_size_t)
figure = checked("simulation_figure", c_void_p, c_char_p, POINTER(c_double))
judge = checked("judge", POINTER(Surface), POINTER(Surface), POINTER(c_double), POINTER(Verdict))
vertices = function("simulation_vertices", c_size_t, c_void_p)
positions = function("simulation_positions", POINTER(c_double), c_void_p)
triangles = function("simulation_triangles", POINTER(c_int32), c_void_p, POINTER(c_size_t))
body_begin = function("simulation_body_begin", c_size_t, c_void_p, c_size_t)
body_positions = function("simulation_body_positions", POINTER(c_double), c_void_p)
body_triangles = function("simulation_body_triangles", POINTER(c_int32), c_void_p, POINTER(c_size_t))


def surface(x, n, corners):
    count = c_size_t()
    rows = corners(simulation, byref(count))
    return Surface(x(simulation), None, n, rows, count)


scene, simulation = c_void_p(), c_void_p()
text = {"geometry": [{"cells": [16, 16]}], "gravity": [0, 0, 0],
        "obstacles": [{"shape": {"type": "sphere", "radius": 0.2}, "transformation": {"translation": [0, 0, 0.25]}}]}
try:
    scene_create(b'{"geometry": [{"cels": [4, 4]}]}', b"wrong.json", byref(scene))
except RuntimeError as error:
    print("refused:", error)
else:
    sys.exit("a scene with a wrong key was not refused")
scene_create(json.dumps(text).encode(), None, byref(scene))
create(scene, (c_size_t * 1)(0), 1, byref(simulation))
scene_free(scene)
start = [vertices(simulation), body_begin(simulation, 1)]
mean = sum(positions(simulation)[2:3 * start[0]:3]) / start[0]
for frame in range(1, 11):
    x = (c_double * (3 * start[1]))(*body_positions(simulation)[:3 * start[1]])
    for i in range(2, len(x), 3):
        x[i] -= 0.02
    move_body(simulation, 0, x, start[1])
    advance(simulation, frame)
    verdict = Verdict()
    judge(byref(surface(positions, start[0], triangles)), byref(surface(body_positions, start[1], body_triangles)), None,
          byref(verdict))
    if verdict.self_crossings or verdict.body_crossings:
        sys.exit(f"frame {frame}: the judge finds crossings")
stretch = c_double()
figure(simulation, b"max_stretch", byref(stretch))
pushed = mean - sum(positions(simulation)[2:3 * start[0]:3]) / start[0]
print(f"10 frames without a crossing; the ball pushed the cloth by {pushed:.3f} m and stretched it by {stretch.value:.4f}")
free(simulation)
if pushed <= 0.0:
    sys.exit("the ball did not push the cloth")
