# SPDX-License-Identifier: MIT
"""Runs in Blender: bakes with the add-on and checks what comes back. See check.sh addon."""
import importlib.util
import sys
import time
from math import radians
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

ROOT = Path(__file__).resolve().parents[2]
ARGUMENTS = sys.argv[sys.argv.index("--") + 1 :]
WORK = Path(ARGUMENTS[0])
FRAMES = 25
RADIUS = 0.3
THICKNESS = 0.002


def load_addon():
    spec = importlib.util.spec_from_file_location("selvedge_cloth", ROOT / "bindings" / "blender" / "selvedge_cloth.py")
    addon = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(addon)
    addon.register()
    return addon


def say(sentence):
    print("check:", sentence)


def grid_object(name, cells, size):
    """A square of quads of its own, so that faces are split into triangles."""
    points = [(size * (i / cells - 0.5), size * (j / cells - 0.5), 0) for j in range(cells + 1) for i in range(cells + 1)]
    row = cells + 1
    faces = [(j * row + i, j * row + i + 1, (j + 1) * row + i + 1, (j + 1) * row + i) for j in range(cells) for i in range(cells)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    return obj


def drawn(obj, frame):
    """The vertices of an object at a frame, in world space."""
    bpy.context.scene.frame_set(frame)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([evaluated.matrix_world @ v.co for v in evaluated.to_mesh().vertices])


def refused(part):
    try:
        bpy.ops.selvedge.bake()
    except RuntimeError as error:
        assert part in str(error), f"it says: {error}"
        return
    raise AssertionError(f"not refused: {part}")


def make_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.render.fps = 30
    bpy.ops.mesh.primitive_uv_sphere_add(radius=RADIUS, segments=48, ring_count=24)
    ball = bpy.context.object
    ball.selvedge_collider = True
    for frame, x in ((1, 0.0), (FRAMES, 0.2)):
        ball.location = (x, 0, 0)
        ball.keyframe_insert("location", frame=frame)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, -1))
    bpy.context.object.selvedge_collider = True
    cloth = grid_object("sheet", 20, 0.5)
    cloth.scale = (2, 2, 2)  # one metre in the world
    cloth.rotation_euler = (0, 0, radians(30))
    cloth.location = (0, 0, RADIUS + 0.02)
    cloth.selvedge_cloth.enabled = True
    scene.selvedge.thickness = THICKNESS
    scene.selvedge.cache_folder = str(WORK / "cache")
    return scene, cloth, ball


def check_drape(scene, cloth, ball):
    bpy.context.view_layer.update()
    start = np.array([cloth.matrix_world @ v.co for v in cloth.data.vertices])
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert scene.selvedge.status == f"{FRAMES} frames", scene.selvedge.status
    assert np.abs(drawn(cloth, 1) - start).max() < 1e-6, "the first frame is the object as it was"
    end = drawn(cloth, FRAMES)
    assert end[:, 2].min() < start[:, 2].min() - 0.1, "the cloth falls"
    centre = np.array(ball.matrix_world.translation)
    assert abs(centre[0] - 0.2) < 1e-6
    # The ball of the cloth is a mesh inside the sphere; its faces lie up to this much inside.
    inside = RADIUS * np.cos(np.pi / 24)
    nearest = np.linalg.norm(end - centre, axis=1).min()
    assert nearest > inside, f"a vertex is {nearest} m from the centre of the moving ball"
    assert cloth.vertex_groups.get("selvedge flagged") is None, "nothing is flagged in a clean drape"
    say(f"{FRAMES} frames over a moving ball; nearest vertex {nearest - inside:.4f} m outside of the faces")


def check_pins(scene, cloth):
    group = cloth.vertex_groups.new(name="pins")
    group.add([0, 20], 1.0, "REPLACE")
    group.add([5], 0.2, "REPLACE")
    cloth.selvedge_cloth.pins = "pins"
    start = drawn(cloth, 1)
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    moved = np.linalg.norm(drawn(cloth, FRAMES) - start, axis=1)
    assert moved[[0, 20]].max() < 1e-6 and moved[5] > 0.01, moved[[0, 5, 20]]
    cloth.selvedge_cloth.pins = ""
    say("pinned vertices stay, others move")


def check_fabric(scene, cloth):
    cloth.selvedge_cloth.fabric = "petrak_2025/M1"
    before = drawn(cloth, FRAMES)
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert np.abs(drawn(cloth, FRAMES) - before).max() > 1e-3
    cloth.selvedge_cloth.fabric = "default"
    say("another fabric drapes differently")


def check_refusals(scene, cloth, ball):
    height = cloth.location.z
    cloth.location.z = 0.1
    refused("crosses")
    cloth.location.z = height
    cloth.selvedge_cloth.enabled = False
    refused("mark a mesh as cloth")
    cloth.selvedge_cloth.enabled = True
    ball.hide_viewport = True
    refused("Sphere: marked as collider, but hidden")
    ball.hide_viewport = False
    curve = bpy.data.objects.new("rope", bpy.data.curves.new("rope", "CURVE"))
    bpy.context.collection.objects.link(curve)
    curve.selvedge_collider = True
    refused("rope: marked as collider, but no mesh")
    bpy.data.objects.remove(curve)
    say("cloth that starts in the ball, a hidden collider and one that is no mesh are refused by name")


def check_flags(scene, cloth):
    height = cloth.location.z
    cloth.location.z = RADIUS - 0.01
    scene.selvedge.untangle = True
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    group = cloth.vertex_groups.get("selvedge flagged")
    flagged = [v.index for v in cloth.data.vertices if any(g.group == group.index for g in v.groups)]
    assert 0 < len(flagged) < len(cloth.data.vertices), len(flagged)
    cloth.location.z, scene.selvedge.untangle = height, False
    say(f"{len(flagged)} vertices of a cloth that starts in the ball are flagged")


def check_second_modifier(scene, cloth):
    cloth.modifiers.clear()
    cloth.modifiers.new("Subdivision", "SUBSURF")
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert [m.name for m in cloth.modifiers] == ["selvedge cache", "Subdivision"]
    assert len(drawn(cloth, FRAMES)) > 2 * len(cloth.data.vertices), "the subdivision is drawn"
    cloth.modifiers.remove(cloth.modifiers["Subdivision"])
    say("the cache is before a subdivision that the cloth had")


def check_bent_collider(scene, cloth, ball):
    """A post of quads between two faces of many corners, twisted."""
    bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=0.6, vertices=12, location=(0.6, 0, -0.1))
    post = bpy.context.object
    post.selvedge_collider, ball.selvedge_collider = True, False
    bend = post.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "TWIST", "Z"
    for frame, angle in ((1, 0.0), (FRAMES, 1.2)):
        bend.angle = angle
        bend.keyframe_insert("angle", frame=frame)
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert scene.selvedge.status == f"{FRAMES} frames", scene.selvedge.status
    decimate = post.modifiers.new("fewer", "DECIMATE")
    for frame, ratio in ((1, 1.0), (FRAMES, 0.5)):
        decimate.ratio = ratio
        decimate.keyframe_insert("ratio", frame=frame)
    refused("a collider keeps its faces")
    bpy.data.objects.remove(post)
    ball.selvedge_collider = True
    say("a collider whose quads are bent bakes; one whose faces change is refused")


def pinned(cloth, name, vertices):
    cloth.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
    cloth.selvedge_cloth.pins = name


def check_moving_pins(scene, cloth):
    """A hook lifts one corner, a bone another; the parent of the cloth moves and turns all pins."""
    hook = bpy.data.objects.new("hook", None)
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    parent = bpy.data.objects.new("parent", None)
    for obj in (hook, rig, parent):
        bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("lift")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    cloth.vertex_groups.new(name="hooked").add([0], 1.0, "REPLACE")
    cloth.vertex_groups.new(name="lift").add([20], 1.0, "REPLACE")
    modifier = cloth.modifiers.new("hook", "HOOK")
    modifier.object, modifier.vertex_group = hook, "hooked"
    cloth.modifiers.new("bones", "ARMATURE").object = rig
    pinned(cloth, "corners", [0, 20, 420, 440])
    for frame, share in ((1, 0.0), (FRAMES, 1.0)):
        hook.location = (0, 0, 0.1 * share)
        hook.keyframe_insert("location", frame=frame)
        parent.location, parent.rotation_euler = (0.1 * share, 0, 0.05 * share), (0, 0, 0.3 * share)
        parent.keyframe_insert("location", frame=frame)
        parent.keyframe_insert("rotation_euler", frame=frame)
        rig.pose.bones["lift"].location = (0, 0.1 * share, 0)
        rig.pose.bones["lift"].keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    cloth.parent = parent
    if cloth.modifiers.get("selvedge cache"):
        cloth.modifiers.remove(cloth.modifiers["selvedge cache"])
    wanted = {frame: drawn(cloth, frame)[[0, 20, 420, 440]] for frame in (1, 9, FRAMES)}
    assert np.abs(wanted[FRAMES] - wanted[1]).max() > 0.1, "the pins move"
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert [m.name for m in cloth.modifiers] == ["hook", "bones", "selvedge cache"]
    for frame, x in wanted.items():
        off = np.abs(drawn(cloth, frame)[[0, 20, 420, 440]] - x).max()
        assert off < 2e-6, f"a pin is {off} m off at frame {frame}"
    cloth.parent = None
    for name in ("hook", "bones"):
        cloth.modifiers.remove(cloth.modifiers[name])
    cloth.selvedge_cloth.pins = ""
    say("pins follow a hook, a bone and the parent of the cloth to 2e-6 m")


def check_several_cloths(scene, cloth):
    """Two cloths, one over the other, of two fabrics; the sewing edges of a third close."""
    upper = grid_object("upper", 12, 0.4)
    upper.location = (0, 0, RADIUS + 0.06)
    upper.selvedge_cloth.enabled, upper.selvedge_cloth.fabric = True, "petrak_2025/M2"
    flaps = grid_object("flaps", 4, 0.1)
    points = [tuple(v.co) for v in flaps.data.vertices]
    faces = [tuple(p.vertices) for p in flaps.data.polygons]
    n = len(points)
    both = points + [(x, y, z + 0.03) for x, y, z in points]
    edges = [(k, k + n) for k in range(5)]
    mesh = bpy.data.meshes.new("flaps")
    mesh.from_pydata(both, edges, faces + [tuple(v + n for v in f) for f in faces])
    flaps.data, flaps.location = mesh, (0.8, 0, 0.5)
    flaps.selvedge_cloth.enabled = True
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert scene.selvedge.status == f"{FRAMES} frames", scene.selvedge.status
    top, below = drawn(upper, FRAMES), drawn(cloth, FRAMES)
    assert top[:, 2].max() > below[:, 2].max() and np.abs(top[:, 2].min() - drawn(upper, 1)[:, 2].min()) > 0.01
    x = drawn(flaps, FRAMES)
    opening = np.linalg.norm(x[:5] - x[n : n + 5], axis=1)
    assert opening.max() < 0.01, opening
    for obj in (upper, flaps):
        bpy.data.objects.remove(obj)
    say(f"two cloths of two fabrics, and sewing edges that close to {1000 * opening.max():.1f} mm")


def check_cancel(scene, cloth):
    bake = addon.Bake(bpy.context)
    while bake.progress() == 0.0 and bake.process.poll() is None:
        time.sleep(0.02)
    assert 0.0 < bake.progress() <= 1.0
    bake.cancel()
    bake.process.wait()
    frames = bake.load(bpy.context)
    bake.remove()
    assert 1 < frames <= FRAMES and not bake.folder.exists()
    assert not bpy.ops.selvedge.cancel.poll(), "nothing runs"
    say(f"a cancelled bake keeps its {frames} frames")


def check_saved_file(scene, cloth):
    """The cache lies beside the file, by relative path: it survives saving, moving and opening both."""
    scene.selvedge.cache_folder = ""
    first, second = WORK / "one", WORK / "two"
    first.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(first / "drape.blend"))
    assert bpy.ops.selvedge.bake() == {"FINISHED"}
    assert cloth.modifiers["selvedge cache"].filepath == "//selvedge_cache/sheet.pc2"
    assert (first / "selvedge_cache" / "sheet.pc2").is_file()
    end, name = drawn(cloth, FRAMES), cloth.name
    bpy.ops.wm.save_mainfile()
    first.rename(second)
    bpy.ops.wm.open_mainfile(filepath=str(second / "drape.blend"))
    again = bpy.data.objects[name]
    assert again.selvedge_cloth.enabled
    assert np.array_equal(drawn(again, FRAMES), end), "the reopened file shows the same cloth"
    say("a saved file finds its cache after it was moved and opened again")
    return bpy.context.scene, again


def draw(scene, cloth, picture):
    cloth.data.materials.append(bpy.data.materials.new("dye"))
    cloth.data.materials[0].diffuse_color = (0.6, 0.12, 0.1, 1)
    for polygon in cloth.data.polygons:
        polygon.use_smooth = True
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location = (1.6, -2.0, 1.1)
    camera.rotation_euler = (Vector((0.1, 0, 0)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    light = bpy.data.objects.new("light", bpy.data.lights.new("light", "SUN"))
    light.rotation_euler = (radians(40), radians(20), 0)
    light.data.energy = 3
    for obj in (camera, light):
        bpy.context.collection.objects.link(obj)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 16, False
    scene.render.resolution_x, scene.render.resolution_y = 480, 360
    scene.frame_set(FRAMES)
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)
    say(f"rendered {picture}")


addon = load_addon()
scene, cloth, ball = make_scene()
check_drape(scene, cloth, ball)
if len(ARGUMENTS) > 1:
    draw(scene, cloth, ARGUMENTS[1])
check_pins(scene, cloth)
check_fabric(scene, cloth)
check_refusals(scene, cloth, ball)
check_flags(scene, cloth)
check_bent_collider(scene, cloth, ball)
check_second_modifier(scene, cloth)
check_several_cloths(scene, cloth)
check_moving_pins(scene, cloth)
check_cancel(scene, cloth)
scene, cloth = check_saved_file(scene, cloth)
assert bpy.ops.selvedge.clear() == {"FINISHED"}
assert "selvedge cache" not in cloth.modifiers
addon.unregister()
(WORK / "passed").touch()
say("passed")
