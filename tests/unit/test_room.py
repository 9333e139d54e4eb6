"""worlds/flatland/room.py: start situations are valid, and paths are followed."""

from __future__ import annotations

import colorsys
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensory_commutativity.helpers import FLATLAND_PAIRS, changed, started

from sensory_commutativity.errors import ConfigError
from sensory_commutativity.studies.flatland.builders import (
    check_rooms,
    flatland_agent,
    flatland_room,
)
from sensory_commutativity.worlds.flatland.agent import N_LINKS, Polyphemus
from sensory_commutativity.worlds.flatland.room import (
    FIXED,
    KIND_NAMES,
    MOVABLE,
    MOVING,
    PlacementError,
    Room,
    Situation,
    draw_situation,
    path_length,
    path_point,
)
from sensory_commutativity.worlds.flatland.world import FlatlandWorld


def draw(seed: int, room: Room | None = None, agent: Polyphemus | None = None) -> Situation:
    return draw_situation(room or Room(), agent or Polyphemus(), np.random.default_rng(seed))


def to_segment(point, a, b) -> float:
    """Distance of a point from the segment a b."""
    t = np.clip((point - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return float(np.hypot(*(point - a - t * (b - a))))


def arm_segments(agent: Polyphemus, links: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    half = agent.arm_length / 2
    along = [half * np.array([math.cos(link[2]), math.sin(link[2])]) for link in links[1:]]
    return [(link[:2] - d, link[:2] + d) for link, d in zip(links[1:], along, strict=True)]


# ---- a situation is valid --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("pair", FLATLAND_PAIRS, ids="/".join)
def test_nothing_touches_at_the_start(pair, default_config):
    world, name = pair
    room, agent = (
        flatland_room(default_config.flatland, world),
        flatland_agent(default_config.flatland, name),
    )
    for seed in range(15):
        s = draw(seed, room, agent)
        segments = arm_segments(agent, s.links)
        reach = [
            s.radius[i] + (np.hypot(*(s.path[i, 0] - middle)) if s.corners[i] else 0.0)
            for i, middle in enumerate(middles(s))
        ]
        for i, middle in enumerate(middles(s)):
            assert np.hypot(*(middle - s.links[0, :2])) > reach[i] + agent.base_radius
            assert (
                min(to_segment(middle, a, b) for a, b in segments) > reach[i] + agent.arm_width / 2
            )
            assert all(
                np.hypot(*(middle - other)) > reach[i] + reach[j]
                for j, other in enumerate(middles(s))
                if j != i
            )
        if room.walls:
            inside = np.array([room.width, room.height]) - room.wall_thickness / 2
            points = np.concatenate([np.reshape(segments, (-1, 2)), s.links[:1, :2]])
            around = np.array([agent.arm_width / 2] * 8 + [agent.base_radius])[:, None]
            assert (points > room.wall_thickness / 2 + around).all() and (
                points < inside - around
            ).all()
            if room.things:
                bounds = np.array(reach)[:, None]
                assert (middles(s) > room.wall_thickness / 2 + bounds).all() and (
                    middles(s) < inside - bounds
                ).all()
            assert (s.links[0, :2] >= room.start_margin).all()
            assert (
                s.links[0, :2] <= [room.width - room.start_margin, room.height - room.start_margin]
            ).all()


def middles(s: Situation) -> np.ndarray:
    """Where each thing is at home: the middle of its path, or where it stands."""
    return np.array(
        [
            s.path[i, : s.corners[i]].mean(axis=0) if s.corners[i] else s.pose[i, :2]
            for i in range(s.n_things)
        ]
    ).reshape(-1, 2)


def test_starts_at_rest():
    world = started(FlatlandWorld(), 3)
    before = world.poses()
    start = world.snapshot()
    assert not start.bodies[:, 3:].any()
    world.play(np.zeros((20, 8)))
    still = np.r_[0:N_LINKS, N_LINKS + np.flatnonzero(world.situation.kind != MOVING)]
    assert np.allclose(world.poses()[still], before[still], atol=1e-9)


def test_starts_are_spread_over_the_room_and_all_directions():
    starts = np.array([draw(seed, Room(things=0)).links[0] for seed in range(1000)])
    for values, low, high in (
        (starts[:, 0], 150, 450),
        (starts[:, 1], 150, 650),
        (starts[:, 2], -math.pi, math.pi),
    ):
        counts, _ = np.histogram(values, 5, (low, high))
        assert counts.sum() == 1000
        assert np.abs(counts - 200).max() < 5 * math.sqrt(200)


def test_a_situation_follows_from_the_generator():
    one, same, other = draw(4), draw(4), draw(5)
    for field in Situation.__dataclass_fields__:
        assert np.array_equal(getattr(one, field), getattr(same, field))
    assert not np.array_equal(one.links, other.links)
    assert not np.array_equal(one.pose, other.pose)


@pytest.mark.parametrize("seed", range(5))
def test_more_things_are_the_same_things_and_more(seed):
    four, eight, twelve = (draw(seed, Room(things=n)) for n in (4, 8, 12))
    for few, many in ((four, eight), (eight, twelve)):
        n = few.n_things
        for field in ("kind", "vertices", "radius", "pose", "corners", "path", "phase"):
            assert np.array_equal(getattr(few, field), getattr(many, field)[:n]), field
        assert np.array_equal(few.links, many.links)


def test_four_things_hold_every_kind_and_twelve_every_shape():
    s = draw(1, Room(things=12))
    for first in (0, 4, 8):
        kinds = sorted(s.kind[first : first + 4].tolist())
        assert kinds == sorted([FIXED, MOVABLE, MOVABLE, MOVING])
    assert KIND_NAMES == ("fixed", "movable", "moving")
    assert set(s.vertices.tolist()) == {0, 3, 4, 5}
    assert ((s.radius >= 15) & (s.radius <= 30)).all()
    assert (s.corners[s.kind == MOVING] > 0).all() and not s.corners[s.kind != MOVING].any()
    assert sorted(s.corners[s.kind == MOVING].tolist()) == [2, 4, 16]


@pytest.mark.parametrize("n", [1, 2, 10, 24])
def test_colours_differ_and_are_vivid(n):
    for seed in range(5):
        colours = draw(seed, Room(things=n, walls=False, width=3000.0, height=3000.0)).colour
        assert colours.dtype == np.uint8
        assert len(set(map(tuple, colours.tolist()))) == n
        for i, (r, g, b) in enumerate(colours / 255):
            _, saturation, value = colorsys.rgb_to_hsv(r, g, b)
            assert value == 1.0
            assert saturation == pytest.approx(1.0 if i % 2 == 0 else 0.6, abs=0.01)


def test_colours_are_colorsys_s():
    """Worked out for whole arrays; colorsys is the reference. The first hue is unknown, the step to the next one is the golden ratio's."""
    colours = draw(3, Room(things=8)).colour / 255
    hues = [colorsys.rgb_to_hsv(*colour)[0] for colour in colours]
    steps = np.diff(hues) % 1.0
    assert steps == pytest.approx(np.full(7, (math.sqrt(5) - 1) / 2), abs=0.005)


@pytest.mark.parametrize(
    ("room", "agent", "says"),
    [
        (
            Room(width=200.0, height=200.0, things=10, start_margin=95.0),
            Polyphemus(arm_length=20.0),
            "no free place for thing",
        ),
        (
            Room(width=260.0, height=260.0, things=0, start_margin=40.0),
            Polyphemus(arm_length=150.0),
            "the agent does not fit",
        ),
    ],
)
def test_a_room_that_is_too_full_says_so(room, agent, says):
    with pytest.raises(PlacementError, match=says):
        draw(0, room, agent)


def test_check_rooms_names_what_does_not_fit(default_config):
    check_rooms(default_config)
    full = changed(
        default_config, worlds={"things-8": {"objects": 24, "width": 320.0, "height": 320.0}}
    )
    with pytest.raises(
        ConfigError, match=r"flatland\.worlds\.things-8 with flatland\.agents\..*no free place"
    ):
        check_rooms(full)
    narrow = changed(
        default_config,
        worlds={"things-0": {"width": 305.0, "height": 305.0}},
        agents={"long-arms": {"arm_length": 150.0}},
    )
    with pytest.raises(
        ConfigError, match=r"things-0 with flatland\.agents\.long-arms: the agent does not fit"
    ):
        check_rooms(narrow)


# ---- paths -----------------------------------------------------------------------------------------------------------------

SQUARE = np.array(
    [(0, 0), (10, 0), (10, 10), (0, 10)] + [(99, 99)] * 12, float
)  # the rest is never looked at


@pytest.mark.parametrize(
    ("distance", "expected"),
    [
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
    ],
)
def test_points_of_a_square(distance, expected):
    assert path_point(SQUARE, 4, distance) == pytest.approx(expected, abs=1e-6)
    assert path_length(SQUARE, 4) == 40


def test_a_line_goes_there_and_back():
    assert path_length(SQUARE, 2) == 20
    assert [path_point(SQUARE, 2, d)[0] for d in (0, 4, 10, 14, 20, 24)] == pytest.approx(
        [0, 4, 10, 6, 0, 4]
    )


@given(st.floats(0, 1000), st.floats(0, 3))
def test_points_of_a_path_are_no_farther_apart_than_along_it(distance, step):
    path = np.array([(math.cos(k), math.sin(k)) for k in np.arange(16) * math.pi / 8]) * 30
    here, there = path_point(path, 16, distance), path_point(path, 16, distance + step)
    assert math.dist(here, there) <= step + 1e-9
    assert 30 * math.cos(math.pi / 16) - 1e-9 <= math.hypot(*here) <= 30 + 1e-9


@pytest.mark.parametrize("speed", [0.0, 2.0, 5.5])
def test_moving_things_follow_their_paths(speed):
    world = started(FlatlandWorld(Room(things=12, path_speed=speed)), 9)
    s = world.situation
    moving = np.flatnonzero(s.kind == MOVING)
    before = world.poses()[N_LINKS + moving]
    for time in (1, 2, 30, 300):
        world.play(np.zeros((time - int(world.inner[9]), 8)))
        for i in moving:
            expected = path_point(s.path[i], s.corners[i], s.phase[i] + speed * time)
            assert world.poses()[N_LINKS + i, :2] == pytest.approx(expected, abs=1e-6)
    moved = np.abs(world.poses()[N_LINKS + moving] - before).max()
    assert (moved > 1) == (speed > 0)
    assert np.array_equal(world.poses()[N_LINKS + moving, 2], before[:, 2])  # without turning
