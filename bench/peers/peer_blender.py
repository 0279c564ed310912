# SPDX-License-Identifier: MIT
"""Runs in Blender: peer_blender.py -- FOLDER simulates sheet.obj on the bodies of case.json, writes FOLDER/blender/*.obj."""
import json
import sys
import time
from pathlib import Path

import bpy

GAP = 0.005  # m
FPS = 60
# A frame of Blender's cloth lasts sqrt(0.001) s at any frame rate: its gravity has the factor 0.001 and its time unit is a frame.
FRAME_S = 0.001 ** 0.5


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


def add_bodies(folder, case):
    """The bodies, which move along straight lines between their keys."""
    bodies = []
    for k, part in enumerate(case["parts"]):
        body = add("body_%d" % k, *read_obj(folder / ("part_%d.obj" % k)))
        body.modifiers.new("collision", "COLLISION")
        body.collision.thickness_outer = GAP
        if case["friction"] == 0.0:
            body.collision.cloth_friction = 0.0
        for key in part["motion"].get("blender", []):
            body.location = key[1:]
            body.keyframe_insert("location", frame=1 + FPS * key[0])
        if part["motion"]:
            for curve in body.animation_data.action.fcurves:
                for key in curve.keyframe_points:
                    key.interpolation = "LINEAR"
        bodies.append(body)
    return bodies


def hold(sheet, case):
    """Pins the held vertices, until the time of release if there is one. Before the cloth modifier is added."""
    group = sheet.vertex_groups.new(name="held")
    group.add(case["held_vertices"], 1.0, "REPLACE")
    if "release_s" not in case:
        return
    mix = sheet.modifiers.new("release", "VERTEX_WEIGHT_MIX")
    mix.vertex_group_a, mix.mix_set, mix.mix_mode, mix.default_weight_b = "held", "A", "SET", 0.0
    last = 1 + round(FPS * case["release_s"])
    for frame, value in ((1, 0.0), (last, 0.0), (last + 1, 1.0)):
        mix.mask_constant = value
        mix.keyframe_insert("mask_constant", frame=frame)
    for key in sheet.animation_data.action.fcurves[0].keyframe_points:
        key.interpolation = "CONSTANT"


def main():
    folder = Path(sys.argv[sys.argv.index("--") + 1])
    case = json.loads((folder / "case.json").read_text(encoding="utf-8"))
    out = folder / "blender"
    out.mkdir(exist_ok=True)
    for old in out.glob("*.obj"):
        old.unlink()
    scene = bpy.context.scene
    scene.render.fps = FPS
    scene.gravity = case["gravity"]
    scene.frame_start, scene.frame_end = 1, case["frames"] + 1
    points, faces = read_obj(folder / "sheet.obj")
    bodies = add_bodies(folder, case)
    sheet = add("sheet", points, faces)
    if case["held_vertices"]:
        hold(sheet, case)
    cloth = sheet.modifiers.new("cloth", "CLOTH")
    if case["held_vertices"]:
        cloth.settings.vertex_group_mass = "held"
    # kg a vertex, the same for all: a load is spread over the sheet.
    cloth.settings.mass = (case["mass_kg"] + case.get("load_kg", 0.0)) / len(points)
    cloth.settings.time_scale = 1 / FPS / FRAME_S
    cloth.settings.air_damping = 0.0  # no air in the other programs; at the default, light cloth hovers
    cloth.collision_settings.use_self_collision = True
    # The default distances, 15 to 20 mm, suit objects of metres; here a cell has 20 mm.
    cloth.collision_settings.distance_min = GAP
    cloth.collision_settings.self_distance_min = GAP
    cloth.point_cache.frame_start, cloth.point_cache.frame_end = scene.frame_start, scene.frame_end
    settings = {
        "quality": cloth.settings.quality,
        "collision_quality": cloth.collision_settings.collision_quality,
        "distance_m": cloth.collision_settings.distance_min,
        "self_distance_m": cloth.collision_settings.self_distance_min,
        "body_thickness_outer_m": bodies[0].collision.thickness_outer,
        "cloth_friction": bodies[0].collision.cloth_friction,
        "air_damping": cloth.settings.air_damping,
        "time_scale": cloth.settings.time_scale,
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
