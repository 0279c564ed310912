# SPDX-License-Identifier: MIT
"""Runs in Blender: compares what it imports from a result folder with the PLY frames. See check.sh."""
import struct
import sys
from pathlib import Path

import bpy
import numpy

if not hasattr(numpy, "bool"):  # the glTF importer of Blender 3.4 needs it, but NumPy 1.24 of Debian has it no more
    numpy.bool = bool

TOLERANCE = 1e-6  # m


def read_positions(file):
    """The vertices of a binary little-endian PLY file of selvedge."""
    data = file.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    sizes = {"double": 8, "uchar": 1}
    count, stride, place = 0, 0, []
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[0] == "element":
            break
        elif words[0] == "property":
            if words[2] in ("x", "y", "z"):
                place.append(stride)
            stride += sizes[words[1]]
    return [[struct.unpack_from("<d", body, i * stride + p)[0] for p in place] for i in range(count)]


def positions(name):
    """The vertices of an object as they are drawn now, in world space."""
    evaluated = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
    matrix = evaluated.matrix_world
    return [matrix @ vertex.co for vertex in evaluated.to_mesh().vertices]


def largest_distance(found, wanted):
    if len(found) != len(wanted):
        sys.exit(f"{len(found)} vertices, but the frame has {len(wanted)}")
    return max(max(abs(a - b) for a, b in zip(x, y)) for x, y in zip(found, wanted))


def compare(what, name, frames, times, step):
    worst = 0.0
    for i in range(0, len(frames), step):
        bpy.context.scene.frame_set(int(times[i]), subframe=times[i] - int(times[i]))
        worst = max(worst, largest_distance(positions(name), frames[i]))
    print(f"{what}: {len(frames)} frames, largest distance {worst:.3g} m")
    if not worst <= TOLERANCE:
        sys.exit(f"{what}: vertices differ by more than {TOLERANCE} m")


def main():
    result = Path(sys.argv[sys.argv.index("--") + 1])
    files = sorted((result / "frames").glob("cloth_*.ply"))
    frames = [read_positions(file) for file in files]
    body = read_positions(result / "frames" / "bodies_00000.ply")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 60
    bpy.ops.import_scene.gltf(filepath=str(result / "result.glb"))
    start = min(f.co[0] for a in bpy.data.actions for c in a.fcurves for f in c.keyframe_points)
    compare("glTF", "cloth", frames, [start + i for i in range(len(frames))], 1)
    worst = largest_distance(positions("bodies"), body)
    print(f"glTF, bodies: largest distance {worst:.3g} m")
    if not worst <= TOLERANCE:
        sys.exit("the bodies differ")

    for cache, modifier_format in (("cloth.pc2", "PC2"), ("cloth.mdd", "MDD")):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.import_mesh.ply(filepath=str(result / "cloth_base.ply"))
        cloth = bpy.context.object
        modifier = cloth.modifiers.new("cache", "MESH_CACHE")
        modifier.cache_format = modifier_format
        modifier.filepath = str(result / cache)
        modifier.frame_start = 1.0
        modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
        compare(modifier_format, cloth.name, frames, [1 + i for i in range(len(frames))], 5)

    if not bpy.app.build_options.usd:
        print("USD: this Blender is built without USD, as Debian's is; tests/run/exchange_test.cpp reads result.usda")


main()
