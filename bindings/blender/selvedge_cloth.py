# SPDX-License-Identifier: MIT
"""Blender add-on: bakes cloth with the installed program `selvedge`. For Blender 3.4 and later; see docs/python.md."""

bl_info = {
    "name": "selvedge cloth",
    "author": "the authors of selvedge",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > selvedge",
    "description": "Cloth that never passes through anything, simulated by the program selvedge",
    "category": "Physics",
}

import json
import os
import shutil
import signal
import struct
import subprocess
import tempfile
from pathlib import Path

import bpy
import numpy as np

MODIFIER = "selvedge cache"
FLAGGED = "selvedge flagged"

# Measured fabrics of the program (`selvedge fabric --list`) and its default material.
FABRICS = [
    ("default", "Default", "The default material of selvedge: 200 g/m2, soft"),
    ("petrak_2025/M1", "Petrak M1", "Measured fabric M1 of Petrak 2025"),
    ("petrak_2025/M2", "Petrak M2", "Measured fabric M2 of Petrak 2025"),
    ("petrak_2025/M3", "Petrak M3", "Measured fabric M3 of Petrak 2025"),
    ("petrak_2025/M4", "Petrak M4", "Measured fabric M4 of Petrak 2025"),
    ("petrak_2025/M5", "Petrak M5", "Measured fabric M5 of Petrak 2025"),
    ("petrak_2025/M6", "Petrak M6", "Measured fabric M6 of Petrak 2025"),
]


class BakeError(Exception):
    """A sentence for the user."""


# -- meshes and files --------------------------------------------------------------------------------------------------


def world_points(obj, mesh, scale):
    """The vertices in metres, (n,3)."""
    points = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", points)
    matrix = np.array(obj.matrix_world)
    return scale * (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])


def triangles_of(mesh):
    """Vertex indices, (k,3)."""
    mesh.calc_loop_triangles()
    indices = np.empty(3 * len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("vertices", indices)
    return indices.reshape(-1, 3)


def faces_of(mesh):
    """Where the corners of each face start, and their vertices: what stays when a mesh is bent. Blender may divide a face
    with more than three corners along other diagonals then."""
    starts = np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.polygons.foreach_get("loop_start", starts)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    return starts, corners


def write_ply(file, points, triangles):
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.empty(len(triangles), dtype=np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    faces["n"] = 3
    faces["v"] = triangles
    Path(file).write_bytes(head.encode() + points.astype("<f8").tobytes() + faces.tobytes())


def read_frame(file):
    """Points (n,3) in metres and flags (n,) of a frame of selvedge."""
    head, body = Path(file).read_bytes().split(b"end_header\n", 1)
    fields, count = [], 0
    for line in head.decode().splitlines():
        words = line.split()
        if words[:2] == ["element", "vertex"]:
            count = int(words[2])
        elif words[0] == "element":
            break
        elif words[0] == "property":
            fields.append((words[2], {"double": "<f8", "uchar": "u1"}[words[1]]))
    table = np.frombuffer(body, dtype=np.dtype(fields), count=count)
    points = np.stack([table["x"], table["y"], table["z"]], axis=1)
    flags = table["flag"] if "flag" in table.dtype.names else np.zeros(count, dtype=np.uint8)
    return points, flags


def write_pc2(file, frames, first_frame):
    """A point cache; `frames` yields points in the space of the object."""
    with open(file, "wb") as out:
        out.write(b"\0" * 32)
        samples, points = 0, 0
        for frame in frames:
            out.write(frame.astype("<f4").tobytes())
            samples, points = samples + 1, len(frame)
        out.seek(0)
        out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, points, float(first_frame), 1.0, samples))


# -- the scene of selvedge ---------------------------------------------------------------------------------------------


def colliders(scene, cloth):
    return [o for o in scene.objects if o.type == "MESH" and o is not cloth and o.selvedge_collider]


def held_vertices(cloth, group_name):
    group = cloth.vertex_groups.get(group_name) if group_name else None
    if group is None:
        return []
    held = []
    for vertex in cloth.data.vertices:
        if any(g.group == group.index and g.weight >= 0.5 for g in vertex.groups):
            held.append(vertex.index)
    return held


def export_colliders(context, folder, cloth, scale, fps):
    """The obstacles of the scene: a mesh where nothing moves, else one mesh per frame."""
    scene = context.scene
    bodies = colliders(scene, cloth)
    if not bodies:
        return []
    moving = {body: [] for body in bodies}
    first, faces = {}, {}  # of the first frame: points and triangles, which stay; and faces
    for number, frame in enumerate(range(scene.frame_start, scene.frame_end + 1)):
        scene.frame_set(frame)
        graph = context.evaluated_depsgraph_get()
        for index, body in enumerate(bodies):
            evaluated = body.evaluated_get(graph)
            mesh = evaluated.to_mesh()
            points, found = world_points(evaluated, mesh, scale), faces_of(mesh)
            if number == 0:
                first[body], faces[body] = (points, triangles_of(mesh)), found
            evaluated.to_mesh_clear()
            if not all(np.array_equal(now, then) for now, then in zip(found, faces[body])):
                raise BakeError(f"the faces of {body.name} change at frame {frame}; a collider keeps its faces")
            if number == 0 or moving[body] or not np.array_equal(points, first[body][0]):
                for missing in range(len(moving[body]), number):
                    moving[body].append(first[body][0])
                moving[body].append(points)
    scene.frame_set(scene.frame_start)
    obstacles = []
    for index, body in enumerate(bodies):
        triangles, states = first[body][1], moving[body]
        entry = {"name": body.name}
        if all(np.array_equal(x, states[0]) for x in states):
            write_ply(folder / f"body_{index}.ply", states[0], triangles)
            entry["mesh"] = f"body_{index}.ply"
        else:
            for number, points in enumerate(states):
                write_ply(folder / f"body_{index}_{number:05d}.ply", points, triangles)
            entry["sequence"] = {"files": f"body_{index}_#####.ply", "fps": fps}
        obstacles.append(entry)
    return obstacles


def export_scene(context, folder):
    """Writes scene.json and its meshes."""
    scene, settings = context.scene, context.scene.selvedge
    cloth = settings.cloth
    if cloth is None or cloth.type != "MESH":
        raise BakeError("choose a mesh as cloth")
    if scene.frame_end <= scene.frame_start:
        raise BakeError("the scene has one frame; set its end after its start")
    scene.frame_set(scene.frame_start)
    scale = scene.unit_settings.scale_length
    fps = scene.render.fps / scene.render.fps_base
    triangles = triangles_of(cloth.data)
    if len(triangles) == 0:
        raise BakeError(f"{cloth.name} has no faces")
    write_ply(folder / "cloth.ply", world_points(cloth, cloth.data, scale), triangles)
    material = {} if settings.fabric == "default" else {"fabric": settings.fabric}
    gravity = [scale * g for g in scene.gravity] if scene.use_gravity else [0.0, 0.0, 0.0]
    description = {
        "name": "blender",
        "gravity": gravity,
        "materials": {"default": material},
        "geometry": [{"name": "cloth", "mesh": "cloth.ply"}],
        "obstacles": export_colliders(context, folder, cloth, scale, fps),
        "contact": {
            "rest_gap": scale * settings.thickness,
            "start": "untangle" if settings.untangle else "refuse",
        },
        "time": {"fps": fps, "frames": scene.frame_end - scene.frame_start},
    }
    held = held_vertices(cloth, settings.pins)
    if held:
        description["handles"] = [{"name": "pins", "select": held}]
    (folder / "scene.json").write_text(json.dumps(description))
    return cloth


# -- the program -------------------------------------------------------------------------------------------------------


def program_path(context):
    addon = context.preferences.addons.get(__name__)
    chosen = addon.preferences.program if addon else ""
    program = os.environ.get("SELVEDGE_PROGRAM") or bpy.path.abspath(chosen) or shutil.which("selvedge")
    if not program or not shutil.which(program):
        raise BakeError("the program selvedge is not on PATH; install it, or give its path in the add-on's preferences")
    return program


class Bake:
    """One run of the program: export, wait, load."""

    def __init__(self, context):
        self.folder = Path(tempfile.mkdtemp(prefix="selvedge_"))
        self.process = None
        try:
            self.cloth = export_scene(context, self.folder)
            self.frames = context.scene.frame_end - context.scene.frame_start
            command = [program_path(context), "run", "scene.json", "--no-picture", "--out", "result"]
            self.errors = open(self.folder / "errors.txt", "wb")
            self.process = subprocess.Popen(
                command, cwd=self.folder, stdout=subprocess.DEVNULL, stderr=self.errors, stdin=subprocess.DEVNULL
            )
        except BaseException:
            self.remove()
            raise

    def frame_files(self):
        return sorted((self.folder / "result" / "frames").glob("cloth_*.ply"))

    def progress(self):
        return max(0, len(self.frame_files()) - 1) / self.frames

    def cancel(self):
        """Ends the run after its current frame; the frames so far remain."""
        self.process.send_signal(signal.SIGINT)

    def message(self):
        text = (self.folder / "errors.txt").read_text(errors="replace").strip()
        return text.splitlines()[-1].removeprefix("selvedge: ") if text else "the program ended without a message"

    def load(self, context):
        """Attaches the cache. Returns the number of frames."""
        files = self.frame_files()
        if not files:
            raise BakeError(self.message())
        cache = Path(context.scene.selvedge.cache_folder and bpy.path.abspath(context.scene.selvedge.cache_folder)
                     or bpy.app.tempdir)
        cache.mkdir(parents=True, exist_ok=True)
        target = cache / (bpy.path.clean_name(self.cloth.name) + ".pc2")
        inverse = np.array(self.cloth.matrix_world.inverted())
        scale = context.scene.unit_settings.scale_length
        flagged = np.zeros(len(self.cloth.data.vertices), dtype=np.uint8)

        def local_frames():
            for file in files:
                points, flags = read_frame(file)
                np.bitwise_or(flagged, flags, out=flagged)
                yield (points / scale) @ inverse[:3, :3].T + inverse[:3, 3]

        write_pc2(target, local_frames(), context.scene.frame_start)
        self.attach(target, context.scene.frame_start)
        self.mark(flagged)
        return len(files)

    def attach(self, target, start):
        modifier = self.cloth.modifiers.get(MODIFIER) or self.cloth.modifiers.new(MODIFIER, "MESH_CACHE")
        modifier.cache_format = "PC2"
        modifier.filepath = str(target)
        modifier.frame_start = float(start)
        modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
        # Modifiers such as subdivision follow the cache. Blender before 3.5 moves modifiers by an operator only.
        index = self.cloth.modifiers.find(MODIFIER)
        if index > 0 and hasattr(self.cloth.modifiers, "move"):
            self.cloth.modifiers.move(index, 0)
        elif index > 0:
            with bpy.context.temp_override(object=self.cloth, active_object=self.cloth):
                bpy.ops.object.modifier_move_to_index(modifier=MODIFIER, index=0)

    def mark(self, flagged):
        old = self.cloth.vertex_groups.get(FLAGGED)
        if old is not None:
            self.cloth.vertex_groups.remove(old)
        if flagged.any():
            group = self.cloth.vertex_groups.new(name=FLAGGED)
            group.add(np.nonzero(flagged)[0].tolist(), 1.0, "REPLACE")

    def remove(self):
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        if getattr(self, "errors", None) is not None:
            self.errors.close()
        shutil.rmtree(self.folder, ignore_errors=True)


class SELVEDGE_OT_bake(bpy.types.Operator):
    """Simulate the cloth and attach the result to it as a mesh cache. Escape ends the simulation early"""

    bl_idname = "selvedge.bake"
    bl_label = "Bake"

    def start(self, context):
        try:
            self.bake = Bake(context)
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return False
        return True

    def end(self, context):
        code = self.bake.process.wait()
        try:
            frames = self.bake.load(context)
            context.scene.selvedge.status = f"{frames} frames"
            if code != 0:
                context.scene.selvedge.status += "; stopped: " + self.bake.message()
                self.report({"WARNING"}, self.bake.message())
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            self.bake.remove()
        return {"FINISHED"}

    def execute(self, context):
        """Without a window: waits for the end."""
        return self.end(context) if self.start(context) else {"CANCELLED"}

    def invoke(self, context, event):
        if not self.start(context):
            return {"CANCELLED"}
        context.window_manager.progress_begin(0, 100)
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.bake.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        context.window_manager.progress_update(100 * self.bake.progress())
        context.scene.selvedge.status = f"{100 * self.bake.progress():.0f} %"
        for area in context.screen.areas:
            area.tag_redraw()
        if self.bake.process.poll() is None:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        return self.end(context)


class SELVEDGE_OT_clear(bpy.types.Operator):
    """Remove the cache and the flagged vertices from the cloth"""

    bl_idname = "selvedge.clear"
    bl_label = "Clear"

    def execute(self, context):
        cloth = context.scene.selvedge.cloth
        if cloth is None:
            return {"CANCELLED"}
        modifier, group = cloth.modifiers.get(MODIFIER), cloth.vertex_groups.get(FLAGGED)
        if modifier is not None:
            cloth.modifiers.remove(modifier)
        if group is not None:
            cloth.vertex_groups.remove(group)
        context.scene.selvedge.status = ""
        return {"FINISHED"}


# -- settings and panel ------------------------------------------------------------------------------------------------


class SelvedgeSettings(bpy.types.PropertyGroup):
    cloth: bpy.props.PointerProperty(name="Cloth", type=bpy.types.Object, poll=lambda _, o: o.type == "MESH")
    pins: bpy.props.StringProperty(name="Pins", description="Vertex group; vertices with weight 0.5 or more are held still")
    fabric: bpy.props.EnumProperty(name="Fabric", items=FABRICS)
    thickness: bpy.props.FloatProperty(
        name="Thickness", default=0.002, min=1e-5, max=0.1, precision=4, unit="LENGTH",
        description="Distance that the cloth keeps from colliders and from itself",
    )
    untangle: bpy.props.BoolProperty(
        name="Untangle start", description="Bring cloth apart that crosses something in the first frame, instead of refusing it"
    )
    cache_folder: bpy.props.StringProperty(
        name="Cache", subtype="DIR_PATH", description="Folder of the point cache; empty: a temporary one, lost when Blender ends"
    )
    status: bpy.props.StringProperty()


class SelvedgePreferences(bpy.types.AddonPreferences):
    bl_idname = __name__
    program: bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH", description="The program selvedge; empty: the one on PATH"
    )

    def draw(self, context):
        self.layout.prop(self, "program")


class SELVEDGE_PT_panel(bpy.types.Panel):
    bl_label = "selvedge"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "selvedge"

    def draw(self, context):
        settings, layout = context.scene.selvedge, self.layout
        layout.prop(settings, "cloth")
        if settings.cloth is not None:
            layout.prop_search(settings, "pins", settings.cloth, "vertex_groups")
        for name in ("fabric", "thickness", "untangle", "cache_folder"):
            layout.prop(settings, name)
        if context.object is not None and context.object.type == "MESH" and context.object is not settings.cloth:
            layout.prop(context.object, "selvedge_collider")
        row = layout.row()
        row.operator("selvedge.bake")
        row.operator("selvedge.clear")
        if settings.status:
            layout.label(text=settings.status)


CLASSES = (SelvedgeSettings, SelvedgePreferences, SELVEDGE_OT_bake, SELVEDGE_OT_clear, SELVEDGE_PT_panel)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.selvedge = bpy.props.PointerProperty(type=SelvedgeSettings)
    bpy.types.Object.selvedge_collider = bpy.props.BoolProperty(
        name="Collider", description="Cloth of selvedge collides with this object"
    )


def unregister():
    del bpy.types.Object.selvedge_collider
    del bpy.types.Scene.selvedge
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
