"""The navigation task: zones, rewards and ends of episodes, in one environment and in many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from sensory_commutativity.navigation.task import (
    DEAD_COLOUR,
    GOAL_COLOUR,
    NavigationEnv,
    NavigationTask,
    NavigationVectorEnv,
    RewardZone,
    find_touched_zones,
    room_with_zones,
)
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import (
    FIXED,
    FloorZone,
    Room,
    Situation,
    sample_situation,
)
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import DOFS, drive, make_situation, sample_held_commands

ROOM = Room(objects=5, width=500.0, height=500.0, start_margin=80.0)
EMPTY_ROOM = replace(ROOM, objects=0)
DEAD, GOAL = RewardZone(90.0, 90.0, 60.0, -20.0), RewardZone(400.0, 250.0, 70.0, 50.0)
ZONES = (DEAD, GOAL)
FAST = Polyphemus(longitudinal_speed=15.0)
STILL = np.zeros(len(DOFS), np.float32)
FORWARD = np.eye(len(DOFS), dtype=np.float32)[0]
BLUE = (10, 20, 200)
MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP]


def env_at(x: float, y: float, max_episode_steps: int = 50) -> NavigationEnv:
    """An environment without objects; the agent is at (x, y) and looks along the x axis."""
    env = NavigationEnv(EMPTY_ROOM, ZONES, FAST, max_episode_steps)
    env.reset(seed=0)
    env.world.enter(make_situation(FAST, x, y, 0.0))
    return env


def view_of(zones, objects=(), agent: Polyphemus | None = None, eyelid: float = 0.0) -> np.ndarray:
    """What the agent sees at (100, 250) when it looks along the x axis."""
    agent = agent or Polyphemus()
    world = FlatlandWorld(replace(room_with_zones(ROOM, tuple(zones)), objects=len(objects)), agent)
    world.enter(make_situation(agent, 100.0, 250.0, 0.0, objects))
    if eyelid:
        world.play(drive("eyelid", np.sign(eyelid), round(abs(eyelid) / agent.eyelid_speed)))
    return world.observe()


def pixels(view: np.ndarray, colour) -> list[int]:
    return np.flatnonzero((view == colour).all(axis=1)).tolist()


# ---- touching ------------------------------------------------------------------------------------


def test_a_zone_is_touched_when_its_edge_meets_the_base_in_every_direction():
    zone = (RewardZone(0.0, 0.0, 30.0, 1.0),)
    # 65 units away, with a base of radius 35: 5-12-13, 3-4-5 and 16-63-65 triangles
    base = np.array([(25.0, 60.0), (-39.0, 52.0), (16.0, -63.0), (-65.0, 0.0)])
    assert (find_touched_zones(zone, base, 35.0) == 0).all()
    assert (find_touched_zones(zone, base * (1 + 1e-12), 35.0) == -1).all()


def test_the_first_touched_zone_counts_for_each_base():
    zones = tuple(RewardZone(x, 0.0, radius, 1.0) for x, radius in ((0, 10), (30, 10), (15, 20)))
    base = np.array([(0.0, 0.0), (30.0, 0.0), (15.0, 0.0), (15.0, 24.0), (200.0, 0.0)])
    touched = find_touched_zones(zones, base, 5.0)
    assert touched.tolist() == [0, 1, 0, 2, -1] and touched.dtype == np.int64
    assert find_touched_zones(zones[::-1], base, 5.0).tolist() == [0, 0, 0, 0, -1]


# ---- episodes ------------------------------------------------------------------------------------


def test_driving_into_the_goal_ends_the_episode_with_its_reward():
    env = env_at(220.0, 250.0)
    for _ in range(5):  # 85 units to go, 15 per step
        assert env.step(FORWARD)[1:] == (0.0, False, False, {})
    _, reward, terminated, truncated, info = env.step(FORWARD)
    assert (reward, terminated, truncated, info) == (50.0, True, False, {"is_success": True})
    types = {type(value) for value in (terminated, truncated, info["is_success"])}
    assert type(reward) is float and types == {bool}


def test_a_dead_zone_is_no_success():
    assert env_at(60.0, 60.0).step(STILL)[1:] == (-20.0, True, False, {"is_success": False})


def test_every_episode_is_truncated_after_its_full_time():
    env = env_at(220.0, 400.0, max_episode_steps=4)
    for seed in (3, None, 3):
        env.reset(seed=seed)
        steps = [env.step(STILL)[1:] for _ in range(4)]
        assert steps[:3] == [(0.0, False, False, {})] * 3
        assert steps[3] == (0.0, False, True, {"is_success": False})


def test_a_zone_touched_in_the_last_step_terminates_the_episode():
    assert env_at(90.0, 90.0, 1).step(STILL)[1:] == (-20.0, True, False, {"is_success": False})


def test_a_task_creates_its_environments():
    task = NavigationTask(ROOM, ZONES, FAST, 7)
    single, vector = task.make_env("rgb_array"), task.make_vector_env(2)
    assert (single.zones, single.max_episode_steps, single.render_mode) == (ZONES, 7, "rgb_array")
    assert single.world.agent == FAST and vector.num_envs == 2 and vector.max_episode_steps == 7
    assert vector.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    with pytest.raises(ValueError, match="at least one zone"):
        NavigationTask(ROOM, ()).make_env()


# ---- starts --------------------------------------------------------------------------------------


def test_no_episode_starts_in_a_zone_or_touching_it():
    large = (RewardZone(150.0, 150.0, 90.0, 1.0), RewardZone(340.0, 340.0, 80.0, -1.0))
    env = NavigationEnv(EMPTY_ROOM, large, FAST)
    for seed in range(200):
        env.reset(seed=seed)
        base = env.world.poses()[:1, :2]
        assert find_touched_zones(large, base, FAST.base_radius)[0] == -1


def test_a_start_in_a_zone_is_drawn_again_and_no_other():
    marked = room_with_zones(ROOM, ZONES)
    rngs = [np.random.default_rng(seed) for seed in range(60)]
    without = [sample_situation(ROOM, FAST, rng).links for rng in rngs]
    rngs = [np.random.default_rng(seed) for seed in range(60)]
    with_zones = [sample_situation(marked, FAST, rng).links for rng in rngs]
    reach = np.array([zone.radius for zone in ZONES]) + FAST.base_radius + ROOM.clearance
    centres = np.array([(zone.x, zone.y) for zone in ZONES])
    inside = [(np.hypot(*(centres - links[0, :2]).T) <= reach).any() for links in without]
    redrawn = [not np.array_equal(a, b) for a, b in zip(without, with_zones, strict=True)]
    assert redrawn == inside and 5 < sum(inside) < 55


def test_a_zone_where_no_agent_starts_changes_no_situation():
    marked = room_with_zones(ROOM, (RewardZone(20.0, 20.0, 15.0, 1.0),))
    for seed in range(10):
        a, b = (
            sample_situation(room, FAST, np.random.default_rng(seed)) for room in (ROOM, marked)
        )
        for field in Situation.__dataclass_fields__:
            assert np.array_equal(getattr(a, field), getattr(b, field)), field


# ---- appearance ----------------------------------------------------------------------------------


def test_zones_are_seen_as_discs():
    """100 units away, with a radius of 50: 30 degrees to either side, 21 pixels of 1.4 degrees."""
    for reward, colour in ((1.0, GOAL_COLOUR), (-1.0, DEAD_COLOUR), (0.0, DEAD_COLOUR)):
        view = view_of([RewardZone(200.0, 250.0, 50.0, reward)])
        assert pixels(view, colour) == list(range(11, 53)), reward


def test_zones_are_seen_through_the_eyelid():
    for eyelid, factor in ((-0.5, 0.5), (0.0, 1.0), (0.5, 1.5)):
        view = view_of([RewardZone(200.0, 250.0, 50.0, 1.0)], eyelid=eyelid)[11:53].astype(float)
        assert np.abs(view - np.minimum(255, np.array(GOAL_COLOUR) * factor)).max() <= 1, eyelid


def test_objects_and_zones_hide_what_is_behind_them():
    def disc(x: float, radius: float) -> dict:
        pose = (x, 250.0, 0.0)
        return dict(vertices=0, radius=radius, pose=pose, colour=BLUE, kind=FIXED)

    zone = RewardZone(250.0, 250.0, 50.0, 1.0)
    before = view_of([zone], [disc(170.0, 8.0)])
    assert tuple(before[31]) == tuple(before[32]) == BLUE
    assert len(pixels(before, BLUE)) < len(pixels(before, GOAL_COLOUR))
    behind = view_of([zone], [disc(350.0, 8.0)])
    assert not pixels(behind, BLUE)
    assert pixels(behind, GOAL_COLOUR) == pixels(view_of([zone]), GOAL_COLOUR)
    wider = view_of([zone], [disc(400.0, 120.0)])  # seen on both sides of the zone
    blue, green = pixels(wider, BLUE), pixels(wider, GOAL_COLOUR)
    assert min(blue) < min(green) <= max(green) < max(blue)


def test_a_nearer_zone_hides_a_farther_one_in_any_order():
    near, far = RewardZone(200.0, 250.0, 20.0, -1.0), RewardZone(350.0, 250.0, 90.0, 1.0)
    view = view_of([near, far])
    assert np.array_equal(view, view_of([far, near]))
    assert tuple(view[32]) == DEAD_COLOUR and GOAL_COLOUR in {tuple(view[20]), tuple(view[44])}


def test_the_arms_hide_zones():
    straight = Polyphemus(shoulder_rest=0.0, elbow_rest=0.0)  # leaves 12.7 degrees to either side
    zone = RewardZone(360.0, 250.0, 150.0, 1.0)
    assert len(pixels(view_of([zone]), GOAL_COLOUR)) == 50
    assert pixels(view_of([zone], agent=straight), GOAL_COLOUR) == list(range(23, 41))


def test_every_zone_has_its_own_colour_and_position():
    colours = [(1, 2, 3), (4, 5, 6), (7, 8, 9)]
    floor_zones = tuple(
        FloorZone(200.0, 250.0 + 60.0 * (i - 1), 15.0, colour) for i, colour in enumerate(colours)
    )
    world = FlatlandWorld(replace(EMPTY_ROOM, zones=floor_zones))
    world.enter(make_situation(Polyphemus(), 100.0, 250.0, 0.0))
    view = world.observe()
    order = [min(pixels(view, colour)) for colour in colours]
    assert order == sorted(order)  # from right to left


def test_zones_change_no_motion():
    zones = (RewardZone(250.0, 250.0, 120.0, 1.0), RewardZone(50.0, 400.0, 50.0, -1.0))
    for seed in range(4):
        bare = FlatlandWorld(ROOM, FAST)
        marked = FlatlandWorld(room_with_zones(ROOM, zones), FAST)
        bare.reset(np.random.default_rng(seed))
        marked.enter(bare.situation)
        actions = sample_held_commands(np.random.default_rng(seed), 80, len(DOFS))
        for world in (bare, marked):
            world.play(actions)
        assert np.array_equal(bare.poses(), marked.poses()), seed


def test_zones_survive_a_snapshot():
    world = FlatlandWorld(room_with_zones(ROOM, ZONES), FAST)
    world.reset(np.random.default_rng(0))
    snapshot, view = world.snapshot(), world.observe()
    world.play(sample_held_commands(np.random.default_rng(1), 30, len(DOFS)))
    world.restore(snapshot)
    assert np.array_equal(world.observe(), view)


# ---- vector environments -------------------------------------------------------------------------


def vector_and_reference(mode, agent: Polyphemus | None, limit: int = 25, n: int = 4):
    """The vector environment, and Gymnasium's own one with the same single environments."""
    vector = NavigationVectorEnv(n, ROOM, ZONES, agent, limit, mode)
    singles = [lambda: NavigationEnv(ROOM, ZONES, agent, limit)] * n
    return vector, SyncVectorEnv(singles, autoreset_mode=mode)


def assert_equal_infos(infos: dict, expected: dict, same_step_end: bool) -> None:
    if not same_step_end:
        assert "final_obs" not in infos and "final_obs" not in expected
        assert ("is_success" in infos) == ("is_success" in expected)
        for key in ("is_success", "_is_success") if "is_success" in infos else ():
            assert np.array_equal(infos[key], expected[key])
        return
    for key in ("_final_obs", "_final_info"):
        assert np.array_equal(infos[key], expected[key])
    for key in ("is_success", "_is_success"):
        assert np.array_equal(infos["final_info"][key], expected["final_info"][key])
    for a, b in zip(infos["final_obs"], expected["final_obs"], strict=True):
        assert (a is None and b is None) or np.array_equal(a, b)


@pytest.mark.parametrize("mode", MODES)
def test_gymnasiums_own_vector_environment_gives_the_same(mode):
    for agent in (None, Polyphemus(longitudinal_speed=20.0, base_radius=45.0)):
        vector, reference = vector_and_reference(mode, agent)
        assert vector.metadata["autoreset_mode"] is mode
        assert np.array_equal(vector.reset(seed=7)[0], reference.reset(seed=7)[0])
        rng, ends = np.random.default_rng(0), np.zeros(2, int)
        for _ in range(100):
            actions = np.repeat(rng.uniform(-1, 1, (1, 8)), 4, 0).astype(np.float32)
            actions[:, 0] = 1
            actions[:, 1] *= 0.3
            result, expected = vector.step(actions), reference.step(actions)
            for a, b in zip(result[:4], expected[:4], strict=True):
                assert np.array_equal(a, b) and a.dtype == b.dtype
            ends += result[2].sum(), result[3].sum()
            ended = (result[2] | result[3]).any()
            assert_equal_infos(result[4], expected[4], ended and mode == AutoresetMode.SAME_STEP)
        assert ends.min() > 3  # terminated and truncated
        for seed in (None, [5, 1, 2, 9]):
            assert np.array_equal(vector.reset(seed=seed)[0], reference.reset(seed=seed)[0])


def test_a_reset_in_the_middle_restarts_all_clocks():
    for mode in MODES:
        truncations = []
        for env in vector_and_reference(mode, FAST, limit=6):
            env.reset(seed=1)
            for _ in range(4):
                env.step(np.zeros((4, 8), np.float32))
            env.reset(seed=2)
            truncations.append(
                [env.step(np.zeros((4, 8), np.float32))[3].tolist() for _ in range(6)]
            )
        assert truncations[0] == truncations[1] == [[False] * 4] * 5 + [[True] * 4], mode


def test_a_zone_in_the_last_step_terminates_and_does_not_truncate():
    """Agents drive ahead; the time limit is the step in which the first of them meets a zone."""
    forward = np.tile(FORWARD, (12, 1))
    for mode in MODES:
        long, _ = vector_and_reference(mode, FAST, limit=40, n=12)
        long.reset(seed=0)
        limit = next(k for k in range(1, 41) if long.step(forward)[2].any())
        short, reference = vector_and_reference(mode, FAST, limit=limit, n=12)
        for env in (short, reference):
            env.reset(seed=0)
        for _ in range(limit):
            result, expected = short.step(forward), reference.step(forward)
            assert all(np.array_equal(a, b) for a, b in zip(result[:4], expected[:4], strict=True))
        assert result[2].any() and result[3].any() and (result[2] ^ result[3]).all(), mode


class OneStepEpisodes(FlatlandVectorEnv):
    """A task in which every step pays 1 and ends the episode."""

    def _rewards_and_terminations(self):
        return np.ones(self.num_envs), np.ones(self.num_envs, bool)


def test_a_step_that_only_resets_pays_nothing_and_ends_nothing():
    for mode, expected in zip(MODES, ([1, 0, 1, 0], [1, 1, 1, 1]), strict=True):
        env = OneStepEpisodes(2, ROOM, FAST, 10, mode)
        env.reset(seed=0)
        for reward in expected:
            _, rewards, terminated, truncated, _ = env.step(np.zeros((2, 8), np.float32))
            assert rewards.tolist() == [reward] * 2 and not truncated.any(), mode
            assert terminated.tolist() == [bool(reward)] * 2, mode


def test_results_of_a_step_are_not_overwritten_by_later_steps():
    env, _ = vector_and_reference(AutoresetMode.SAME_STEP, FAST, limit=2)
    ahead = np.ones((4, 8), np.float32)
    arrays = [env.reset(seed=0)[0]]
    for actions in (ahead, ahead, ahead, -ahead):
        *results, infos = env.step(actions)
        arrays += results
    arrays += list(infos["final_obs"])
    copies = [array.copy() for array in arrays]
    for _ in range(5):
        env.step(ahead)
    assert all(np.array_equal(a, b) for a, b in zip(arrays, copies, strict=True))


def test_unsupported_autoreset_modes_are_rejected():
    with pytest.raises(ValueError, match="NEXT_STEP or SAME_STEP"):
        NavigationVectorEnv(2, ROOM, ZONES, FAST, 10, AutoresetMode.DISABLED)
