"""A mesh of rooms becomes a scene with a floor, start areas and colours, or is refused."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import trimesh

from sensory_commutativity.worlds.apartment.scenes.meshscene import find_floor_height
from sensory_commutativity.worlds.apartment.scenes.scene import SceneError
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from tests.worlds.apartment.scenes.examples import MESH, box_mesh, room_mesh, write_scene


def test_a_mesh_becomes_a_scene_whatever_its_format_scale_and_axes(tmp_path):
    for suffix, up in product(("ply", "glb", "obj", "stl"), "zy"):
        case = (suffix, up)
        mesh = room_mesh(up)
        mesh.apply_scale(100)
        mesh.export(tmp_path / f"room.{suffix}")
        settings = {**MESH, "mesh": f"room.{suffix}", "scale": 0.01, "up": up}
        settings["objects"] = [{"type": "carton", "at": [0, 0]}]
        scene = load_scene(write_scene(tmp_path, settings))
        assert scene.movables[0].position == pytest.approx((0, 0, 0.151)), case
        (fixture,) = scene.fixtures
        vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
        assert vertices.min(0) == pytest.approx((-2.05, -1.55, -0.1), abs=1e-3), case
        assert vertices.max(0) == pytest.approx((2.05, 1.55, 2.4), abs=1e-3), case
        (solid,) = fixture.solids
        assert solid.kind == "mesh", case
        assert (solid.vertices[solid.faces][..., 2].max(1) > 0.03).all(), case
        x, y = (np.array([getattr(area, axis) for area in scene.areas]) for axis in "xy")
        assert (x.min(), x.max()) == pytest.approx((-2.05, 2.05), abs=0.2), case
        assert (np.ptp(x, 1) * np.ptp(y, 1)).sum() == pytest.approx(4.1 * 3.1, rel=0.1), case
        if suffix in ("ply", "glb"):  # the other formats have no colours here
            colours = {tuple(round(c, 1) for c in part.colour) for part in fixture.parts}
            assert colours == {(0.8, 0.1, 0.1), (0.1, 0.1, 0.8)}, case


def test_a_robot_starts_only_above_the_floor(tmp_path):
    """In an L-shaped room the missing quarter is no start area."""
    parts = [box_mesh((4, 2, 0.1), (0, -1, -0.05)), box_mesh((2, 2, 0.1), (-1, 1, -0.05))]
    trimesh.util.concatenate(parts).export(tmp_path / "room.ply")
    scene = load_scene(write_scene(tmp_path, {**MESH, "floor": 0.0}))
    centres = np.array([(np.mean(area.x), np.mean(area.y)) for area in scene.areas])
    assert len(centres) == 12 * 16
    assert not (centres > 0).all(1).any()


def test_a_mesh_without_a_level_surface_needs_the_height_of_its_floor(tmp_path):
    mesh = room_mesh()
    mesh.update_faces(np.abs(mesh.face_normals[:, 2]) <= 0.9)
    mesh.export(tmp_path / "room.ply")
    assert find_floor_height(np.asarray(mesh.vertices), np.asarray(mesh.faces)) is None
    with pytest.raises(SceneError, match="has no floor: no level surface"):
        load_scene(write_scene(tmp_path, MESH))
    scene = load_scene(write_scene(tmp_path, {**MESH, "floor": -1.3}))
    vertices = np.concatenate([part.mesh.vertices for part in scene.fixtures[0].parts])
    assert vertices[:, 2].max() == pytest.approx(2.4)
    assert [area.name for area in scene.areas] == ["everywhere"]


def test_an_invalid_mesh_scene_is_refused(tmp_path):
    path = tmp_path / "room.ply"
    with pytest.raises(SceneError, match=r"mesh: there is no file 'room\.ply'"):
        load_scene(write_scene(tmp_path, MESH))
    path.write_text("no mesh")
    with pytest.raises(SceneError, match="cannot be read"):
        load_scene(write_scene(tmp_path, MESH))
    room_mesh().export(path)
    mug = {"type": "mug", "stands_on": "table", "at": [0, 0]}
    with pytest.raises(SceneError, match="nothing can stand on it by name"):
        load_scene(write_scene(tmp_path, {**MESH, "objects": [mug]}))
    with pytest.raises(SceneError, match="scale"):
        load_scene(write_scene(tmp_path, {**MESH, "scale": -1}))
