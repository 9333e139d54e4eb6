"""worlds/flatland/eye.py: known answers, and every pixel against a second ray caster that knows nothing of the first."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sensory_commutativity.helpers import FREE_SPACE, enter

from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.control import EYELID, HEAD
from sensory_commutativity.worlds.flatland.eye import Scene, look, ray_directions
from sensory_commutativity.worlds.flatland.room import WALL_COLOURS, Room
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

QUARTER = math.pi / 2
BOX = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)


def seen(
    things=(),
    eye=(0.0, 0.0, 0.0),
    eyelid=1.0,
    pixels=64,
    field_of_view=QUARTER,
    view_range=1000.0,
    walls=(),
) -> np.ndarray:
    """What is seen of discs (pose, radius, colour) and of polygons (pose, corners, colour)."""
    n = len(things)
    outlines, vertices, radius = np.zeros((n, 5, 2)), np.zeros(n, np.int64), np.zeros(n)
    for i, (_, shape, _) in enumerate(things):
        if np.ndim(shape):
            vertices[i], radius[i] = len(shape), np.hypot(*np.transpose(shape)).max()
            outlines[i, : len(shape)] = shape
        else:
            radius[i] = shape
    scene = Scene(
        ray_directions(pixels, field_of_view), field_of_view, view_range, outlines, vertices, radius,
        np.array([colour for *_, colour in things], np.uint8).reshape(n, 3),
        np.array([ends for ends, _ in walls], float).reshape(-1, 4), np.array([colour for _, colour in walls], np.uint8).reshape(-1, 3),
    )  # fmt: skip
    out = np.full((pixels, 3), 99, np.uint8)
    look(scene, eye, eyelid, np.array([pose for pose, *_ in things], float).reshape(n, 3), out)
    return out


RED, GREEN = (200, 50, 10), (10, 220, 30)


def lit(view: np.ndarray) -> list[int]:
    return np.flatnonzero(view.any(axis=1)).tolist()


# ---- rays ------------------------------------------------------------------------------------------------------------------


def test_rays_by_hand():
    """Two pixels of 90 degrees look 22.5 degrees to the right and to the left."""
    angle = math.radians(22.5)
    assert ray_directions(2, QUARTER) == pytest.approx(
        np.array([[math.cos(angle), -math.sin(angle)], [math.cos(angle), math.sin(angle)]])
    )
    assert ray_directions(1, 3.0) == pytest.approx(np.array([[1.0, 0.0]]))


@pytest.mark.parametrize(("pixels", "field_of_view"), [(64, QUARTER), (7, 6.0), (128, 0.3)])
def test_rays_are_evenly_spread(pixels, field_of_view):
    rays = ray_directions(pixels, field_of_view)
    assert rays.shape == (pixels, 2)
    assert np.hypot(*rays.T) == pytest.approx(np.ones(pixels))
    angles = np.arctan2(rays[:, 1], rays[:, 0])
    assert np.diff(angles) == pytest.approx(np.full(pixels - 1, field_of_view / pixels))
    assert angles + angles[::-1] == pytest.approx(np.zeros(pixels), abs=1e-12)


# ---- one disc --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("distance", "radius", "pixels"),
    [
        (100.0, 50.0, 42),  # 30 degrees either side, 21.3 pixels of 1.40625 degrees: 21
        (100.0, 100 * math.sin(math.radians(10)), 14),  # 10 degrees: 7.1 pixels
        (500.0, 1.0, 0),  # 0.11 degrees: the two middle rays, 0.70 degrees aside, miss it
        (500.0, 6.3, 2),  # 0.72 degrees
        (60.0, 59.0, 64),  # 79 degrees: all
    ],
)
def test_a_disc_straight_ahead(distance, radius, pixels):
    view = seen([((distance, 0, 0), radius, RED)])
    middle = list(range(32 - pixels // 2, 32 + pixels // 2))
    assert lit(view) == middle
    assert (view[middle] == RED).all()


def test_pixels_go_from_right_to_left():
    view = seen([((100, 50, 0), 10.0, RED), ((100, -50, 0), 10.0, GREEN)])
    assert (view[:32] == RED).all(axis=1).sum() == 0 < (view[32:] == RED).all(axis=1).sum()
    assert (view[32:] == GREEN).all(axis=1).sum() == 0 < (view[:32] == GREEN).all(axis=1).sum()
    assert np.array_equal(lit(view), sorted(63 - k for k in lit(view)))


@pytest.mark.parametrize("pose", [(-100, 0, 0), (0, 100, 0), (0, -100, 0), (30, 80, 0)])
def test_what_is_beside_or_behind_is_not_seen(pose):
    assert not seen([(pose, 20.0, RED)]).any()


@pytest.mark.parametrize(
    ("view_range", "pixels"),
    [
        (49.9, 0),  # the nearest point is 50 away
        (50.1, "fewer"),
        (1000.0, 42),
        (87.0, 42),  # the tangents touch it sqrt(100**2 - 50**2) = 86.6 away
        (70.0, "fewer"),  # the outermost rays hit it 74 away
    ],
)
def test_beyond_the_view_range_all_is_black(view_range, pixels):
    found = lit(seen([((100, 0, 0), 50.0, RED)], view_range=view_range))
    if isinstance(pixels, int):
        assert len(found) == pixels
    else:
        angles = math.radians(90 / 64) * (np.array(found) - 31.5)
        depth = 100 * np.cos(angles) - np.sqrt(50**2 - (100 * np.sin(angles)) ** 2)
        assert 0 < len(found) < 42
        assert (depth < view_range).all()


def test_where_the_eye_stands_and_looks_does_not_matter():
    here = seen([((100, 20, 0), 15.0, RED)])
    turned = seen([((7 - 20, 3 + 100, 0), 15.0, RED)], eye=(7.0, 3.0, math.pi / 2))
    round_and_round = seen([((100, 20, 0), 15.0, RED)], eye=(0.0, 0.0, 8 * math.pi))
    assert lit(here)
    assert np.array_equal(here, turned)
    assert np.array_equal(here, round_and_round)


# ---- the eyelid ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("eyelid", "colour"),
    [
        (0.0, (0, 0, 0)),
        (0.5, (100, 25, 5)),
        (1.0, RED),
        (1.25, (250, 63, 13)),
        (2.0, (255, 100, 20)),
        (0.001, (0, 0, 0)),
        (0.05, (10, 3, 1)),
    ],
)
def test_the_eyelid_multiplies_rounds_and_clips(eyelid, colour):
    assert seen([((100, 0, 0), 50.0, RED)], eyelid=eyelid)[32].tolist() == list(colour)


def test_nothing_stays_black_through_an_open_eye():
    assert not seen([], eyelid=2.0).any()


# ---- boxes, walls, and what hides what -------------------------------------------------------------------------------------


@pytest.mark.parametrize("turned", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_a_box_straight_ahead(turned):
    """Its front is 80 away and 20 either way: 14.04 degrees, 9.98 pixels of 1.40625: ten rays would need 9.5 of them."""
    view = seen([((100, 0, turned), 20 * BOX, RED)])
    assert lit(view) == list(range(22, 42))


def test_a_box_from_its_corner():
    """Turned by 45 degrees its corners are 20 sqrt 2 aside, 100 away: 15.8 degrees, 11.2 pixels."""
    assert lit(seen([((100, 0, math.pi / 4), 20 * BOX, RED)])) == list(range(21, 43))


def test_what_is_nearer_hides_what_is_farther():
    near, far = ((100, 0, 0), 10.0, RED), ((200, 0, 0), 60.0, GREEN)
    view = seen([near, far])
    assert np.array_equal(view, seen([far, near]))
    red, green = (view == RED).all(axis=1), (view == GREEN).all(axis=1)
    assert red.sum() == 8 and red[28:36].all()  # 5.7 degrees either side: 4.08 pixels
    assert green.sum() == 24 - 8  # 17.5 degrees: 12.4 pixels, less those that the near one covers
    box = ((100, 0, 0), 10 * BOX, RED)
    assert (seen([far, box])[32] == RED).all()


def test_a_wall_hides_what_is_behind_it():
    wall = ((50.0, 500.0, 50.0, -500.0), GREEN)  # its left end first, as seen from here
    assert (seen([((100, 0, 0), 40.0, RED)], walls=[wall]) == GREEN).all()
    assert (seen([((45, 0, 0), 4.0, RED)], walls=[wall])[32] == RED).all()


def test_a_wall_has_ends():
    view = seen(walls=[((100.0, 0.0, 100.0, -500.0), GREEN)])
    assert lit(view) == list(range(32))


def test_an_eye_inside_sees_through():
    assert not seen([((1, 0, 0), 10.0, RED)]).any()
    assert not seen([((1, 0, 0), 10 * BOX, RED)]).any()


@pytest.mark.parametrize("field_of_view", [3.0, 3.5, 6.28])
def test_wide_eyes_see_behind(field_of_view):
    view = seen(
        [((-100, 1, 0), 30.0, RED), ((100, 0, 0), 10.0, GREEN)], field_of_view=field_of_view
    )
    behind = math.pi - math.asin(0.3) < field_of_view / 2
    assert (view == RED).all(axis=1).any() == behind
    assert (view[32] == GREEN).all()


# ---- a second ray caster ---------------------------------------------------------------------------------------------------


def cast(world: FlatlandWorld) -> np.ndarray:
    """The view of `world`, worked out from poses, shapes and colours alone.

    Walls as infinite lines, discs by their quadratic equation, polygons as intersections of half-planes; a ray that starts inside a thing does not
    see it.
    """
    agent, room, situation = world.agent, world.room, world.situation
    poses, inner = world.poses(), world.inner
    x, y = poses[0, :2]
    angles = (
        poses[0, 2]
        + inner[HEAD]
        + agent.field_of_view * ((np.arange(agent.pixels) + 0.5) / agent.pixels - 0.5)
    )
    ray = np.stack([np.cos(angles), np.sin(angles)], 1)
    depth, view = np.full(agent.pixels, agent.view_range), np.zeros((agent.pixels, 3))

    def paint(distance, colour):
        nearer = (distance >= 0) & (distance < depth)
        depth[nearer], view[nearer] = distance[nearer], colour

    def paint_polygon(pose, corners, colour):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        corners = corners @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
        enter, leave = np.full(agent.pixels, -np.inf), np.full(agent.pixels, np.inf)
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            outward = np.array([b[1] - a[1], a[0] - b[0]])
            slope = ray @ outward
            t = (a - (x, y)) @ outward / np.where(slope == 0, np.nan, slope)
            enter, leave = (
                np.where(slope < 0, np.fmax(enter, t), enter),
                np.where(slope > 0, np.fmin(leave, t), leave),
            )
        paint(np.where(enter <= leave, enter, -1), colour)

    for (axis, at, sign), colour in zip(
        [(1, 0, -1), (0, room.width, 1), (1, room.height, 1), (0, 0, -1)], WALL_COLOURS, strict=True
    ):
        towards = (
            ray[:, axis] * sign > 0
        )  # seen even where they are not solid; the agent stays inside
        paint(
            np.where(towards, (at - (x, y)[axis]) / np.where(towards, ray[:, axis], 1.0), -1),
            colour,
        )
    half_length, half_width = agent.arm_length / 2, agent.arm_width / 2
    for link, grey in zip(poses[1:5], (255, 200, 255, 200), strict=True):
        paint_polygon(link, BOX * (half_length, half_width), (grey, grey, grey))
    for i, pose in enumerate(poses[5:]):
        radius, corners = situation.radius[i], situation.vertices[i]
        if corners:
            spokes = 2 * math.pi * np.arange(corners) / corners
            paint_polygon(
                pose, radius * np.stack([np.cos(spokes), np.sin(spokes)], 1), situation.colour[i]
            )
        else:
            to = pose[:2] - (x, y)
            along = ray @ to
            within = along**2 - to @ to + radius**2
            paint(
                np.where(within >= 0, along - np.sqrt(np.maximum(within, 0)), -1),
                situation.colour[i],
            )
    return np.minimum(255, np.floor(view * inner[EYELID] + 0.5)).astype(np.uint8)


ROOMS = {
    "furnished": (Room(), Polyphemus()),
    "crowded": (Room(things=16), Polyphemus(arm_length=30.0)),
    "unbounded": (Room(things=8, walls=False), Polyphemus(arm_length=80.0)),
    "short-sighted": (Room(things=12), Polyphemus(view_range=150.0)),
    "all-round": (Room(things=6), Polyphemus(field_of_view=6.0, pixels=101)),
}


@pytest.mark.parametrize("kind", ROOMS)
def test_every_pixel_against_a_second_ray_caster(kind):
    world, colours = FlatlandWorld(*ROOMS[kind]), set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        for steps in (0, 15, 50):
            world.play(rng.uniform(-1, 1, (steps, 8)))
            view = world.observe()
            assert np.array_equal(view, cast(world))
            colours |= set(map(tuple, view))
    assert len(colours) > 100  # there was something to see


def test_the_arms_are_seen_and_the_body_is_not():
    world = enter(FREE_SPACE, 300, 400, 0.0)
    walls = {tuple(colour) for colour in WALL_COLOURS.tolist()}
    world.play(np.tile([0, 0, 0, 0, -1.0, 0, -1.0, 0], (3, 1)))  # arms to the front
    view = world.observe()
    assert set(map(tuple, view.tolist())) - walls == {(255, 255, 255), (200, 200, 200)}
    world.play(
        np.tile([0, 0, 1.0, 0, 0, 0, 0, 0], (12, 1))
    )  # looking back: only its own body could hide the painted walls there
    assert set(map(tuple, world.observe().tolist())) <= walls


def test_walls_that_are_not_solid_are_seen_as_solid_ones_are():
    solid, painted = enter(Room(things=0), 300, 400, 0.3), enter(FREE_SPACE, 300, 400, 0.3)
    assert np.array_equal(solid.observe(), painted.observe())
