"""worlds/flatland/eye.py: known answers, and every pixel against an independent ray caster."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.control import EYELID, HEAD
from sensory_commutativity.worlds.flatland.eye import Scene, ray_directions, render
from sensory_commutativity.worlds.flatland.room import WALL_COLOURS, Room
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import EMPTY, FREE_SPACE, make_world

QUARTER_TURN = math.pi / 2
BOX = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
RED, GREEN = (200, 50, 10), (10, 220, 30)


def view_of(
    objects=(),
    eye=(0.0, 0.0, 0.0),
    eyelid=1.0,
    pixels=64,
    field_of_view=QUARTER_TURN,
    view_range=1000.0,
    walls=(),
) -> np.ndarray:
    """Render discs (pose, radius, colour), polygons (pose, corners, colour) and walls."""
    n = len(objects)
    outlines, vertices, radius = np.zeros((n, 5, 2)), np.zeros(n, np.int64), np.zeros(n)
    for i, (_, shape, _) in enumerate(objects):
        if np.ndim(shape):
            vertices[i], radius[i] = len(shape), np.hypot(*np.transpose(shape)).max()
            outlines[i, : len(shape)] = shape
        else:
            radius[i] = shape
    scene = Scene(
        ray_directions(pixels, field_of_view), field_of_view, view_range,
        outlines, vertices, radius,
        np.array([colour for *_, colour in objects], np.uint8).reshape(n, 3),
        np.array([ends for ends, _ in walls], float).reshape(-1, 4),
        np.array([colour for _, colour in walls], np.uint8).reshape(-1, 3),
    )  # fmt: skip
    out = np.full((pixels, 3), 99, np.uint8)
    poses = np.array([pose for pose, *_ in objects], float).reshape(n, 3)
    render(scene, eye, eyelid, poses, out)
    return out


def lit(view: np.ndarray) -> list[int]:
    return np.flatnonzero(view.any(axis=1)).tolist()


def middle(n: int) -> list[int]:
    """Indices of the `n` middle pixels of 64."""
    return list(range(32 - n // 2, 32 + n // 2))


# ---- rays ----------------------------------------------------------------------------------------


def test_rays_are_evenly_spread_from_right_to_left():
    angle = math.radians(22.5)
    expected = [[math.cos(angle), -math.sin(angle)], [math.cos(angle), math.sin(angle)]]
    assert ray_directions(2, QUARTER_TURN) == pytest.approx(np.array(expected))
    assert ray_directions(1, 3.0) == pytest.approx(np.array([[1.0, 0.0]]))
    for pixels, field_of_view in [(64, QUARTER_TURN), (7, 6.0), (128, 0.3)]:
        rays = ray_directions(pixels, field_of_view)
        assert rays.shape == (pixels, 2)
        assert np.hypot(*rays.T) == pytest.approx(np.ones(pixels))
        angles = np.arctan2(rays[:, 1], rays[:, 0])
        assert np.diff(angles) == pytest.approx(np.full(pixels - 1, field_of_view / pixels))
        assert angles + angles[::-1] == pytest.approx(np.zeros(pixels), abs=1e-12)


# ---- discs ---------------------------------------------------------------------------------------


def test_disc_straight_ahead():
    """A pixel covers 1.40625 degrees; the comments give half the angle of the disc."""
    for distance, radius, pixels in [
        (100.0, 50.0, 42),  # 30 degrees, 21.3 pixels
        (100.0, 100 * math.sin(math.radians(10)), 14),  # 10 degrees, 7.1 pixels
        (500.0, 1.0, 0),  # 0.11 degrees: passes between the two middle rays at 0.70 degrees
        (500.0, 6.3, 2),  # 0.72 degrees
        (60.0, 59.0, 64),  # 79 degrees: all
    ]:
        view = view_of([((distance, 0, 0), radius, RED)])
        assert lit(view) == middle(pixels), (distance, radius)
        assert (view[middle(pixels)] == RED).all()


def test_pixels_go_from_right_to_left():
    view = view_of([((100, 50, 0), 10.0, RED), ((100, -50, 0), 10.0, GREEN)])
    assert (view[:32] == RED).all(axis=1).sum() == 0 < (view[32:] == RED).all(axis=1).sum()
    assert (view[32:] == GREEN).all(axis=1).sum() == 0 < (view[:32] == GREEN).all(axis=1).sum()
    assert lit(view) == sorted(63 - k for k in lit(view))


def test_objects_outside_the_field_of_view_are_invisible():
    for pose in [(-100, 0, 0), (0, 100, 0), (0, -100, 0), (30, 80, 0)]:
        assert not view_of([(pose, 20.0, RED)]).any(), pose


def test_objects_beyond_the_view_range_are_black():
    """The nearest point is 50 away, the outermost rays hit at 74, the tangents touch at 86.6."""
    disc = [((100, 0, 0), 50.0, RED)]
    assert len(lit(view_of(disc, view_range=49.9))) == 0
    for view_range in (87.0, 1000.0):
        assert len(lit(view_of(disc, view_range=view_range))) == 42
    for view_range in (50.1, 70.0):
        pixels = lit(view_of(disc, view_range=view_range))
        angles = math.radians(90 / 64) * (np.array(pixels) - 31.5)
        depth = 100 * np.cos(angles) - np.sqrt(50**2 - (100 * np.sin(angles)) ** 2)
        assert 0 < len(pixels) < 42 and (depth < view_range).all(), view_range


def test_view_depends_on_relative_poses_only():
    view = view_of([((100, 20, 0), 15.0, RED)])
    turned = view_of([((7 - 20, 3 + 100, 0), 15.0, RED)], eye=(7.0, 3.0, math.pi / 2))
    full_turns = view_of([((100, 20, 0), 15.0, RED)], eye=(0.0, 0.0, 8 * math.pi))
    assert lit(view)
    assert np.array_equal(view, turned) and np.array_equal(view, full_turns)


# ---- the eyelid ----------------------------------------------------------------------------------


def test_eyelid_multiplies_rounds_and_clips():
    for eyelid, colour in [
        (0.0, (0, 0, 0)),
        (0.001, (0, 0, 0)),
        (0.05, (10, 3, 1)),
        (0.5, (100, 25, 5)),
        (1.0, RED),
        (1.25, (250, 63, 13)),
        (2.0, (255, 100, 20)),
    ]:
        view = view_of([((100, 0, 0), 50.0, RED)], eyelid=eyelid)
        assert view[32].tolist() == list(colour), eyelid
    assert not view_of([], eyelid=2.0).any()  # nothing stays black


# ---- polygons, walls and occlusion ---------------------------------------------------------------


def test_box_straight_ahead_and_from_its_corner():
    for turn in [0.0, math.pi / 2, math.pi, -math.pi / 2]:
        # the front is 80 away and 20 wide on either side: 14.04 degrees, 9.98 pixels
        assert lit(view_of([((100, 0, turn), 20 * BOX, RED)])) == middle(20), turn
    # the corners are 100 away and 20 sqrt 2 aside: 15.8 degrees, 11.2 pixels
    assert lit(view_of([((100, 0, math.pi / 4), 20 * BOX, RED)])) == middle(22)


def test_near_objects_hide_far_ones():
    near, far = ((100, 0, 0), 10.0, RED), ((200, 0, 0), 60.0, GREEN)
    view = view_of([near, far])
    assert np.array_equal(view, view_of([far, near]))
    red, green = (view == RED).all(axis=1), (view == GREEN).all(axis=1)
    assert np.flatnonzero(red).tolist() == middle(8)  # 5.7 degrees on either side, 4.08 pixels
    assert green.sum() == 24 - 8  # 17.5 degrees, 12.4 pixels, less those of the near one
    box = ((100, 0, 0), 10 * BOX, RED)
    assert (view_of([far, box])[32] == RED).all()


def test_walls_hide_what_is_behind_them_and_have_ends():
    wall = ((50.0, 500.0, 50.0, -500.0), GREEN)  # left end first, as seen from the origin
    assert (view_of([((100, 0, 0), 40.0, RED)], walls=[wall]) == GREEN).all()
    assert (view_of([((45, 0, 0), 4.0, RED)], walls=[wall])[32] == RED).all()
    assert lit(view_of(walls=[((100.0, 0.0, 100.0, -500.0), GREEN)])) == list(range(32))


def test_objects_are_invisible_from_inside():
    assert not view_of([((1, 0, 0), 10.0, RED)]).any()
    assert not view_of([((1, 0, 0), 10 * BOX, RED)]).any()


def test_wide_fields_of_view_include_what_is_behind():
    objects = [((-100, 1, 0), 30.0, RED), ((100, 0, 0), 10.0, GREEN)]
    for field_of_view in (3.0, 3.5, 6.28):
        view = view_of(objects, field_of_view=field_of_view)
        is_behind_visible = math.pi - math.asin(0.3) < field_of_view / 2
        assert (view == RED).all(axis=1).any() == is_behind_visible, field_of_view
        assert (view[32] == GREEN).all()


# ---- an independent ray caster -------------------------------------------------------------------


def cast_independently(world: FlatlandWorld) -> np.ndarray:
    """Render the view of `world` from poses, shapes and colours, by other methods.

    Walls are infinite lines, discs quadratic equations, polygons intersections of half-planes. A
    ray that starts inside an object does not see it.
    """
    agent, room, situation = world.agent, world.room, world.situation
    poses, state = world.poses(), world.controller_state
    x, y = poses[0, :2]
    offsets = (np.arange(agent.pixels) + 0.5) / agent.pixels - 0.5
    angles = poses[0, 2] + state[HEAD] + agent.field_of_view * offsets
    rays = np.stack([np.cos(angles), np.sin(angles)], 1)
    depth, view = np.full(agent.pixels, agent.view_range), np.zeros((agent.pixels, 3))

    def paint(distance, colour):
        nearer = (distance >= 0) & (distance < depth)
        depth[nearer], view[nearer] = distance[nearer], colour

    def paint_polygon(pose, corners, colour):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        corners = corners @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
        entry, exit_ = np.full(agent.pixels, -np.inf), np.full(agent.pixels, np.inf)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            outward = np.array([b[1] - a[1], a[0] - b[0]])
            slope = rays @ outward
            t = (a - (x, y)) @ outward / np.where(slope == 0, np.nan, slope)
            entry = np.where(slope < 0, np.fmax(entry, t), entry)
            exit_ = np.where(slope > 0, np.fmin(exit_, t), exit_)
        paint(np.where(entry <= exit_, entry, -1), colour)

    lines = [(1, 0, -1), (0, room.width, 1), (1, room.height, 1), (0, 0, -1)]
    for (axis, position, sign), colour in zip(lines, WALL_COLOURS, strict=True):
        towards = rays[:, axis] * sign > 0  # visible even if not solid; the agent stays inside
        distance = (position - (x, y)[axis]) / np.where(towards, rays[:, axis], 1.0)
        paint(np.where(towards, distance, -1), colour)
    half_length, half_width = agent.arm_length / 2, agent.arm_width / 2
    for link, grey in zip(poses[1:5], (255, 200, 255, 200), strict=True):
        paint_polygon(link, BOX * (half_length, half_width), (grey, grey, grey))
    for i, pose in enumerate(poses[5:]):
        radius, vertices = situation.radius[i], situation.vertices[i]
        if vertices:
            spokes = 2 * math.pi * np.arange(vertices) / vertices
            corners = radius * np.stack([np.cos(spokes), np.sin(spokes)], 1)
            paint_polygon(pose, corners, situation.colour[i])
        else:
            to_disc = pose[:2] - (x, y)
            along = rays @ to_disc
            discriminant = along**2 - to_disc @ to_disc + radius**2
            distance = along - np.sqrt(np.maximum(discriminant, 0))
            paint(np.where(discriminant >= 0, distance, -1), situation.colour[i])
    return np.minimum(255, np.floor(view * state[EYELID] + 0.5)).astype(np.uint8)


@pytest.mark.parametrize(
    ("room", "agent"),
    [
        (Room(), Polyphemus()),
        (Room(objects=16), Polyphemus(arm_length=30.0)),
        (Room(objects=8, walls=False), Polyphemus(arm_length=80.0)),
        (Room(objects=12), Polyphemus(view_range=150.0)),
        (Room(objects=6), Polyphemus(field_of_view=6.0, pixels=101)),
    ],
    ids=["standard", "crowded", "unbounded", "short-sighted", "all-round"],
)
def test_every_pixel_against_an_independent_ray_caster(room, agent):
    world, colours = FlatlandWorld(room, agent), set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        for steps in (0, 15, 50):
            world.play(rng.uniform(-1, 1, (steps, 8)))
            view = world.observe()
            assert np.array_equal(view, cast_independently(world)), (seed, steps)
            colours |= set(map(tuple, view))
    assert len(colours) > 100  # the views are not empty


def test_arms_are_visible_and_the_base_is_not():
    world = make_world(FREE_SPACE, 300, 400, 0.0)
    walls = {tuple(colour) for colour in WALL_COLOURS.tolist()}
    world.play(np.tile([0, 0, 0, 0, -1.0, 0, -1.0, 0], (3, 1)))  # arms to the front
    view = world.observe()
    assert set(map(tuple, view.tolist())) - walls == {(255, 255, 255), (200, 200, 200)}
    world.play(np.tile([0, 0, 1.0, 0, 0, 0, 0, 0], (12, 1)))  # look back, over the base
    assert set(map(tuple, world.observe().tolist())) <= walls


def test_walls_look_the_same_whether_solid_or_not():
    solid, painted = (make_world(room, 300, 400, 0.3) for room in (EMPTY, FREE_SPACE))
    assert np.array_equal(solid.observe(), painted.observe())
