# SPDX-License-Identifier: MIT
"""Checks, measures, comparisons, pictures and lists."""

import json

import numpy as np
import pytest
import selvedge

from conftest import ROOT, ball_scene, sheet


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run") / "out"
    selvedge.run(ball_scene(), folder, every_step=True)
    return folder


def test_check_counts_crossings_of_arrays():
    x, t = sheet()
    assert selvedge.check(x, t)["self_intersections"] == 0
    tilted = x @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]) + [0.01, 0.02, 0.03]
    verdict = selvedge.check(x, t, against=(tilted, t))
    assert verdict["body_intersections"] == len(selvedge.find_crossings(x, t, (tilted, t))) > 0
    stretched = selvedge.check(1.1 * x, t, rest=(x, t))
    assert stretched["max_stretch"] == pytest.approx(0.1)
    path = selvedge.check(x + [0, 0, 0.1], t, against=(x, t), next=x - [0, 0, 0.1])
    assert path["path_body_collisions"] > 0 and path["body_intersections"] == 0
    with pytest.raises(ValueError, match="finite"):
        selvedge.check(np.full_like(x, np.nan), t)
    with pytest.raises(TypeError, match="need `triangles`"):
        selvedge.check(x)


def test_check_reads_files_and_result_folders(result):
    seen = []
    verdict = selvedge.check(result, progress=lambda done, of: seen.append((done, of)))
    assert verdict["self_intersections"] == verdict["body_intersections"] == 0
    assert verdict["states"] == 13 and verdict["paths"] == 12 and verdict["first_wrong"] == ""
    assert max(seen) == (13, 13)
    frames = sorted((result / "frames").glob("cloth_*.ply"))
    assert selvedge.check(frames[0])["vertices"] == 81
    rows = selvedge.check(frames, paths=True)
    assert [row["file"] for row in rows] == [str(f) for f in frames]
    with pytest.raises(ValueError, match="none.ply"):
        selvedge.check(result / "none.ply")


def test_measure_has_the_names_of_the_program(result):
    table = selvedge.measure(result)
    arrays = table["arrays"]
    assert arrays["x"].shape == (81, 3)
    assert len(arrays["spring_strain"]) == len(arrays["spring_vertices"])
    assert arrays["triangle_strain"].shape == (len(arrays["triangles"]), 2)
    assert (arrays["triangle_strain"][:, 0] <= arrays["triangle_strain"][:, 1]).all()
    assert table["frame"] == 6
    with pytest.raises(ValueError, match="frame"):
        selvedge.measure(result, 99)


def test_compare_gives_a_row_for_each_cell(tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps(ball_scene(cells=4, frames=2)))
    seen = []
    table = selvedge.compare(
        scene,
        "broad_phase=bvh_aabb,brute_force",
        tmp_path / "out",
        reference=False,
        repeats=1,
        progress=lambda done, everything: seen.append((done, everything)),
    )
    assert len(table["rows"]) == 2 and all(row["status"] == "ok" for row in table["rows"])
    assert seen and seen[-1][0] == seen[-1][1]
    assert (tmp_path / "out" / "compare.html").stat().st_size > 1000
    again = selvedge.compare(
        scene,
        "broad_phase=bvh_aabb,brute_force",
        tmp_path / "out",
        reference=False,
        repeats=1,
    )
    assert again["rows"] == table["rows"]
    with pytest.raises(ValueError, match="nearest|unknown"):
        selvedge.compare(scene, "broad_fase=all", tmp_path / "other", reference=False)
    with pytest.raises(ValueError, match="design"):
        selvedge.compare(scene, "broad_phase=all", tmp_path / "other", design="all")


def test_pictures_are_arrays(result, tmp_path):
    x, t = sheet(z=0.2)
    body = sheet(z=0.0)
    image = selvedge.render(x, t, bodies=[body], width=160, height=120)
    assert image.shape == (120, 160, 3) and image.dtype == np.uint8
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 20
    np.testing.assert_array_equal(
        image, selvedge.render(x, t, bodies=[body], width=160, height=120)
    )
    other = selvedge.render(x, t, eye=[2, 0, 1], width=160, height=120)
    assert not np.array_equal(image, other)
    frame = selvedge.render_result(result, 0, width=160, height=120)
    assert not np.array_equal(frame, selvedge.render_result(result, width=160, height=120))
    selvedge.write_png(tmp_path / "picture.png", image)
    assert (tmp_path / "picture.png").read_bytes()[1:4] == b"PNG"
    with pytest.raises(ValueError, match="has no frame 77"):
        selvedge.render_result(result, 77)
    with pytest.raises(TypeError, match="uint8"):
        selvedge.write_png(tmp_path / "picture.png", image.astype(float))


def test_the_list_of_methods_is_that_of_the_program(program):
    import subprocess

    listed = json.loads(
        subprocess.run([program, "list", "--json"], check=True, capture_output=True).stdout
    )
    rows = listed["methods"] if isinstance(listed, dict) else listed
    ours = {(m["family"], m["name"], m["available"]) for m in selvedge.list_methods()}
    theirs = {(m["family"], m["name"], m["available"]) for m in rows if m["family"] != "format"}
    families = {family for family, _, _ in ours}
    assert {row for row in theirs if row[0] in families} == ours


def test_licence_names_version_and_libraries():
    text = selvedge.licence()
    version = (ROOT / "CMakeLists.txt").read_text().split("project(selvedge VERSION ")[1].split()[0]
    assert text.startswith(f"selvedge {version}\nlicence: ")
    assert "pybind11" in text and "Eigen" in text and selvedge.__version__ == version
