"""The camera of the apartment: meshes, textures, where things appear, which thing a pixel shows, the same picture every time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensory_commutativity.worlds.apartment import frames as fr
from sensory_commutativity.worlds.apartment import geometry
from sensory_commutativity.worlds.apartment.rendering.camera import (
    Camera,
    Drawable,
    Renderer,
    look_at,
)
from sensory_commutativity.worlds.apartment.rendering.raster import BACKGROUND
from sensory_commutativity.worlds.apartment.rendering.textures import SIZE, TEXTURES, texture
from sensory_commutativity.worlds.apartment.scenes.scene import Part

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
AT_ORIGIN = look_at((0, 0, 0), (1, 0, 0))
WORLD = np.eye(4)[None]


def piece(mesh, position=(0.0, 0.0, 0.0), colour=RED, identity=1, body=0, texture_name=""):
    return Drawable(Part(geometry.transform(mesh, position), colour, texture_name), identity, body)


def wall(x, half=1.0, **more):
    """A thin wall across the view at `x` metres, facing the eye."""
    return piece(geometry.box((0.001, half, half)), (x, 0.0, 0.0), **more)


def seen(drawables, camera=None, eye=AT_ORIGIN, poses=WORLD):
    return Renderer(drawables, len(poses)).render(camera or Camera(65, 65, 90, 1), eye, poses)


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (geometry.box((0.5, 1.0, 1.5)), 6.0),
        (geometry.panel((0.5, 1.0, 1.5)), 6.0),
        (geometry.cylinder(0.5, 1.0, 96), math.pi * 0.25 * 2),
        (geometry.sphere(1.0, 48, 96), 4 / 3 * math.pi),
        (
            geometry.lathe([(0, 0), (1, 0), (1, 2), (0.9, 2), (0.9, 0.1), (0, 0.1)], 96),
            math.pi * (2 - 0.81 * 1.9),
        ),
        (geometry.handle(0.03, 0.01, 32, 24), math.pi * 0.03 * math.pi * 0.005**2),
    ],
)
def test_meshes_are_closed_and_turned_outwards(mesh, expected):
    assert geometry.volume(mesh) == pytest.approx(expected, rel=0.02)
    edges = np.sort(
        np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]]),
        axis=1,
    )
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert mesh.uv.shape == (len(mesh.faces), 3, 2)


def test_a_mesh_file_is_read_and_thinned_out(tmp_path):
    import trimesh

    trimesh.creation.icosphere(subdivisions=3, radius=2.0).export(tmp_path / "ball.stl")
    whole, thin = (
        geometry.load_mesh(tmp_path / "ball.stl"),
        geometry.load_mesh(tmp_path / "ball.stl", 100),
    )
    assert len(whole.faces) == 1280 and len(thin.faces) <= 110
    assert geometry.volume(whole) == pytest.approx(33.1, rel=0.02) and geometry.volume(
        thin
    ) == pytest.approx(33.1, rel=0.2)


@pytest.mark.parametrize("name", TEXTURES)
def test_a_texture_differs_from_the_others_and_is_not_flat(name):
    image = texture(name)
    assert image.shape == (SIZE, SIZE, 3) and image.dtype == np.uint8 and image.std() > 1
    assert all(not np.array_equal(image, texture(other)) for other in TEXTURES if other != name)


@pytest.mark.parametrize(
    "name",
    ["wood", "darkwood", "marble", "carpet", "leather", "plaster", "tile", "checker", "brick"],
)
def test_a_texture_repeats_without_a_seam(name):
    image = texture(name).astype(float)
    for axis in (0, 1):
        steps = np.abs(np.diff(image, axis=axis)).mean(axis=(1 - axis, 2))
        seam = np.abs(image.take(0, axis) - image.take(-1, axis)).mean()
        assert seam <= 1.1 * steps.max()


@pytest.mark.parametrize("view", [45.0, 90.0])
@pytest.mark.parametrize(("left", "up"), [(0.0, 0.0), (0.5, 0.0), (0.0, 0.6), (-0.4, -0.3)])
def test_a_thing_appears_where_the_pinhole_says(view, left, up):
    camera = Camera(201, 201, view, 1)
    identity = seen([piece(geometry.sphere(0.05, 16, 24), (2.0, left, up))], camera).identity
    rows, columns = np.nonzero(identity)
    focal = 201 / 2 / math.tan(math.radians(view) / 2)
    assert columns.mean() == pytest.approx(
        100 - focal * left / 2, abs=0.6
    ) and rows.mean() == pytest.approx(100 - focal * up / 2, abs=0.6)
    assert len(rows) == pytest.approx(math.pi * (0.05 / 2 * focal) ** 2, rel=0.15)


def test_the_nearer_thing_hides_the_farther_whatever_the_order():
    near, far = wall(1.0, 0.3, identity=7), wall(2.0, 3.0, colour=GREEN, identity=8)
    for drawables in ([near, far], [far, near]):
        identity = seen(drawables).identity
        assert identity[32, 32] == 7 and identity[0, 0] == 8 and set(np.unique(identity)) == {7, 8}


def test_pictures_do_not_depend_on_the_order_of_pieces_nor_on_what_was_drawn_before():
    rng = np.random.default_rng(3)
    drawables = [
        piece(
            geometry.box(rng.uniform(0.1, 0.4, 3)),
            rng.uniform(-2, 2, 3),
            tuple(rng.uniform(0, 1, 3)),
            i + 1,
            0,
            TEXTURES[i % 20],
        )
        for i in range(40)
    ]
    camera, eye = Camera(64, 48, 90, 3), look_at((-2.5, 0.1, 0.3), (0, 0, 0))
    renderer = Renderer(drawables, 1)
    first = renderer.render(camera, eye, WORLD)
    renderer.render(Camera(32, 32, 45, 1), AT_ORIGIN, WORLD)
    for other in (
        renderer.render(camera, eye, WORLD),
        Renderer(drawables[::-1], 1).render(camera, eye, WORLD),
    ):
        assert np.array_equal(first.rgb, other.rgb) and np.array_equal(
            first.segmentation, other.segmentation
        )
    assert (
        first.rgb.shape == (48, 64, 3)
        and first.rgb.dtype == np.uint8
        and first.segmentation.dtype == np.int32
    )


def test_what_is_behind_or_too_near_is_not_seen_and_nothing_is_sky():
    picture = seen([wall(-1.0), wall(0.02, 0.01)])
    assert not picture.segmentation.any()
    assert np.allclose(picture.rgb[0, 0], np.array(BACKGROUND) * 255, atol=1)


def test_a_floor_that_passes_below_the_eye_is_cut_at_the_near_plane():
    floor = piece(geometry.box((50.0, 50.0, 0.01)), (0.0, 0.0, -1.0), identity=5)
    identity = seen([floor]).identity
    assert (identity[34:] == 5).all() and not identity[
        :32
    ].any()  # 50 m away the floor's edge is half a pixel below the horizon


def test_only_the_outside_of_a_thing_is_seen():
    assert not seen([piece(geometry.box((1.0, 1.0, 1.0)))]).identity.any()  # from within


def test_samples_are_averaged():
    half = [
        wall(1.0, 5.0, identity=1),
        piece(geometry.box((0.001, 5.0, 5.0)), (0.9, 5.0, 0.0), GREEN, 2),
    ]  # the left half is green
    fine, coarse = (
        seen(half, Camera(5, 5, 90, 16)).rgb.astype(float),
        seen(half, Camera(5, 5, 90, 1)).rgb,
    )
    middle, left, right = fine[2, 2], fine[2, 0], fine[2, 4]
    assert (
        np.allclose(middle, (left + right) / 2, atol=1)
        and left[1] > 100 > left[0]
        and right[0] > 100 > right[1]
    )
    assert set(map(tuple, coarse[2])) == {tuple(coarse[2, 0]), tuple(coarse[2, 4])}


def test_a_texture_is_laid_on_in_perspective():
    camera = Camera(301, 301, 90, 1)
    floor = piece(
        geometry.box((30.0, 30.0, 0.5), 1.0), (0.0, 0.0, -1.5), (1.0, 1.0, 1.0), 1, 0, "checker"
    )
    column = seen([floor], camera).rgb[152:, 150, 0].astype(int)
    dark = column < 180 * 0.75
    changes = np.nonzero(np.diff(dark))[0] + 152
    distances = 150.5 / (
        changes + 0.5 - 150
    )  # of the floor, one metre below the eye, where these rows look
    near = distances[
        (distances > 1.05) & (distances < 3)
    ]  # farther off a row is too much of the floor
    assert len(near) == 4 and np.allclose(
        near * 2, np.round(near * 2), atol=0.06
    )  # the squares of the board are half a metre wide


def test_bodies_move_and_carry_their_pieces():
    renderer = Renderer([wall(1.0, 0.2, identity=3, body=1)], 2)
    for shift in (0.0, 0.4, -0.3):
        poses = np.stack([np.eye(4), fr.on_floor(1.0, shift, 0.0)])
        columns = np.nonzero(renderer.render(Camera(101, 101, 90, 1), AT_ORIGIN, poses).identity)[1]
        assert columns.mean() == pytest.approx(50 - 50.5 * shift / 2, abs=0.6)


def test_arguments_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="bodies are numbered from 0 to 0"):
        Renderer([wall(1.0, body=1)], 1)
    with pytest.raises(ValueError, match="give float64"):
        Renderer([wall(1.0)], 1).render(Camera(), AT_ORIGIN, np.zeros((2, 4, 4)))
    with pytest.raises(ValueError, match="there is no texture 'velvet'"):
        Renderer([wall(1.0, texture_name="velvet")], 1)
