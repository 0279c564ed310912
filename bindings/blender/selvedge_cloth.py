# SPDX-License-Identifier: MIT
"""Blender add-on: bakes cloth with the installed program `selvedge`. For Blender 3.4 and later; see docs/python.md."""

bl_info = {
    "name": "selvedge cloth",
    "author": "the authors of selvedge",
    "version": (1, 1, 0),
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

# Modifiers that move vertices and keep their number. Pins follow those before the cache.
DEFORMING = {
    "ARMATURE", "CAST", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM", "LATTICE", "MESH_DEFORM",
    "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "LAPLACIANSMOOTH", "SURFACE_DEFORM", "WARP", "WAVE",
}


def cloths(scene):
    return [o for o in scene.objects if o.type == "MESH" and o.selvedge_cloth.enabled]


def colliders(scene, sheets):
    """The marked objects. Refuses those that cannot take part, by name."""
    marked = [o for o in scene.objects if o.selvedge_collider and o not in sheets]
    shapeless = [o.name for o in marked if o.type != "MESH"]
    if shapeless:
        raise BakeError(
            f"{', '.join(shapeless)}: marked as collider, but no mesh; convert it (Object > Convert > Mesh) or clear the mark"
        )
    hidden = [o.name for o in marked if o.hide_viewport or o.hide_get()]
    if hidden:
        raise BakeError(f"{', '.join(hidden)}: marked as collider, but hidden; show it or clear the mark")
    return marked


def held_vertices(cloth, group_name):
    group = cloth.vertex_groups.get(group_name) if group_name else None
    if group is None:
        return []
    held = []
    for vertex in cloth.data.vertices:
        if any(g.group == group.index and g.weight >= 0.5 for g in vertex.groups):
            held.append(vertex.index)
    return held


def sewing_seams(name, mesh):
    """Edges without a face pull their two vertices together, as in Blender's own cloth."""
    of_faces = set()
    for polygon in mesh.polygons:
        of_faces.update(tuple(sorted(key)) for key in polygon.edge_keys)
    loose = [tuple(e.vertices) for e in mesh.edges if tuple(sorted(e.vertices)) not in of_faces]
    seams = []  # the sides of each name a vertex once
    for first, second in loose:
        for sides in seams:
            if first not in sides[0] and second not in sides[1] and first not in sides[1] and second not in sides[0]:
                break
        else:
            sides = ([], [])
            seams.append(sides)
        sides[0].append(first)
        sides[1].append(second)
    return [
        {"sides": [{"geometry": name, "select": one}, {"geometry": name, "select": other}], "pull": 0.5, "acceleration": 5}
        for one, other in seams
    ]


def other_modifiers(cloth):
    """The cache, and modifiers that change the number of vertices."""
    return [m for m in cloth.modifiers if m.name == MODIFIER or m.type not in DEFORMING]


class Motion:
    """All frames of the Blender scene: colliders, and cloth as its parents, hooks and armatures move it."""

    def __init__(self, context, sheets, bodies, scale):
        self.scene, self.sheets, self.bodies, self.scale = context.scene, sheets, bodies, scale
        self.states = {o: [] for o in [*sheets, *bodies]}  # points of each frame; one array where they rest
        self.faces, self.triangles = {}, {}
        self.matrices = {o: [] for o in sheets}
        hidden = [(m, m.show_viewport) for o in sheets for m in other_modifiers(o)]
        try:
            for modifier, _ in hidden:
                modifier.show_viewport = False
            for number, frame in enumerate(range(self.scene.frame_start, self.scene.frame_end + 1)):
                self.scene.frame_set(frame)
                graph = context.evaluated_depsgraph_get()
                for obj in self.states:
                    self.read(obj, number, frame, graph)
        finally:
            for modifier, shown in hidden:
                modifier.show_viewport = shown
            self.scene.frame_set(self.scene.frame_start)

    def read(self, obj, number, frame, graph):
        evaluated = obj.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        points, found = world_points(evaluated, mesh, self.scale), faces_of(mesh)
        if number == 0:
            self.triangles[obj], self.faces[obj] = triangles_of(mesh), found
        evaluated.to_mesh_clear()
        if not all(np.array_equal(now, then) for now, then in zip(found, self.faces[obj])):
            kind = "a collider" if obj in self.bodies else "cloth"
            raise BakeError(f"the faces of {obj.name} change at frame {frame}; {kind} keeps its faces")
        states = self.states[obj]
        states.append(states[-1] if states and np.array_equal(points, states[-1]) else points)
        if obj in self.matrices:
            self.matrices[obj].append(np.array(evaluated.matrix_world))

    def rests(self, obj):
        return all(x is self.states[obj][0] for x in self.states[obj])


def export_colliders(motion, folder, fps):
    """The obstacles of the scene: a mesh where nothing moves, else one mesh per frame."""
    obstacles = []
    for index, body in enumerate(motion.bodies):
        triangles, states = motion.triangles[body], motion.states[body]
        entry = {"name": body.name}
        if motion.rests(body):
            write_ply(folder / f"body_{index}.ply", states[0], triangles)
            entry["mesh"] = f"body_{index}.ply"
        else:
            for number, points in enumerate(states):
                write_ply(folder / f"body_{index}_{number:05d}.ply", points, triangles)
            entry["sequence"] = {"files": f"body_{index}_#####.ply", "fps": fps}
        obstacles.append(entry)
    return obstacles


def pin_handles(motion, cloth, name, fps):
    """Handles of the pinned vertices: one for all that move alike."""
    held = held_vertices(cloth, cloth.selvedge_cloth.pins)
    if not held:
        return []
    paths = np.array([points[held] for points in motion.states[cloth]])  # frames, pins, 3
    paths -= paths[:1].copy()
    alike = {}
    for k, vertex in enumerate(held):
        alike.setdefault(paths[:, k].tobytes(), (paths[:, k], []))[1].append(vertex)
    handles = []
    for path, vertices in alike.values():
        handle = {"geometry": name, "select": vertices}
        if path.any():
            handle["motion"] = [{"time": k / fps, "translation": x.tolist()} for k, x in enumerate(path)]
        handles.append(handle)
    return handles


def export_scene(context, folder):
    """Writes scene.json and its meshes. Returns the motion of the Blender scene."""
    scene, settings = context.scene, context.scene.selvedge
    sheets = cloths(scene)
    if not sheets:
        raise BakeError("mark a mesh as cloth")
    if scene.frame_end <= scene.frame_start:
        raise BakeError("the scene has one frame; set its end after its start")
    for cloth in sheets:
        if len(cloth.data.polygons) == 0:
            raise BakeError(f"{cloth.name} has no faces")
    scale = scene.unit_settings.scale_length
    fps = scene.render.fps / scene.render.fps_base
    motion = Motion(context, sheets, colliders(scene, sheets), scale)
    gravity = [scale * g for g in scene.gravity] if scene.use_gravity else [0.0, 0.0, 0.0]
    description = {
        "name": "blender",
        "gravity": gravity,
        "materials": {},
        "geometry": [],
        "handles": [],
        "seams": [],
        "obstacles": export_colliders(motion, folder, fps),
        "contact": {
            "rest_gap": scale * settings.thickness,
            "start": "untangle" if settings.untangle else "refuse",
        },
        "time": {"fps": fps, "frames": scene.frame_end - scene.frame_start},
    }
    for index, cloth in enumerate(sheets):
        name, fabric = f"cloth_{index}", cloth.selvedge_cloth.fabric
        points = motion.states[cloth][0]
        if len(points) != len(cloth.data.vertices):
            raise BakeError(f"{cloth.name}: a modifier before the cache changes the number of its vertices; apply it")
        write_ply(folder / f"{name}.ply", points, motion.triangles[cloth])
        description["materials"][name] = {} if fabric == "default" else {"fabric": fabric}
        description["geometry"].append({"name": name, "mesh": f"{name}.ply", "material": name})
        description["handles"] += pin_handles(motion, cloth, name, fps)
        description["seams"] += sewing_seams(name, cloth.data)
    (folder / "scene.json").write_text(json.dumps(description))
    return motion


# -- the program -------------------------------------------------------------------------------------------------------


def program_path(context):
    addon = context.preferences.addons.get(__name__)
    chosen = addon.preferences.program if addon else ""
    program = os.environ.get("SELVEDGE_PROGRAM") or bpy.path.abspath(chosen) or shutil.which("selvedge")
    if not program or not shutil.which(program):
        raise BakeError("the program selvedge is not on PATH; install it, or give its path in the add-on's preferences")
    return program


def cache_folder(context):
    """Where caches go: the chosen folder; beside the saved file; else one that is lost when Blender ends."""
    chosen = context.scene.selvedge.cache_folder
    if chosen:
        return Path(bpy.path.abspath(chosen))
    return Path(bpy.path.abspath("//selvedge_cache")) if bpy.data.filepath else Path(bpy.app.tempdir)


def stored_path(file):
    """By its place beside the .blend file, so that both can move together; absolute where there is none."""
    if not bpy.data.filepath:
        return str(file)
    try:
        return bpy.path.relpath(str(file))
    except ValueError:  # on another drive
        return str(file)


class Bake:
    """One run of the program: export, wait, load."""

    def __init__(self, context):
        self.folder = Path(tempfile.mkdtemp(prefix="selvedge_"))
        self.process = None
        try:
            self.motion = export_scene(context, self.folder)
            self.frames = context.scene.frame_end - context.scene.frame_start
            command = [program_path(context), "run", "scene.json", "--no-pictures", "--out", "result"]
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
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)

    def message(self):
        text = (self.folder / "errors.txt").read_text(errors="replace").strip()
        text = text.splitlines()[-1].removeprefix("selvedge: ") if text else "the program ended without a message"
        for index, cloth in enumerate(self.motion.sheets):
            text = text.replace(f'"cloth_{index}"', f'"{cloth.name}"')
        return text

    def load(self, context):
        """Attaches a cache to each cloth. Returns the number of frames."""
        files = self.frame_files()
        if not files:
            raise BakeError(self.message())
        folder = cache_folder(context)
        folder.mkdir(parents=True, exist_ok=True)
        scale, start = context.scene.unit_settings.scale_length, context.scene.frame_start
        begin = 0
        for cloth in self.motion.sheets:
            end = begin + len(cloth.data.vertices)
            flagged = np.zeros(end - begin, dtype=np.uint8)
            inverses = [np.linalg.inv(matrix) for matrix in self.motion.matrices[cloth]]

            def local_frames():
                for file, inverse in zip(files, inverses):
                    points, flags = read_frame(file)
                    np.bitwise_or(flagged, flags[begin:end], out=flagged)
                    yield (points[begin:end] / scale) @ inverse[:3, :3].T + inverse[:3, 3]

            target = folder / (bpy.path.clean_name(cloth.name) + ".pc2")
            write_pc2(target, local_frames(), start)
            self.attach(cloth, target, start)
            self.mark(cloth, flagged)
            begin = end
        return len(files)

    def attach(self, cloth, target, start):
        modifier = cloth.modifiers.get(MODIFIER) or cloth.modifiers.new(MODIFIER, "MESH_CACHE")
        modifier.cache_format = "PC2"
        modifier.filepath = stored_path(target)
        modifier.frame_start = float(start)
        modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"
        # After those that move the pins, which the cache replaces; modifiers such as subdivision follow it. Blender before
        # 3.5 moves modifiers by an operator only.
        index = cloth.modifiers.find(MODIFIER)
        wanted = 0
        for modifier in cloth.modifiers:
            if modifier.name != MODIFIER and modifier.type not in {"ARMATURE", "HOOK", "LATTICE", "MESH_DEFORM"}:
                break
            wanted += modifier.name != MODIFIER
        if index > wanted and hasattr(cloth.modifiers, "move"):
            cloth.modifiers.move(index, wanted)
        elif index > wanted:
            with bpy.context.temp_override(object=cloth, active_object=cloth):
                bpy.ops.object.modifier_move_to_index(modifier=MODIFIER, index=wanted)

    def mark(self, cloth, flagged):
        old = cloth.vertex_groups.get(FLAGGED)
        if old is not None:
            cloth.vertex_groups.remove(old)
        if flagged.any():
            group = cloth.vertex_groups.new(name=FLAGGED)
            group.add(np.nonzero(flagged)[0].tolist(), 1.0, "REPLACE")

    def remove(self):
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        if getattr(self, "errors", None) is not None:
            self.errors.close()
        shutil.rmtree(self.folder, ignore_errors=True)


RUNNING = []  # the bake that a window shows


class SELVEDGE_OT_bake(bpy.types.Operator):
    """Simulate all cloths and attach the result to each as a mesh cache. Escape or Cancel ends the simulation early"""

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
        if RUNNING:
            self.report({"ERROR"}, "a bake is running; cancel it first")
            return {"CANCELLED"}
        if not self.start(context):
            return {"CANCELLED"}
        RUNNING.append(self.bake)
        context.window_manager.progress_begin(0, 100)
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self.bake.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        done = self.bake.progress()
        context.window_manager.progress_update(100 * done)
        context.scene.selvedge.progress = 100 * done
        context.scene.selvedge.status = f"{round(done * self.bake.frames)} of {self.bake.frames} frames"
        for area in context.screen.areas:
            area.tag_redraw()
        if self.bake.process.poll() is None:
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        RUNNING.clear()
        return self.end(context)


class SELVEDGE_OT_cancel(bpy.types.Operator):
    """End the simulation after its current frame and keep the frames so far"""

    bl_idname = "selvedge.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return bool(RUNNING)

    def execute(self, context):
        for bake in RUNNING:
            bake.cancel()
        return {"FINISHED"}


class SELVEDGE_OT_clear(bpy.types.Operator):
    """Remove the caches and the flagged vertices from all cloths"""

    bl_idname = "selvedge.clear"
    bl_label = "Clear"

    def execute(self, context):
        for cloth in cloths(context.scene):
            modifier, group = cloth.modifiers.get(MODIFIER), cloth.vertex_groups.get(FLAGGED)
            if modifier is not None:
                cloth.modifiers.remove(modifier)
            if group is not None:
                cloth.vertex_groups.remove(group)
        context.scene.selvedge.status = ""
        return {"FINISHED"}


# -- settings and panel ------------------------------------------------------------------------------------------------


class SelvedgeCloth(bpy.types.PropertyGroup):
    """Of an object."""

    enabled: bpy.props.BoolProperty(name="Cloth", description="selvedge simulates this mesh")
    pins: bpy.props.StringProperty(
        name="Pins",
        description="Vertex group; vertices with weight 0.5 or more follow hooks, armatures, parents and keyframes",
    )
    fabric: bpy.props.EnumProperty(name="Fabric", items=FABRICS)


class SelvedgeSettings(bpy.types.PropertyGroup):
    thickness: bpy.props.FloatProperty(
        name="Thickness", default=0.002, min=1e-5, max=0.1, precision=4, unit="LENGTH",
        description="Distance that the cloth keeps from colliders and from itself",
    )
    untangle: bpy.props.BoolProperty(
        name="Untangle start", description="Bring cloth apart that crosses something in the first frame, instead of refusing it"
    )
    cache_folder: bpy.props.StringProperty(
        name="Cache", subtype="DIR_PATH", description="Folder of the point caches; empty: selvedge_cache beside the .blend file"
    )
    status: bpy.props.StringProperty()
    progress: bpy.props.FloatProperty(name="Progress", subtype="PERCENTAGE", min=0.0, max=100.0)


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
        obj = context.object
        if obj is not None:
            box = layout.box()
            box.label(text=obj.name)
            if obj.type == "MESH":
                box.prop(obj.selvedge_cloth, "enabled")
            if obj.type == "MESH" and obj.selvedge_cloth.enabled:
                box.prop_search(obj.selvedge_cloth, "pins", obj, "vertex_groups")
                box.prop(obj.selvedge_cloth, "fabric")
            elif obj.type == "MESH" or obj.selvedge_collider:
                box.prop(obj, "selvedge_collider")
        for name in ("thickness", "untangle", "cache_folder"):
            layout.prop(settings, name)
        row = layout.row()
        row.operator("selvedge.cancel" if RUNNING else "selvedge.bake")
        row.operator("selvedge.clear")
        if RUNNING:
            layout.prop(settings, "progress", slider=True)
        if settings.status:
            layout.label(text=settings.status)
        if not settings.cache_folder and not bpy.data.filepath:
            layout.label(text="Save the file to keep its caches", icon="INFO")


CLASSES = (
    SelvedgeCloth, SelvedgeSettings, SelvedgePreferences, SELVEDGE_OT_bake, SELVEDGE_OT_cancel, SELVEDGE_OT_clear,
    SELVEDGE_PT_panel,
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.selvedge = bpy.props.PointerProperty(type=SelvedgeSettings)
    bpy.types.Object.selvedge_cloth = bpy.props.PointerProperty(type=SelvedgeCloth)
    bpy.types.Object.selvedge_collider = bpy.props.BoolProperty(
        name="Collider", description="Cloth of selvedge collides with this object"
    )


def unregister():
    del bpy.types.Object.selvedge_collider
    del bpy.types.Object.selvedge_cloth
    del bpy.types.Scene.selvedge
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
