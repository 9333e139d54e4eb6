"""The navigation task: zones, rewards, ends of episodes, one room and many, and the form that Stable-Baselines3 wants."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from sensory_commutativity.helpers import full_speed, standing

from sensory_commutativity.navigation.rooms import Rooms
from sensory_commutativity.navigation.task import (
    DEAD_COLOUR,
    GOAL_COLOUR,
    NavigationEnv,
    NavigationVectorEnv,
    Zone,
    room_with_zones,
    touched,
)
from sensory_commutativity.studies.navigation.builders import navigation_environment, task_parts
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import Room, draw_situation
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

ROOM = Room(things=0, width=400.0, height=400.0, start_margin=60.0)
GOAL, DEAD = Zone(300.0, 200.0, 40.0, 50.0), Zone(60.0, 60.0, 30.0, -20.0)
ZONES = (DEAD, GOAL)
FAST = Polyphemus(longitudinal_speed=15.0)
FORWARD = np.eye(8, dtype=np.float32)[0]
STILL = np.zeros(8, np.float32)


def env_at(x: float, y: float, heading: float = 0.0, steps: int = 50, zones=ZONES) -> NavigationEnv:
    environment = NavigationEnv(ROOM, zones, FAST, steps)
    environment.reset(seed=0)
    environment.world.enter(standing(FAST, x, y, heading))
    return environment


def test_a_zone_is_touched_when_its_edge_meets_the_base():
    base = np.array([[300.0, 265.0], [300.0, 265.01], [235.0, 200.0], [0.0, 399.0]])
    assert touched(ZONES, base, 25.0).tolist() == [1, -1, 1, -1]


def test_of_two_touched_zones_the_first_counts():
    assert touched(
        (GOAL, Zone(300.0, 200.0, 90.0, -20.0)), np.array([[300.0, 200.0]]), 1.0
    ).tolist() == [0]


def test_driving_into_the_goal_ends_the_episode_with_its_reward():
    environment = env_at(150.0, 200.0)
    for _ in range(5):  # 85 units to go, 15 in a step
        assert environment.step(FORWARD)[1:] == (0.0, False, False, {})
    _, reward, terminated, truncated, info = environment.step(FORWARD)
    assert (reward, terminated, truncated, info) == (50.0, True, False, {"is_success": True})


def test_a_dead_zone_is_no_success():
    environment = env_at(60.0, 60.0)
    _, reward, terminated, _, info = environment.step(STILL)
    assert (reward, terminated, info) == (-20.0, True, {"is_success": False})


def test_time_truncates_and_a_zone_at_the_last_step_terminates():
    environment = env_at(150.0, 330.0, steps=3)
    assert [environment.step(STILL)[2:] for _ in range(3)] == [(False, False, {})] * 2 + [
        (False, True, {"is_success": False})
    ]
    environment = env_at(150.0, 200.0, steps=6)
    *_, (_, _, terminated, truncated, _) = [environment.step(FORWARD) for _ in range(6)]
    assert terminated and not truncated


def test_no_episode_starts_in_a_zone_or_touching_it():
    large = (Zone(120.0, 120.0, 90.0, 1.0), Zone(290.0, 290.0, 80.0, -1.0))
    environment = NavigationEnv(ROOM, large, FAST)
    for seed in range(200):
        environment.reset(seed=seed)
        assert touched(large, environment.world.poses()[:1, :2], FAST.base_radius)[0] == -1


def test_zones_are_seen_in_their_colours_and_hide_what_is_behind():
    environment = env_at(150.0, 200.0)
    middle = environment.world.observe()[32]
    assert tuple(middle) == GOAL_COLOUR
    assert tuple(env_at(150.0, 60.0, np.pi).world.observe()[32]) == DEAD_COLOUR
    hidden = env_at(150.0, 200.0, zones=(GOAL, Zone(220.0, 200.0, 10.0, -1.0)))
    assert tuple(hidden.world.observe()[32]) == DEAD_COLOUR


def test_zones_are_not_solid():
    marked, bare = FlatlandWorld(room_with_zones(ROOM, ZONES), FAST), FlatlandWorld(ROOM, FAST)
    for world in (marked, bare):
        world.enter(standing(FAST, 150.0, 200.0, 0.0))
        world.play(np.tile(FORWARD, (12, 1)))
    assert marked.poses()[0, 0] > 320
    assert np.array_equal(marked.poses(), bare.poses())


def test_a_room_without_marks_draws_what_it_drew_before():
    far = (Zone(5000.0, 5000.0, 1.0, 1.0),)
    with_mark = draw_situation(room_with_zones(ROOM, far), FAST, np.random.default_rng(3))
    assert np.array_equal(
        with_mark.links, draw_situation(ROOM, FAST, np.random.default_rng(3)).links
    )


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_many_rooms_give_what_single_ones_give_bit_for_bit(mode):
    n, steps, limit = 5, 90, 25
    many = NavigationVectorEnv(n, ROOM, ZONES, FAST, limit, mode)
    singles = [NavigationEnv(ROOM, ZONES, FAST, limit) for _ in range(n)]
    seeds = [10 * i + 1 for i in range(n)]
    seen, _ = many.reset(seed=seeds)
    assert np.array_equal(
        seen, [single.reset(seed=seed)[0] for single, seed in zip(singles, seeds, strict=True)]
    )
    rng, ended, ends = np.random.default_rng(0), np.zeros(n, bool), 0
    for _ in range(steps):
        actions = full_speed(rng, n, 8).astype(np.float32) * rng.uniform(0, 1, (n, 1)).astype(
            np.float32
        )
        seen, rewards, terminated, truncated, infos = many.step(actions)
        for r, single in enumerate(singles):
            if ended[r]:  # NEXT_STEP: this step resets
                expected = (single.reset()[0], 0.0, False, False)
            else:
                expected = single.step(actions[r])[:4]
            if mode == AutoresetMode.SAME_STEP and (expected[2] or expected[3]):
                assert infos["_final_obs"][r] and np.array_equal(infos["final_obs"][r], expected[0])
                expected = (single.reset()[0], *expected[1:])
            assert np.array_equal(seen[r], expected[0])
            assert (rewards[r], terminated[r], truncated[r]) == expected[1:]
        ends += int((terminated | truncated).sum())
        ended = (terminated | truncated) & (mode == AutoresetMode.NEXT_STEP)
    assert ends > 2 * n


def test_gymnasium_finds_no_fault(default_config):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(navigation_environment(default_config), skip_render_check=True)


def test_the_configured_task_is_the_papers(default_config):
    room, zones, agent = task_parts(default_config)
    assert room.width == room.height and room.things == 0 and agent.longitudinal_speed == 15
    assert sorted(zone.reward for zone in zones) == [-20, -20, -20, 50]


# ---- for Stable-Baselines3 -------------------------------------------------------------------------------------------------


def test_an_ended_room_tells_its_last_observation_and_why_it_ended():
    vector = NavigationVectorEnv(3, ROOM, ZONES, FAST, 4, AutoresetMode.SAME_STEP)
    rooms = Rooms(vector, reward_scale=0.1)
    rooms.seed(5)
    first = rooms.reset()
    assert first.shape == (3, 64, 3) and first.dtype == np.uint8
    vector._worlds[1].enter(standing(FAST, 300.0, 200.0, 0.0))  # into the goal
    parts = vector._worlds[1].parts()
    vector._spaces[1] = parts.wiring.space
    for stack, one, names in vector._stacks(parts):
        for name in names:
            getattr(stack, name)[1] = getattr(one, name)
    observations, rewards, ended, infos = rooms.step(np.zeros((3, 8), np.float32))
    assert ended.tolist() == [False, True, False] and rewards.dtype == np.float32
    assert rewards.tolist() == pytest.approx([0.0, 5.0, 0.0])
    assert infos[1]["TimeLimit.truncated"] is False and infos[0] == {}
    for _ in range(2):
        rooms.step(np.zeros((3, 8), np.float32))
    before = vector._seen.copy()
    observations, _, ended, infos = rooms.step(np.zeros((3, 8), np.float32))
    assert ended[0] and infos[0]["TimeLimit.truncated"] is True
    assert np.array_equal(infos[0]["terminal_observation"], before[0])  # nothing moved
    assert not np.array_equal(observations[0], before[0])  # a new room


def test_seeds_are_used_once_and_make_rooms_equal():
    make = lambda: Rooms(NavigationVectorEnv(2, ROOM, ZONES, FAST, 4, AutoresetMode.SAME_STEP))  # noqa: E731
    a, b = make(), make()
    a.seed(3), b.seed(3)
    assert np.array_equal(a.reset(), b.reset())
    assert not np.array_equal(a.reset()[0], (b.seed(4), b.reset())[1][0])


def test_rooms_that_reset_a_step_later_are_refused():
    with pytest.raises(ValueError, match="SAME_STEP"):
        Rooms(NavigationVectorEnv(2, ROOM, ZONES, FAST))
