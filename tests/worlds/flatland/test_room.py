"""worlds/flatland/room.py: start situations are valid, and moving objects follow their paths."""

from __future__ import annotations

import colorsys
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sensory_commutativity.worlds.flatland.agent import N_LINKS, Polyphemus
from sensory_commutativity.worlds.flatland.control import TIME
from sensory_commutativity.worlds.flatland.room import (
    FIXED,
    MOVABLE,
    MOVING,
    PlacementError,
    Room,
    Situation,
    path_length,
    path_point,
    sample_situation,
)
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import EMPTY, FLATLAND_PAIRS, make_flatland, reset_world


def sample(seed: int, room: Room | None = None, agent: Polyphemus | None = None) -> Situation:
    return sample_situation(room or Room(), agent or Polyphemus(), np.random.default_rng(seed))


def distance_to_segment(point, a, b) -> float:
    t = np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return float(np.hypot(*(point - a - t * (b - a))))


def arm_segments(agent: Polyphemus, links: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    half = agent.arm_length / 2
    along = [half * np.array([math.cos(link[2]), math.sin(link[2])]) for link in links[1:]]
    return [(link[:2] - d, link[:2] + d) for link, d in zip(links[1:], along, strict=True)]


def footprints(s: Situation) -> tuple[np.ndarray, np.ndarray]:
    """Centre (n, 2) and radius (n,) of the disc that each object never leaves by itself."""
    centres, radii = s.pose[:, :2].copy(), s.radius.copy()
    for i in np.flatnonzero(s.corners):
        centres[i] = s.path[i, : s.corners[i]].mean(axis=0)
        radii[i] += np.hypot(*(s.path[i, 0] - centres[i]))
    return centres, radii


# ---- start situations ----------------------------------------------------------------------------


def assert_nothing_touches(s: Situation, room: Room, agent: Polyphemus) -> None:
    segments = arm_segments(agent, s.links)
    centres, radii = footprints(s)
    for i in range(s.n_objects):
        assert np.hypot(*(centres[i] - s.links[0, :2])) > radii[i] + agent.base_radius
        arm_distance = min(distance_to_segment(centres[i], a, b) for a, b in segments)
        assert arm_distance > radii[i] + agent.arm_width / 2
        for j in range(i):
            assert np.hypot(*(centres[i] - centres[j])) > radii[i] + radii[j]
    if room.walls:
        low, size = room.wall_thickness / 2, np.array([room.width, room.height])
        points = np.concatenate([np.reshape(segments, (-1, 2)), s.links[:1, :2], centres])
        reach = np.array([agent.arm_width / 2] * 8 + [agent.base_radius, *radii])[:, None]
        assert (points > low + reach).all() and (points < size - low - reach).all()
        assert (s.links[0, :2] >= room.start_margin).all()
        assert (s.links[0, :2] <= size - room.start_margin).all()


def test_nothing_touches_at_the_start():
    for pair in FLATLAND_PAIRS:
        world = make_flatland(pair)
        for seed in range(15):
            assert_nothing_touches(sample(seed, world.room, world.agent), world.room, world.agent)


def test_situations_are_at_rest():
    world = reset_world(FlatlandWorld(), 3)
    before = world.poses()
    assert not world.snapshot().bodies[:, 3:].any()
    world.play(np.zeros((20, 8)))
    still = np.r_[0:N_LINKS, N_LINKS + np.flatnonzero(world.situation.kind != MOVING)]
    assert np.allclose(world.poses()[still], before[still], atol=1e-9)


def test_start_poses_are_uniform():
    starts = np.array([sample(seed, EMPTY).links[0] for seed in range(1000)])
    for values, low, high in (
        (starts[:, 0], 150, 450),
        (starts[:, 1], 150, 650),
        (starts[:, 2], -math.pi, math.pi),
    ):
        counts, _ = np.histogram(values, 5, (low, high))
        assert counts.sum() == 1000
        assert np.abs(counts - 200).max() < 5 * math.sqrt(200)


def test_situations_are_determined_by_the_generator():
    first, same, different = sample(4), sample(4), sample(5)
    for field in Situation.__dataclass_fields__:
        assert np.array_equal(getattr(first, field), getattr(same, field)), field
    assert not np.array_equal(first.links, different.links)
    assert not np.array_equal(first.pose, different.pose)


def test_larger_numbers_of_objects_keep_the_first_ones():
    for seed in range(5):
        four, eight, twelve = (sample(seed, Room(objects=n)) for n in (4, 8, 12))
        for few, many in ((four, eight), (eight, twelve)):
            for field in ("kind", "vertices", "radius", "pose", "corners", "path", "phase"):
                kept = getattr(many, field)[: few.n_objects]
                assert np.array_equal(getattr(few, field), kept), field
            assert np.array_equal(few.links, many.links)


def test_four_objects_hold_every_kind_and_twelve_every_shape_and_path():
    s = sample(1, Room(objects=12))
    for first in (0, 4, 8):
        kinds = sorted(s.kind[first : first + 4].tolist())
        assert kinds == sorted([FIXED, MOVABLE, MOVABLE, MOVING])
    assert set(s.vertices.tolist()) == {0, 3, 4, 5}
    assert ((s.radius >= 15) & (s.radius <= 30)).all()
    assert sorted(s.corners[s.kind == MOVING].tolist()) == [2, 4, 16]
    assert not s.corners[s.kind != MOVING].any()


def test_colours_differ_and_are_vivid():
    """Hues are a golden ratio apart; colorsys is the reference."""
    for n in (1, 2, 10, 24):
        colours = sample(n, Room(objects=n, walls=False, width=3000.0, height=3000.0)).colour
        assert colours.dtype == np.uint8
        assert len(set(map(tuple, colours.tolist()))) == n
        hsv = np.array([colorsys.rgb_to_hsv(*colour) for colour in colours / 255])
        saturation = np.where(np.arange(n) % 2 == 0, 1.0, 0.6)
        assert (hsv[:, 2] == 1.0).all()
        assert hsv[:, 1] == pytest.approx(saturation, abs=0.01)
        golden = np.full(n - 1, (math.sqrt(5) - 1) / 2)
        assert np.diff(hsv[:, 0]) % 1.0 == pytest.approx(golden, abs=0.005)


def test_full_rooms_are_refused():
    room = Room(width=200.0, height=200.0, objects=10, start_margin=95.0)
    with pytest.raises(PlacementError, match=r"no free place for object \d+ of 10"):
        sample(0, room, Polyphemus(arm_length=20.0))
    room = Room(width=260.0, height=260.0, objects=0, start_margin=40.0)
    with pytest.raises(PlacementError, match="the agent does not fit"):
        sample(0, room, Polyphemus(arm_length=150.0))


# ---- paths ---------------------------------------------------------------------------------------

SQUARE = np.array([(0, 0), (10, 0), (10, 10), (0, 10)] + [(99, 99)] * 12, float)  # 4 corners used


def test_points_of_a_path():
    assert path_length(SQUARE, 4) == 40
    for distance, expected in [
        (0, (0, 0)),
        (5, (5, 0)),
        (10, (10, 0)),
        (12, (10, 2)),
        (25, (5, 10)),
        (39, (0, 1)),
        (40, (0, 0)),
        (52, (10, 2)),
        (-5, (0, 5)),
        (4000015, (10, 5)),
    ]:
        assert path_point(SQUARE, 4, distance) == pytest.approx(expected, abs=1e-6), distance
    assert path_length(SQUARE, 2) == 20  # a line is followed in both directions
    xs = [path_point(SQUARE, 2, d)[0] for d in (0, 4, 10, 14, 20, 24)]
    assert xs == pytest.approx([0, 4, 10, 6, 0, 4])


@given(st.floats(0, 1000), st.floats(0, 3))
def test_points_of_a_path_are_no_farther_apart_than_along_it(distance, step):
    path = np.array([(math.cos(k), math.sin(k)) for k in np.arange(16) * math.pi / 8]) * 30
    first, second = path_point(path, 16, distance), path_point(path, 16, distance + step)
    assert math.dist(first, second) <= step + 1e-9
    assert 30 * math.cos(math.pi / 16) - 1e-9 <= math.hypot(*first) <= 30 + 1e-9


def test_moving_objects_follow_their_paths_without_turning():
    for speed in (0.0, 2.0, 5.5):
        world = reset_world(FlatlandWorld(Room(objects=12, path_speed=speed)), 9)
        s = world.situation
        moving = np.flatnonzero(s.kind == MOVING)
        before = world.poses()[N_LINKS + moving]
        for time in (1, 2, 30, 300):
            world.play(np.zeros((time - int(world.controller_state[TIME]), 8)))
            for i in moving:
                expected = path_point(s.path[i], s.corners[i], s.phase[i] + speed * time)
                assert world.poses()[N_LINKS + i, :2] == pytest.approx(expected, abs=1e-6)
        moved = np.abs(world.poses()[N_LINKS + moving] - before).max()
        assert (moved > 1) == (speed > 0)
        assert np.array_equal(world.poses()[N_LINKS + moving, 2], before[:, 2])
