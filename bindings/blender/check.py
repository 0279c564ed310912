# SPDX-License-Identifier: MIT
"""Runs in Blender: compares what it imports from a result folder with the PLY frames. See check.sh."""
import struct
import sys
from pathlib import Path

import bpy
import numpy

if not hasattr(numpy, "bool"):  # the glTF importer of Blender 3.4 needs it, but NumPy 1.24 of Debian has it no more
    numpy.bool = bool

TOLERANCE = 1e-7  # m


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


def compare(what, name, frames, times, step, tolerance=TOLERANCE):
    worst = 0.0
    for i in range(0, len(frames), step):
        bpy.context.scene.frame_set(int(times[i]), subframe=times[i] - int(times[i]))
        worst = max(worst, largest_distance(positions(name), frames[i]))
    print(f"{what}: {len(frames)} frames, largest distance {worst:.3g} m")
    if not worst <= tolerance:
        sys.exit(f"{what}: vertices differ by more than {tolerance} m")


def compare_corners(name, rest):
    """Texture coordinates and normals of a flat piece, which Blender has by corner."""
    mesh = bpy.data.objects[name].data
    mesh.calc_normals_split()
    uv = numpy.empty(2 * len(mesh.loops))
    mesh.uv_layers.active.data.foreach_get("uv", uv)
    corners = numpy.empty(len(mesh.loops), dtype=numpy.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    flat = numpy.array(rest)[:, :2]
    wanted = (flat - flat.min(0)) / numpy.ptp(flat, axis=0).max()
    worst = abs(uv.reshape(-1, 2) - wanted[corners]).max()
    turned = max(abs(abs(loop.normal.z) - 1.0) for loop in mesh.loops)
    colour = bpy.data.objects[name].active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value
    print(f"glTF, {name}: texture coordinates to {worst:.2g}, normals to {turned:.2g}, colour {[round(c, 3) for c in colour[:3]]}")
    if worst > 1e-6 or turned > 1e-3:
        sys.exit(f"{name}: texture coordinates or normals differ")


def main():
    result = Path(sys.argv[sys.argv.index("--") + 1])
    files = sorted((result / "frames").glob("cloth_*.ply"))
    frames = [read_positions(file) for file in files]
    body = read_positions(result / "frames" / "bodies_00000.ply")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = 60
    bpy.ops.import_scene.gltf(filepath=str(result / "result.glb"))
    start = min(f.co[0] for a in bpy.data.actions for c in a.fcurves for f in c.keyframe_points)
    named = sorted(o.name for o in bpy.data.objects if o.type == "MESH")
    if named != ["ball", "lower", "upper"]:
        sys.exit(f"the objects are {named}")
    half = len(frames[0]) // 2
    for name, part in (("lower", slice(0, half)), ("upper", slice(half, None))):
        compare(f"glTF, {name}", name, [frame[part] for frame in frames], [start + i for i in range(len(frames))], 1)
        compare_corners(name, frames[0][part])
    compare("glTF, ball", "ball", [body], [start], 1)

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.obj_import(filepath=str(sorted((result / "frames").glob("cloth_*.obj"))[-1]), forward_axis="Y", up_axis="Z")
    for name, part in (("lower", slice(0, half)), ("upper", slice(half, None))):
        compare(f"OBJ, {name}", name, [frames[-1][part]], [1], 1)

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
