# SPDX-License-Identifier: MIT
"""Parts of the Blender add-on, with stand-ins for Blender. bindings/blender/check.sh addon tests all of it in Blender."""

import importlib.util
import sys
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest

from conftest import ROOT


class Column:
    """A list of Blender: one number or more an element, read by foreach_get."""

    def __init__(self, **columns):
        self.columns = {name: np.asarray(values) for name, values in columns.items()}

    def __len__(self):
        return len(next(iter(self.columns.values())))

    def foreach_get(self, name, out):
        out[:] = self.columns[name].ravel()


class Mesh:
    """Faces with any number of corners, divided into triangles from the corner `first`."""

    def __init__(self, points, faces, first):
        starts = np.cumsum([0] + [len(face) for face in faces])[:-1]
        turned = [face[first % len(face) :] + face[: first % len(face)] for face in faces]
        triangles = [[f[0], f[k], f[k + 1]] for f in turned for k in range(1, len(f) - 1)]
        self.vertices = Column(co=points)
        self.polygons = Column(loop_start=starts)
        self.loops = Column(vertex_index=[v for face in faces for v in face])
        self.loop_triangles = Column(vertices=triangles)

    def calc_loop_triangles(self):
        pass


class Body(SimpleNamespace):
    __hash__ = object.__hash__


class Modifiers(list):
    """Those of Blender 3.4, which have no `move`."""

    def get(self, name):
        return next((m for m in self if m.name == name), None)

    def find(self, name):
        return next((k for k, m in enumerate(self) if m.name == name), -1)

    def new(self, name, kind):
        self.append(SimpleNamespace(name=name, type=kind))
        return self[-1]


@pytest.fixture
def addon():
    types = ("PropertyGroup", "AddonPreferences", "Operator", "Panel")
    bpy = mock.MagicMock()
    bpy.types = SimpleNamespace(Object=object, **{name: object for name in types})
    spec = importlib.util.spec_from_file_location("addon", ROOT / "bindings" / "blender" / "selvedge_cloth.py")
    module = importlib.util.module_from_spec(spec)
    with mock.patch.dict(sys.modules, {"bpy": bpy}):
        spec.loader.exec_module(module)
    module.bpy = bpy
    return module


POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0.0]])
FACES = [[0, 1, 2, 3], [1, 4, 5, 2]]
OTHER_FACES = [[0, 1, 2, 3], [1, 4, 5], [1, 5, 2]]


def exported(addon, folder, meshes):
    """The obstacles of a collider that has these meshes in the frames 1, 2, ..."""
    scene = SimpleNamespace(frame_start=1, frame_end=len(meshes), frame=1)
    scene.frame_set = lambda frame: setattr(scene, "frame", frame)
    body = Body(name="post", type="MESH", selvedge_collider=True, matrix_world=np.eye(4))
    body.evaluated_get = lambda graph: body
    body.to_mesh = lambda: meshes[scene.frame - 1]
    body.to_mesh_clear = lambda: None
    body.hide_viewport, body.hide_get = False, lambda: False
    scene.objects = [body]
    context = SimpleNamespace(scene=scene, evaluated_depsgraph_get=lambda: None)
    motion = addon.Motion(context, [], addon.colliders(scene, []), 1.0)
    return addon.export_colliders(motion, folder, 24.0)


def test_a_bent_collider_keeps_the_triangles_of_its_first_frame(addon, tmp_path):
    bent = POINTS + np.sin(POINTS[:, :1]) * [0, 0, 0.3]
    meshes = [Mesh(POINTS, FACES, 0), Mesh(bent, FACES, 1), Mesh(bent, FACES, 2)]
    (obstacle,) = exported(addon, tmp_path, meshes)
    assert obstacle["sequence"]["files"] == "body_0_#####.ply"
    files = [(tmp_path / f"body_0_{k:05d}.ply").read_bytes() for k in range(3)]
    faces = [content[content.index(b"end_header\n") + 11 + 24 * len(POINTS) :] for content in files]
    assert faces[0] == faces[1] == faces[2] and files[0] != files[1] == files[2]


def test_a_collider_whose_faces_change_is_refused(addon, tmp_path):
    with pytest.raises(addon.BakeError, match="faces of post change at frame 2"):
        exported(addon, tmp_path, [Mesh(POINTS, FACES, 0), Mesh(POINTS, OTHER_FACES, 0)])


@pytest.mark.parametrize("has_move", [False, True])
def test_the_cache_is_before_the_modifiers_that_the_cloth_has(addon, tmp_path, has_move):
    modifiers = Modifiers()
    modifiers.new("Subdivision", "SUBSURF")
    modifiers.new("Smooth", "SMOOTH")

    def move(old, new):
        modifiers.insert(new, modifiers.pop(old))

    if has_move:
        modifiers.move = move
    addon.bpy.ops.object.modifier_move_to_index = lambda modifier, index: move(
        modifiers.find(modifier), index
    )
    cloth = SimpleNamespace(modifiers=modifiers)
    for _ in range(2):
        addon.Bake.attach(None, cloth, tmp_path / "cache.pc2", 1)
        assert [m.name for m in modifiers] == ["selvedge cache", "Subdivision", "Smooth"]
    modifiers.insert(0, SimpleNamespace(name="Hook", type="HOOK"))
    modifiers.insert(1, modifiers.pop(2))
    addon.Bake.attach(None, cloth, tmp_path / "cache.pc2", 1)
    assert [m.name for m in modifiers] == ["Hook", "selvedge cache", "Subdivision", "Smooth"]


def test_sewing_edges_become_rows_that_name_a_vertex_once(addon):
    polygons = [SimpleNamespace(edge_keys=[(0, 1), (1, 2), (0, 2)])]
    edges = [SimpleNamespace(vertices=pair) for pair in ((1, 0), (0, 3), (1, 4), (0, 5))]
    seams = addon.sewing_seams("skirt", SimpleNamespace(polygons=polygons, edges=edges))
    rows = [[side["select"] for side in seam["sides"]] for seam in seams]
    assert rows == [[[0, 1], [3, 4]], [[0], [5]]]
    assert seams[0]["sides"][0]["geometry"] == "skirt"


def test_pins_that_move_alike_share_a_handle(addon, monkeypatch):
    rest = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0.0]])
    moved = rest + [[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 1, 0]]
    monkeypatch.setattr(addon, "held_vertices", lambda cloth, group: [0, 1, 2, 3])
    cloth = Body(name="flag", selvedge_cloth=SimpleNamespace(pins="pins"))
    handles = addon.pin_handles(SimpleNamespace(states={cloth: [rest, moved]}), cloth, "cloth_0", 24.0)
    assert [h["select"] for h in handles] == [[0, 1], [2], [3]]
    assert "motion" not in handles[1]
    assert handles[0]["motion"][1] == {"time": 1 / 24, "translation": [0.0, 0.0, 1.0]}


def test_hidden_colliders_and_those_without_a_mesh_are_named(addon):
    def marked(name, kind, hidden):
        return Body(name=name, type=kind, selvedge_collider=True, hide_viewport=hidden, hide_get=lambda: False)

    with pytest.raises(addon.BakeError, match="^rope, lamp: marked as collider, but no mesh"):
        addon.colliders(SimpleNamespace(objects=[marked("rope", "CURVE", False), marked("lamp", "LIGHT", True)]), [])
    with pytest.raises(addon.BakeError, match="^ball: marked as collider, but hidden"):
        addon.colliders(SimpleNamespace(objects=[marked("ball", "MESH", True)]), [])
