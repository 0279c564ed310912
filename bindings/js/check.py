# SPDX-License-Identifier: MIT
"""check.py LIBRARY PATTERN.json BODY.ply [SCENE.json ...]: prints what check.mjs prints, from the native libselvedge.so, with one thread."""
import ctypes
import struct
import sys
import time
from ctypes import POINTER, byref, c_double, c_int, c_int32, c_size_t, c_uint8, c_uint64, c_void_p

library = ctypes.CDLL(sys.argv[1])
library.selvedge_last_error.restype = ctypes.c_char_p
POINT_TRIANGLE, EDGE_EDGE = 0, 2


class Surface(ctypes.Structure):
    _fields_ = [("x0", POINTER(c_double)), ("x1", POINTER(c_double)), ("n", c_size_t), ("triangles", POINTER(c_int32)),
                ("count", c_size_t)]


class Contacts(ctypes.Structure):
    _fields_ = [("count", c_size_t), ("kind", POINTER(c_uint8)), ("vertices", POINTER(c_int32)), ("weights", POINTER(c_double)),
                ("normal", POINTER(c_double)), ("primitives", POINTER(c_int32)), ("toi", POINTER(c_double)), ("gap", POINTER(c_double))]


class Pairs(ctypes.Structure):
    _fields_ = [("count", c_size_t), ("index", POINTER(c_int32))]


def call(name, *arguments):
    return getattr(library, "selvedge_" + name)(*arguments)


def checked(name, *arguments):
    if call(name, *arguments) != 0:
        raise RuntimeError(library.selvedge_last_error().decode())


def generator(seed):
    state = seed
    while True:
        state = (state * 1664525 + 1013904223) % 2**32
        yield state / 4294967296


def show(label, values, double=False):
    print(" ".join([label, *(struct.pack(">d", x).hex() if double else str(x) for x in values)]))


def soup(seed, count):
    random, x0, x1, triangles = generator(seed), [], [], []
    for i in range(count):
        at = [next(random), next(random), next(random)]
        for _ in range(3):
            for d in range(3):
                x0.append(at[d] + 0.8 * next(random))
                x1.append(x0[-1] + 0.2 * next(random))
        triangles += [3 * i, 3 * i + 1, 3 * i + 2]
    n = len(x0)
    return Surface((c_double * n)(*x0), (c_double * n)(*x1), n // 3, (c_int32 * len(triangles))(*triangles), count)


def detector(broad_phase=None):
    out = c_void_p()
    checked("detector_create", broad_phase, None, c_double(0.0), byref(out))
    return out


finder = detector()
for seed in range(1, 6):
    a, b = soup(seed, 40), soup(seed + 100, 30)
    for other in (None, byref(b)):
        found, near = POINTER(Contacts)(), POINTER(Contacts)()
        checked("find_collisions", finder, byref(a), other, byref(found))
        n = found.contents.count
        show("collisions", found.contents.vertices[:4 * n])
        show("toi", found.contents.toi[:n], True)
        show("weights", found.contents.weights[:4 * n], True)
        show("normal", found.contents.normal[:3 * n], True)
        lists = POINTER(Pairs)(), POINTER(Pairs)()
        checked("find_meetings", byref(a), other, byref(lists[0]), byref(lists[1]))
        for name, pairs in zip(("crossings", "touches"), lists):
            show(name, pairs.contents.index[:2 * pairs.contents.count] if pairs.contents.count else [])
        checked("find_contacts", byref(a), other, c_double(0.02), byref(near))
        show("gaps", near.contents.gap[:near.contents.count], True)
    random = generator(seed + 1000)
    queries = (c_double * (24 * 200))(*(next(random) for _ in range(24 * 200)))
    for kind in (POINT_TRIANGLE, EDGE_EDGE):
        toi, lo, hi = (c_double * 200)(), (c_double * 200)(), (c_double * 200)()
        checked("impact_times", None, c_int(kind), queries, c_size_t(200), toi)
        checked("touch_times", c_int(kind), queries, c_size_t(200), lo, hi)
        show("impact", toi, True)
        show("touch", hi, True)
    verdict = ctypes.create_string_buffer(80)
    checked("judge", byref(a), byref(b), a.x1, verdict)
    fields = struct.unpack("<5Q3d4i", verdict.raw)
    show("judge", fields[:5])
    show("strain", fields[6:8], True)
    path = c_uint64(), c_uint64()
    checked("judge_path", byref(a), byref(b), byref(path[0]), byref(path[1]))
    show("path", (path[0].value, path[1].value))
point = Surface((c_double * 3)(0, 0, float("nan")), None, 1, (c_int32 * 3)(0, 0, 0), 1)
for wrong in (lambda: checked("find_meetings", byref(point), None, None, None), lambda: detector(b"bhv")):
    try:
        wrong()
        sys.exit("a wrong argument was not refused")
    except RuntimeError as error:
        print("refused", error)

class Mesh(ctypes.Structure):
    _fields_ = [("n", c_size_t), ("x", POINTER(c_double)), ("count", c_size_t), ("triangles", POINTER(c_int32))]


class DressOptions(ctypes.Structure):
    _fields_ = [("edge_length", c_double), ("fabric", ctypes.c_char_p), ("body_friction", c_double), ("up", ctypes.c_char),
                ("fit_origin", ctypes.c_char)]


checked("set_threads", c_int(1))
body, garment = POINTER(Mesh)(), c_void_p()
checked("mesh_read", sys.argv[3].encode(), byref(body))
with open(sys.argv[2], "rb") as opened:
    checked("dress", opened.read(), b"pattern", byref(Surface(body.contents.x, None, body.contents.n, body.contents.triangles,
                                                              body.contents.count)),
            byref(DressOptions(edge_length=0.05, up=b"z")), byref(garment))
for function in ("hash", "verdict"):
    getattr(library, "selvedge_garment_" + function).restype = ctypes.c_char_p
library.selvedge_garment_mesh.restype = POINTER(Mesh)
figures = {}
for figure in ("states_judged", "worn"):
    number = c_double()
    checked("garment_figure", garment, figure.encode(), byref(number))
    figures[figure] = int(number.value)
print("dress", call("garment_hash", garment).decode(), figures["states_judged"], 3 * call("garment_mesh", garment).contents.n,
      "worn" if figures["worn"] else "not worn", call("garment_verdict", garment).decode())

library.selvedge_simulation_steps.restype = ctypes.c_int64
for file in sys.argv[4:]:
    with open(file, "rb") as opened:
        text = opened.read()
    scene, digits, seconds = c_void_p(), ctypes.create_string_buffer(17), []
    checked("scene_create", text, None, byref(scene))
    for _ in range(2):
        started, simulation = time.process_time(), c_void_p()
        checked("simulation_create", scene, None, c_size_t(0), byref(simulation))
        checked("simulation_advance", simulation, c_int(6))
        seconds.append(f"{time.process_time() - started:.3f}")
    name = file.rpartition("/")[2]
    print(name, *seconds, file=sys.stderr)
    checked("simulation_hash", simulation, digits)
    print(f"scene {name} {digits.value.decode()} {call('simulation_steps', simulation)} steps")
