# SPDX-License-Identifier: MIT
"""Runs in Blender: peer_blender.py -- FOLDER simulates sheet.obj on body.obj and writes FOLDER/blender/*.obj."""
import json
import sys
import time
from pathlib import Path

import bpy

GAP = 0.005  # m


def read_obj(file):
    points, faces = [], []
    for line in file.read_text(encoding="ascii").splitlines():
        words = line.split()
        if words[0] == "v":
            points.append(tuple(float(w) for w in words[1:]))
        elif words[0] == "f":
            faces.append([int(w) - 1 for w in words[1:]])
    return points, faces


def add(name, points, faces):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def write_obj(file, points, faces):
    with open(file, "w", encoding="ascii") as out:
        for p in points:
            out.write("v %.9g %.9g %.9g\n" % tuple(p))
        for f in faces:
            out.write("f %d %d %d\n" % tuple(i + 1 for i in f))


def main():
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    out = folder / "blender"
    out.mkdir(exist_ok=True)
    for old in out.glob("*.obj"):
        old.unlink()
    scene = bpy.context.scene
    scene.render.fps = 60
    scene.frame_start, scene.frame_end = 1, case["frames"] + 1
    points, faces = read_obj(folder / "sheet.obj")
    body = add("body", *read_obj(folder / "body.obj"))
    body.modifiers.new("collision", "COLLISION")
    sheet = add("sheet", points, faces)
    cloth = sheet.modifiers.new("cloth", "CLOTH")
    cloth.settings.mass = case["density"] * case["size"] ** 2 / len(points)  # kg a vertex
    cloth.settings.air_damping = 0.0  # no air in the other programs; at the default, light cloth hovers
    cloth.collision_settings.use_self_collision = True
    # The default distances, 15 to 20 mm, suit objects of metres; here a cell has 20 mm.
    cloth.collision_settings.distance_min = GAP
    cloth.collision_settings.self_distance_min = GAP
    body.collision.thickness_outer = GAP
    cloth.point_cache.frame_start, cloth.point_cache.frame_end = scene.frame_start, scene.frame_end
    settings = {
        "quality": cloth.settings.quality,
        "collision_quality": cloth.collision_settings.collision_quality,
        "distance_m": cloth.collision_settings.distance_min,
        "self_distance_m": cloth.collision_settings.self_distance_min,
        "body_thickness_outer_m": body.collision.thickness_outer,
        "cloth_friction": body.collision.cloth_friction,
        "air_damping": cloth.settings.air_damping,
        "tension_stiffness": cloth.settings.tension_stiffness,
    }
    seconds = 0.0
    for frame in range(scene.frame_start, scene.frame_end + 1):
        start = time.process_time()
        scene.frame_set(frame)
        shown = sheet.evaluated_get(bpy.context.evaluated_depsgraph_get())
        seconds += time.process_time() - start
        moved = [shown.matrix_world @ v.co for v in shown.data.vertices]
        write_obj(out / ("frame_%04d.obj" % (frame - 1)), moved, faces)
    report = {"program": "Blender " + bpy.app.version_string, "seconds": seconds, "settings": settings}
    (out / "report.json").write_text(json.dumps(report) + "\n", encoding="utf-8")


main()
