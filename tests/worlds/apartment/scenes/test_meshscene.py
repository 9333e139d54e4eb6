"""A mesh of rooms becomes a scene with a floor, start areas and colours, or is refused."""

from __future__ import annotations

import json
from itertools import product

import numpy as np
import pytest
import trimesh
from PIL import Image

from sensory_commutativity.worlds.apartment.rendering.camera import (
    Camera,
    Drawable,
    Renderer,
    look_at,
)
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


def write_room_obj(path, order=slice(None), scale=1.0, head="", corners="{0} {1} {2}"):
    """Write a closed room of 4 m x 4 m x 2.5 m whose faces look inwards; `order` turns them."""
    points = [(x, y, z) for z in (0, 2.5) for y in (0, 4) for x in (0, 4)]
    quads = [(1, 2, 4, 3), (1, 5, 6, 2), (2, 6, 8, 4), (4, 8, 7, 3), (3, 7, 5, 1), (5, 7, 8, 6)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    lines = [head, *(f"v {x * scale} {y * scale} {z * scale}" for x, y, z in points)]
    for i, face in enumerate(faces):
        turned = face[::-1] if order == "outwards" or (order == "mixed" and i % 2) else face
        lines.append("f " + corners.format(*turned))
    path.write_text("\n".join(lines) + "\n")


def test_a_room_is_seen_and_touched_whichever_way_its_faces_look(tmp_path):
    for order in ("inwards", "outwards", "mixed"):
        write_room_obj(tmp_path / "room.obj", order)
        scene = load_scene(write_scene(tmp_path, {**MESH, "mesh": "room.obj"}))
        (fixture,) = scene.fixtures
        vertices = np.concatenate([part.mesh.vertices for part in fixture.parts])
        assert (vertices[:, 2].min(), vertices[:, 2].max()) == (0, 2.5), order
        assert len(fixture.solids[0].faces) == 10, order  # all but the floor
        drawables = [Drawable(part, 10_001, 0) for part in fixture.parts]
        renderer = Renderer(drawables, 1)
        for bearing in range(0, 360, 60):
            direction = np.radians(bearing)
            target = 2 + np.cos(direction), 2 + np.sin(direction), 1.0
            view = look_at((2, 2, 1.2), target)
            picture = renderer.render(Camera(32, 32), view, np.eye(4)[None])
            assert (picture.segmentation == 10_001).all(), (order, bearing)


def test_the_floor_is_on_top_of_a_slab_and_below_furniture():
    slab, table = box_mesh((4, 4, 0.3), (0, 0, -0.15)), box_mesh((1.5, 1, 0.05), (0, 0, 0.4))
    mesh = trimesh.util.concatenate([slab, table])
    assert find_floor_height(mesh.vertices, mesh.faces) == pytest.approx(0.0)
    assert find_floor_height(mesh.vertices, mesh.faces[:, ::-1]) == pytest.approx(-0.3)


def test_a_size_that_makes_no_sense_is_refused_before_any_work(tmp_path):
    for scale, message in (
        (1000, "4000 m wide with scale 1; .* in millimetres, set scale to 0.001"),
        (0.001, "0.004 m wide .* in kilometres, set scale to 1000"),
        (1e9, "in another unit, set scale"),
    ):
        write_room_obj(tmp_path / "room.obj", scale=scale)
        with pytest.raises(SceneError, match=message):
            load_scene(write_scene(tmp_path, {**MESH, "mesh": "room.obj"}))


def colours_of(scene):
    """Colours of the faces of a mesh scene, rounded, and how many faces have each."""
    parts = scene.fixtures[0].parts
    return {tuple(round(c, 2) for c in part.colour): len(part.mesh.faces) for part in parts}


def test_colours_of_materials_and_pictures_are_seen(tmp_path):
    Image.fromarray(np.array([[[255, 0, 0]], [[0, 0, 255]]], np.uint8)).save(tmp_path / "a.png")
    palette = Image.open(tmp_path / "a.png").convert("P")
    palette.save(tmp_path / "palette.png")
    red = "newmtl red\nKd 1 0 0\n"
    for mtl, head, expected in (
        (red, "usemtl red", {(1.0, 0.0, 0.0): 12}),
        (
            "newmtl red\nmap_Kd a.png\n",
            "usemtl red\nvt 0 1\nvt 1 1\nvt 1 .8",
            {(1.0, 0.0, 0.0): 12},
        ),
        (
            "newmtl red\nmap_Kd -s 1 1 1 -clamp on a.png\n",
            "usemtl red\nvt 0 1\nvt 1 1\nvt 1 .8",
            {(1.0, 0.0, 0.0): 12},
        ),
        (
            "newmtl red\nKd 0 0 0\nmap_Kd palette.png\n",
            "usemtl red\nvt 0 0\nvt 1 0\nvt 1 .2",
            {(0.0, 0.0, 1.0): 12},
        ),
    ):
        (tmp_path / "room.mtl").write_text(mtl)
        corners = "{0}/1 {1}/2 {2}/3" if "vt" in head else "{0} {1} {2}"
        write_room_obj(tmp_path / "room.obj", head=f"mtllib room.mtl\n{head}", corners=corners)
        scene = load_scene(write_scene(tmp_path, {**MESH, "mesh": "room.obj"}))
        assert colours_of(scene) == expected, mtl


def test_colours_that_cannot_be_read_are_told(tmp_path):
    settings = {**MESH, "mesh": "room.obj"}
    corners = "{0}/1 {1}/1 {2}/1"
    write_room_obj(tmp_path / "room.obj", head="mtllib Room.mtl\nvt 0 0\nusemtl a", corners=corners)
    with pytest.raises(SceneError, match=r"colours from 'Room\.mtl'.*colours: false"):
        load_scene(write_scene(tmp_path, settings))
    assert load_scene(write_scene(tmp_path, {**settings, "colours": False})).fixtures
    (tmp_path / "Room.mtl").write_text("newmtl a\nmap_Kd gone.png\n")
    with pytest.raises(SceneError, match=r"colours from 'gone\.png'"):
        load_scene(write_scene(tmp_path, settings))
    (tmp_path / "gone.png").write_bytes(b"\x89PNG no picture")
    with pytest.raises(SceneError, match="cannot be read as a picture"):
        load_scene(write_scene(tmp_path, settings))


def test_mesh_files_that_mislead_are_refused(tmp_path):
    draco = {"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_draco_mesh_compression"]}
    huge = {"asset": {"version": "2.0"}, "accessors": [{"count": 10**12}]}
    write_room_obj(tmp_path / "nan.obj")
    text = (tmp_path / "nan.obj").read_text().replace("v 0.0 0.0 0.0", "v nan 0 0")
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n"
    for name, content, message in (
        ("a.gltf", json.dumps(draco), "compressed by Draco.*export it without"),
        ("b.gltf", json.dumps(huge), "more than 3,000,000 faces"),
        ("c.gltf", "{", "its JSON is not valid"),
        ("d.glb", "glTF....", "damaged"),
        ("nan.obj", text.replace("v 0 0 0.0", "v nan 0 0.0"), "no finite numbers"),
        ("e.ply", header + "end_header\n", "declares 4,000,000,000 of vertex"),
        ("f.dae", "<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA/>", "declares entities"),
        ("g.obj", "v 0 0 0\nf 1 2 3\n", "cannot be read as a mesh|do not exist"),
        ("h.stl", "PK\x03\x04", "is a ZIP archive"),
    ):
        (tmp_path / name).write_text(content)
        with pytest.raises(SceneError, match=message) as error:
            load_scene(write_scene(tmp_path, {**MESH, "mesh": name}))
        assert "\n" not in str(error.value), name
