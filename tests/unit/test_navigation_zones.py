"""Zones in the world and in many rooms: seen, not felt, and refine_masks as Gymnasium's own vector environment judges them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from sensory_commutativity.helpers import DOFS, drive, full_speed, standing

from sensory_commutativity.navigation.task import (
    DEAD_COLOUR,
    GOAL_COLOUR,
    NavigationEnv,
    NavigationVectorEnv,
    Zone,
    room_with_zones,
    touched,
)
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import FIXED, Mark, Room, Situation, draw_situation
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

ROOM = Room(things=5, width=500.0, height=500.0, start_margin=80.0)
ZONES = (Zone(90.0, 90.0, 60.0, -20.0), Zone(400.0, 250.0, 70.0, 50.0))
FAST = Polyphemus(longitudinal_speed=15.0)
STILL = np.zeros(len(DOFS), np.float32)
BLUE = (10, 20, 200)
MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP]


def facing(zones, things=(), agent: Polyphemus | None = None, eyelid: float = 0.0) -> np.ndarray:
    """What the agent at (100, 250) sees of zones and things when it looks along x."""
    agent = agent or Polyphemus()
    world = FlatlandWorld(replace(room_with_zones(ROOM, tuple(zones)), things=len(things)), agent)
    world.enter(standing(agent, 100.0, 250.0, 0.0, things))
    if eyelid:
        world.play(drive("eyelid", np.sign(eyelid), round(abs(eyelid) / agent.eyelid_speed)))
    return world.observe()


def pixels(view: np.ndarray, colour) -> list[int]:
    return np.flatnonzero((view == colour).all(axis=1)).tolist()


# ---- touching --------------------------------------------------------------------------------------------------------------


def test_touching_is_exact_in_every_direction():
    zone = (
        Zone(0.0, 0.0, 30.0, 1.0),
    )  # with a base of radius 35, at 65: 5-12-13, 3-4-5 and 16-63-65 triangles
    on = np.array([(25.0, 60.0), (-39.0, 52.0), (16.0, -63.0), (-65.0, 0.0)])
    assert (touched(zone, on, 35.0) == 0).all()
    assert (touched(zone, on * (1 + 1e-12), 35.0) == -1).all()


def test_the_first_touched_zone_counts_for_each_base_on_its_own():
    zones = (Zone(0.0, 0.0, 10.0, -1.0), Zone(30.0, 0.0, 10.0, -1.0), Zone(15.0, 0.0, 20.0, 1.0))
    base = np.array([(0.0, 0.0), (30.0, 0.0), (15.0, 0.0), (15.0, 24.0), (200.0, 0.0)])
    found = touched(zones, base, 5.0)
    assert found.tolist() == [0, 1, 0, 2, -1] and found.dtype == np.int64
    assert touched(zones[::-1], base, 5.0).tolist() == [0, 0, 0, 0, -1]


def test_what_a_step_gives_has_gymnasiums_types():
    environment = NavigationEnv(replace(ROOM, things=0), ZONES, FAST, 2)
    environment.reset(seed=0)
    environment.world.enter(standing(FAST, 400.0, 250.0, 0.0))
    _, reward, terminated, truncated, info = environment.step(STILL)
    assert (reward, terminated, truncated, info) == (50.0, True, False, {"is_success": True})
    assert (
        type(reward) is float
        and type(terminated) is type(truncated) is type(info["is_success"]) is bool
    )


def test_every_episode_has_its_full_time():
    environment = NavigationEnv(replace(ROOM, things=0), ZONES, FAST, 4)
    for seed in (3, None, 3):
        environment.reset(seed=seed)
        assert [environment.step(STILL)[3] for _ in range(4)] == [False, False, False, True]


def test_a_zone_that_is_reached_when_time_is_up_pays():
    environment = NavigationEnv(replace(ROOM, things=0), ZONES, FAST, 1)
    environment.reset(seed=0)
    environment.world.enter(standing(FAST, 90.0, 90.0, 0.0))
    assert environment.step(STILL)[1:] == (-20.0, True, False, {"is_success": False})


# ---- in the world ----------------------------------------------------------------------------------------------------------


def test_zones_are_seen_as_discs():
    """100 units away, of radius 50: 30 degrees either side, 21 of the 1.4-degree pixels."""
    assert pixels(facing([Zone(200.0, 250.0, 50.0, 1.0)]), GOAL_COLOUR) == list(range(11, 53))
    assert pixels(facing([Zone(200.0, 250.0, 50.0, -1.0)]), DEAD_COLOUR) == list(range(11, 53))
    assert pixels(
        facing([Zone(200.0, 250.0, 50.0, 0.0)]), DEAD_COLOUR
    )  # what is no goal looks dead


@pytest.mark.parametrize(("eyelid", "factor"), [(-0.5, 0.5), (0.0, 1.0), (0.5, 1.5)])
def test_zones_are_seen_through_the_eyelid(eyelid, factor):
    view = facing([Zone(200.0, 250.0, 50.0, 1.0)], eyelid=eyelid)[11:53].astype(float)
    assert np.abs(view - np.minimum(255, np.array(GOAL_COLOUR) * factor)).max() <= 1


def thing(x: float, radius: float) -> dict:
    return {"vertices": 0, "radius": radius, "pose": (x, 250.0, 0.0), "colour": BLUE, "kind": FIXED}


def test_of_things_and_zones_the_nearer_hides_the_other():
    zone = Zone(250.0, 250.0, 50.0, 1.0)
    before = facing([zone], [thing(170.0, 8.0)])
    assert tuple(before[31]) == tuple(before[32]) == BLUE
    assert len(pixels(before, BLUE)) < len(pixels(before, GOAL_COLOUR))
    behind = facing([zone], [thing(350.0, 8.0)])
    assert not pixels(behind, BLUE) and pixels(behind, GOAL_COLOUR) == pixels(
        facing([zone]), GOAL_COLOUR
    )
    wider = facing([zone], [thing(400.0, 120.0)])  # seen on both sides of the zone
    assert (
        min(pixels(wider, BLUE))
        < min(pixels(wider, GOAL_COLOUR))
        <= max(pixels(wider, GOAL_COLOUR))
        < max(pixels(wider, BLUE))
    )


def test_of_two_zones_the_nearer_hides_the_other_whatever_their_order():
    near, far = Zone(200.0, 250.0, 20.0, -1.0), Zone(350.0, 250.0, 90.0, 1.0)
    assert np.array_equal(facing([near, far]), facing([far, near]))
    view = facing([near, far])
    assert tuple(view[32]) == DEAD_COLOUR and GOAL_COLOUR in {tuple(view[20]), tuple(view[44])}


def test_the_arms_hide_zones():
    ahead = Polyphemus(
        shoulder_rest=0.0, elbow_rest=0.0
    )  # both arms straight ahead: 12.7 degrees either side are free
    alone, behind_arms = (
        pixels(facing([Zone(360.0, 250.0, 150.0, 1.0)], agent=agent), GOAL_COLOUR)
        for agent in (Polyphemus(), ahead)
    )
    assert len(alone) == 50 and behind_arms == list(range(23, 41))


def test_every_mark_has_its_own_colour_and_place():
    colours = [(1, 2, 3), (4, 5, 6), (7, 8, 9)]
    marks = tuple(
        Mark(200.0, 250.0 + 60.0 * (i - 1), 15.0, colour) for i, colour in enumerate(colours)
    )
    world = FlatlandWorld(replace(ROOM, things=0, marks=marks))
    world.enter(standing(Polyphemus(), 100.0, 250.0, 0.0))
    view = world.observe()
    order = [min(pixels(view, colour)) for colour in colours]
    assert order == sorted(order)  # from right to left


@pytest.mark.parametrize("seed", range(4))
def test_zones_change_nothing_but_what_is_seen(seed):
    zones = (Zone(250.0, 250.0, 120.0, 1.0), Zone(50.0, 400.0, 50.0, -1.0))
    bare, marked = FlatlandWorld(ROOM, FAST), FlatlandWorld(room_with_zones(ROOM, zones), FAST)
    bare.reset(np.random.default_rng(seed))
    marked.enter(bare.situation)
    actions = full_speed(np.random.default_rng(seed), 80, len(DOFS))
    for world in (bare, marked):
        world.play(actions)
    assert np.array_equal(bare.poses(), marked.poses())


def test_marks_survive_a_snapshot():
    world = FlatlandWorld(room_with_zones(ROOM, ZONES), FAST)
    world.reset(np.random.default_rng(0))
    kept, view = world.snapshot(), world.observe()
    world.play(full_speed(np.random.default_rng(1), 30, len(DOFS)))
    world.restore(kept)
    assert np.array_equal(world.observe(), view)


def test_no_zones_are_no_marks():
    assert Room().marks == ()


def test_a_task_without_zones_is_none():
    with pytest.raises(ValueError, match="at least one zone"):
        room_with_zones(ROOM, ())


def test_a_mark_where_nobody_starts_changes_no_draw():
    corner = (Zone(20.0, 20.0, 15.0, 1.0),)
    for seed in range(10):
        one, other = (
            draw_situation(room, FAST, np.random.default_rng(seed))
            for room in (ROOM, room_with_zones(ROOM, corner))
        )
        for field in Situation.__dataclass_fields__:
            assert np.array_equal(getattr(one, field), getattr(other, field)), field


def test_a_start_in_a_zone_is_drawn_again_and_only_then():
    free = [draw_situation(ROOM, FAST, np.random.default_rng(seed)).links for seed in range(60)]
    kept = [
        draw_situation(room_with_zones(ROOM, ZONES), FAST, np.random.default_rng(seed)).links
        for seed in range(60)
    ]
    reach = np.array([zone.radius for zone in ZONES]) + FAST.base_radius + ROOM.clearance
    inside = [
        (np.hypot(*(np.array([(z.x, z.y) for z in ZONES]) - links[0, :2]).T) <= reach).any()
        for links in free
    ]
    assert [not np.array_equal(a, b) for a, b in zip(free, kept, strict=True)] == inside
    assert 5 < sum(inside) < 55


# ---- many rooms ------------------------------------------------------------------------------------------------------------


def rooms_and_reference(mode, agent: Polyphemus | None, limit: int = 25, n: int = 4):
    ours = NavigationVectorEnv(n, ROOM, ZONES, agent, limit, mode)
    return ours, SyncVectorEnv(
        [lambda: NavigationEnv(ROOM, ZONES, agent, limit)] * n, autoreset_mode=mode
    )


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    "agent", [None, Polyphemus(longitudinal_speed=20.0, base_radius=45.0)], ids=["default", "stout"]
)
def test_gymnasiums_own_vector_environment_gives_the_same(mode, agent):
    ours, theirs = rooms_and_reference(mode, agent)
    assert np.array_equal(ours.reset(seed=7)[0], theirs.reset(seed=7)[0])
    rng, ends = np.random.default_rng(0), np.zeros(2, int)
    for _ in range(100):
        actions = np.repeat(rng.uniform(-1, 1, (1, 8)), 4, 0).astype(np.float32)
        actions[:, 0] = 1
        actions[:, 1] *= 0.3
        found, expected = ours.step(actions), theirs.step(actions)
        for a, b in zip(found[:4], expected[:4], strict=True):
            assert np.array_equal(a, b) and a.dtype == b.dtype
        ends += found[2].sum(), found[3].sum()
        if mode == AutoresetMode.SAME_STEP and (found[2] | found[3]).any():
            assert np.array_equal(found[4]["_final_obs"], expected[4]["_final_obs"])
            assert np.array_equal(found[4]["_final_info"], expected[4]["_final_info"])
            last, told = found[4]["final_info"], expected[4]["final_info"]
            assert np.array_equal(last["is_success"], told["is_success"]) and np.array_equal(
                last["_is_success"], told["_is_success"]
            )
            for a, b in zip(found[4]["final_obs"], expected[4]["final_obs"], strict=True):
                assert (a is None and b is None) or np.array_equal(a, b)
        else:
            assert "final_obs" not in found[4] and "final_obs" not in expected[4]
            assert ("is_success" in found[4]) == ("is_success" in expected[4])
            if "is_success" in found[4]:
                for key in ("is_success", "_is_success"):
                    assert np.array_equal(found[4][key], expected[4][key])
    assert ends.min() > 3  # of both kinds
    assert np.array_equal(ours.reset()[0], theirs.reset()[0])
    assert np.array_equal(ours.reset(seed=[5, 1, 2, 9])[0], theirs.reset(seed=[5, 1, 2, 9])[0])


@pytest.mark.parametrize("mode", MODES)
def test_a_reset_in_the_middle_starts_all_clocks_anew(mode):
    ours, theirs = rooms_and_reference(mode, FAST, limit=6)
    for environment in (ours, theirs):
        environment.reset(seed=1)
        for _ in range(4):
            environment.step(np.zeros((4, 8), np.float32))
        environment.reset(seed=2)
    ended = [
        [environment.step(np.zeros((4, 8), np.float32))[3].tolist() for _ in range(6)]
        for environment in (ours, theirs)
    ]
    assert ended[0] == ended[1] == [[False] * 4] * 5 + [[True] * 4]


@pytest.mark.parametrize("mode", MODES)
def test_a_zone_at_the_last_step_terminates_and_does_not_truncate(mode):
    """Rooms whose agents drive on into a zone, with just as many steps as one of them needs."""
    long, _ = rooms_and_reference(mode, FAST, limit=40, n=12)
    long.reset(seed=0)
    forward = np.eye(8, dtype=np.float32)[[0] * 12]
    first = next(k for k in range(1, 41) if long.step(forward)[2].any())
    short, reference = rooms_and_reference(mode, FAST, limit=first, n=12)
    for environment in (short, reference):
        environment.reset(seed=0)
    for _ in range(first):
        found, expected = short.step(forward), reference.step(forward)
        assert all(np.array_equal(a, b) for a, b in zip(found[:4], expected[:4], strict=True))
    assert found[2].any() and found[3].any() and (found[2] ^ found[3]).all()


class Bliss(FlatlandVectorEnv):
    """A task whose every step pays and is the last."""

    def _judge(self):
        return np.ones(self.num_envs), np.ones(self.num_envs, bool)


@pytest.mark.parametrize(
    ("mode", "expected"),
    [(AutoresetMode.NEXT_STEP, [1, 0, 1, 0]), (AutoresetMode.SAME_STEP, [1, 1, 1, 1])],
)
def test_a_step_that_only_resets_pays_nothing_and_ends_nothing(mode, expected):
    environment = Bliss(2, ROOM, FAST, 10, mode)
    environment.reset(seed=0)
    for paid in expected:
        _, rewards, terminated, truncated, _ = environment.step(np.zeros((2, 8), np.float32))
        assert (
            rewards.tolist() == [paid] * 2
            and terminated.tolist() == [bool(paid)] * 2
            and not truncated.any()
        )


def test_what_a_step_gave_is_not_overwritten_by_the_next():
    ours, _ = rooms_and_reference(AutoresetMode.SAME_STEP, FAST, limit=2)
    first, _ = ours.reset(seed=0)
    kept = [first, *(part for _ in range(2) for part in ours.step(np.ones((4, 8), np.float32))[:4])]
    final = ours.step(np.ones((4, 8), np.float32)), ours.step(-np.ones((4, 8), np.float32))
    last = [seen.copy() for seen in final[1][4]["final_obs"]]
    copies = [part.copy() for part in kept]
    for _ in range(5):
        ours.step(np.ones((4, 8), np.float32))
    assert all(np.array_equal(a, b) for a, b in zip(kept, copies, strict=True))
    assert all(np.array_equal(a, b) for a, b in zip(final[1][4]["final_obs"], last, strict=True))


def test_modes_that_do_not_reset_are_refused():
    with pytest.raises(ValueError, match="NEXT_STEP or SAME_STEP"):
        NavigationVectorEnv(2, ROOM, ZONES, FAST, 10, AutoresetMode.DISABLED)


@pytest.mark.parametrize("mode", MODES)
def test_the_mode_is_told(mode):
    assert NavigationVectorEnv(2, ROOM, ZONES, FAST, 10, mode).metadata["autoreset_mode"] is mode
