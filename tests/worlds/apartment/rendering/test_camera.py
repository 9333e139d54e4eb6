"""The renderer: projection, occlusion, segmentation, textures, and bit-identical repetition."""

from __future__ import annotations

import itertools
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
from sensory_commutativity.worlds.apartment.rendering.textures import TEXTURES
from sensory_commutativity.worlds.apartment.scenes.scene import Part

RED, GREEN, WHITE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 1.0)
AT_ORIGIN = look_at((0, 0, 0), (1, 0, 0))
WORLD = np.eye(4)[None]


def drawable(mesh, position=(0.0, 0.0, 0.0), colour=RED, number=1, body=0, texture=""):
    return Drawable(Part(geometry.transform(mesh, position), colour, texture), number, body)


def wall(x, half=1.0, **options):
    """A thin wall across the view at `x` metres that faces the camera."""
    return drawable(geometry.box((0.001, half, half)), (x, 0.0, 0.0), **options)


def render(drawables, camera=None, pose=AT_ORIGIN):
    return Renderer(drawables, 1).render(camera or Camera(65, 65, 90, 1), pose, WORLD)


def test_a_ball_appears_where_a_pinhole_projects_it():
    positions = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.6), (-0.4, -0.3)]
    for field_of_view, (left, up) in itertools.product((45.0, 90.0), positions):
        case = (field_of_view, left, up)
        ball = drawable(geometry.sphere(0.05, 16, 24), (2.0, left, up))
        rows, columns = np.nonzero(render([ball], Camera(201, 201, field_of_view, 1)).segmentation)
        focal = 201 / 2 / math.tan(math.radians(field_of_view) / 2)
        assert columns.mean() == pytest.approx(100 - focal * left / 2, abs=0.6), case
        assert rows.mean() == pytest.approx(100 - focal * up / 2, abs=0.6), case
        assert len(rows) == pytest.approx(math.pi * (0.05 / 2 * focal) ** 2, rel=0.15), case


def test_depth_is_measured_along_the_optical_axis():
    depth = render([wall(2.0)]).depth
    assert depth.dtype == np.float32
    assert depth[20:45, 20:45] == pytest.approx(1.999, abs=1e-4)
    assert np.isinf(depth[0]).all()


def test_the_nearest_drawable_occludes_the_others_in_any_order():
    near, far = wall(1.0, 0.3, number=7), wall(2.0, 3.0, colour=GREEN, number=8)
    for drawables in ([near, far], [far, near]):
        segmentation = render(drawables).segmentation
        assert segmentation[32, 32] == 7
        assert segmentation[0, 0] == 8
        assert set(np.unique(segmentation)) == {7, 8}


def test_pictures_do_not_depend_on_the_order_of_drawables_nor_on_earlier_pictures():
    rng = np.random.default_rng(3)
    drawables = [
        drawable(
            geometry.box(rng.uniform(0.1, 0.4, 3)),
            rng.uniform(-2, 2, 3),
            tuple(rng.uniform(0, 1, 3)),
            number=i + 1,
            texture=TEXTURES[i % 20],
        )
        for i in range(40)
    ]
    camera, pose = Camera(64, 48, 90, 3), look_at((-2.5, 0.1, 0.3), (0, 0, 0))
    renderer = Renderer(drawables, 1)
    first = renderer.render(camera, pose, WORLD)
    renderer.render(Camera(32, 32, 45, 1), AT_ORIGIN, WORLD)
    repeated = renderer.render(camera, pose, WORLD)
    reordered = Renderer(drawables[::-1], 1).render(camera, pose, WORLD)
    for picture in (repeated, reordered):
        assert all(np.array_equal(a, b) for a, b in zip(first, picture, strict=True))
    assert first.rgb.shape == (48, 64, 3)
    assert first.rgb.dtype == np.uint8
    assert first.segmentation.dtype == np.int32


def test_faces_behind_the_camera_the_near_plane_or_their_own_solid_are_invisible():
    inside_a_box = drawable(geometry.box((1.0, 1.0, 1.0)))
    picture = render([wall(-1.0), wall(0.02, 0.01), inside_a_box])
    assert not picture.segmentation.any()
    assert np.allclose(picture.rgb[0, 0], np.array(BACKGROUND) * 255, atol=1)


def test_a_floor_that_passes_below_the_camera_is_clipped_at_the_near_plane():
    floor = drawable(geometry.box((50.0, 50.0, 0.01)), (0.0, 0.0, -1.0), number=5)
    segmentation = render([floor]).segmentation
    assert (segmentation[34:] == 5).all()
    assert not segmentation[:32].any()  # the edge, 50 m away, is half a pixel below the horizon


def test_a_pixel_is_the_mean_of_its_samples():
    green_left_half = drawable(geometry.box((0.001, 5.0, 5.0)), (0.9, 5.0, 0.0), GREEN, 2)
    drawables = [wall(1.0, 5.0), green_left_half]
    fine = render(drawables, Camera(5, 5, 90, 16)).rgb.astype(float)
    coarse = render(drawables, Camera(5, 5, 90, 1)).rgb
    left, middle, right = fine[2, 0], fine[2, 2], fine[2, 4]
    assert left[1] > 100 > left[0]
    assert right[0] > 100 > right[1]
    assert np.allclose(middle, (left + right) / 2, atol=1)
    assert set(map(tuple, coarse[2])) == {tuple(coarse[2, 0]), tuple(coarse[2, 4])}


def test_a_texture_is_drawn_in_perspective():
    mesh = geometry.box((30.0, 30.0, 0.5), 1.0)
    floor = drawable(mesh, (0.0, 0.0, -1.5), WHITE, texture="checker")
    column = render([floor], Camera(301, 301, 90, 1)).rgb[152:, 150, 0].astype(int)
    dark = column < 180 * 0.75
    rows = np.nonzero(np.diff(dark))[0] + 152
    distances = 150.5 / (rows + 0.5 - 150)  # at which these rows see the floor, 1 m below
    near = distances[(distances > 1.05) & (distances < 3)]  # farther away a row covers too much
    assert len(near) == 4
    assert np.allclose(near * 2, np.round(near * 2), atol=0.06)  # squares are half a metre wide


def test_drawables_move_with_their_body():
    renderer = Renderer([wall(1.0, 0.2, body=1)], 2)
    for shift in (0.0, 0.4, -0.3):
        poses = np.stack([np.eye(4), fr.on_floor(1.0, shift, 0.0)])
        picture = renderer.render(Camera(101, 101, 90, 1), AT_ORIGIN, poses)
        columns = np.nonzero(picture.segmentation)[1]
        assert columns.mean() == pytest.approx(50 - 50.5 * shift / 2, abs=0.6)


def test_invalid_arguments_are_refused():
    with pytest.raises(ValueError, match="bodies are numbered from 0 to 0"):
        Renderer([wall(1.0, body=1)], 1)
    with pytest.raises(ValueError, match="give float64"):
        Renderer([wall(1.0)], 1).render(Camera(), AT_ORIGIN, np.zeros((2, 4, 4)))
    with pytest.raises(ValueError, match="there is no texture 'velvet'"):
        Renderer([wall(1.0, texture="velvet")], 1)
