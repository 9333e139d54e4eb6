"""What every world promises, tried on every robot of config/default.yaml, on the empty floor and in the stand-in for Rs."""

from __future__ import annotations

import numpy as np
import pytest
from sensory_commutativity.helpers import DEFAULT, full_speed

from sensory_commutativity.scp.sequences import compose, no_op
from sensory_commutativity.scp.world import World, play
from sensory_commutativity.studies.apartment.builders import scene_of
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.world import ApartmentWorld

SETTINGS = load(DEFAULT).apartment
PAIRS = [
    (robot, scene)
    for robot in SETTINGS.robots
    for scene in ("free-space", SETTINGS.reference.scene)
]


def built(robot: str, scene: str) -> ApartmentWorld:
    return ApartmentWorld(
        scene_of(SETTINGS, scene),
        load_robot(SETTINGS.robots[robot].description),
        (Camera(32, 32, 90.0, 1),),
    )


@pytest.fixture(scope="module", params=PAIRS, ids="/".join)
def pair(request):
    """A world and another of the same kind."""
    worlds = built(*request.param), built(*request.param)
    yield worlds
    for world in worlds:
        world.simulation.close()


def started(world: ApartmentWorld, seed: int) -> ApartmentWorld:
    world.reset(np.random.default_rng(seed))
    return world


def commands(world: World, seed: int, steps: int = 30) -> np.ndarray:
    rng, n = np.random.default_rng(seed), len(world.dofs)
    return compose(full_speed(rng, steps // 2, n), rng.uniform(-1, 1, (steps - steps // 2, n)))


def state(world: ApartmentWorld) -> list[np.ndarray]:
    return [
        world.simulation.poses(),
        world.observe(),
        *(np.asarray(value) for value in world.happened()),
    ]


def same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def test_equal_seeds_give_equal_ends_in_a_used_world_and_a_new_one(pair):
    world, other = pair
    play(started(other, 99), commands(other, 5))
    for each in pair:
        play(started(each, 3), commands(each, 11))
    assert same(state(world), state(other))


def test_a_snapshot_in_the_middle_of_a_run_is_exact_and_outlives_what_happens_after(pair):
    world, _ = pair
    play(started(world, 1), commands(world, 1))
    middle = world.snapshot()
    here = state(world)
    play(world, commands(world, 2))
    end = state(world)
    play(started(world, 77), commands(world, 3))
    world.restore(middle)
    assert same(here[:2], state(world)[:2])  # counting begins anew
    play(world, commands(world, 2))
    assert same(end[:2], state(world)[:2])


def test_observations_never_alias_and_actions_are_left_alone(pair):
    world, _ = pair
    first = started(world, 2).observe()
    kept, actions = first.copy(), 3 * commands(world, 1)
    given = actions.copy()
    assert not np.shares_memory(first, world.observe())
    first[...] = 7
    assert np.array_equal(world.observe(), kept)
    play(world, actions)
    assert np.array_equal(actions, given)


def test_actions_are_clipped_and_refused_if_they_are_none(pair):
    world, _ = pair
    start = started(world, 4).snapshot()
    ends = []
    for actions in (3 * commands(world, 8), np.clip(3 * commands(world, 8), -1, 1)):
        world.restore(start)
        play(world, actions)
        ends.append(state(world))
    assert same(*ends)
    for wrong in (np.zeros(len(world.dofs) + 1), np.full(len(world.dofs), np.nan)):
        with pytest.raises(ValueError, match="action"):
            world.step(wrong)


@pytest.mark.parametrize("name", SETTINGS.robots)
def test_each_dof_moves_what_its_name_says_and_free_space_commutes(name):
    world = built(name, "free-space")
    robot, n = world.robot, len(world.dofs)
    for k, dof in enumerate(world.dofs):
        start = started(world, 6).snapshot()
        joints, base = world.simulation.joints(), world.simulation.base()
        there, back = np.zeros((4, n)), np.zeros((4, n))
        there[:, k], back[:, k] = 0.5, -0.5
        play(world, compose(there, no_op(3, n)))
        moved = np.abs(world.simulation.joints() - joints) > 1e-3
        if set(robot.description.dofs[k].joints) & set(robot.wheels):
            assert not moved.any() and np.abs(world.simulation.base() - base).max() > 0.01
        else:
            assert [
                joint.name for joint, m in zip(robot.joints, moved, strict=True) if m
            ] == robot.description.dofs[k].joints
            driven = int(np.nonzero(moved)[0][0])
            assert world.simulation.joints()[driven] - joints[driven] == pytest.approx(
                2 * dof.speed, rel=5e-3
            )
        ends = []
        for order in (compose(there, back), compose(back, there)):
            world.restore(start)
            play(world, compose(order, no_op(3, n)))
            ends.append(np.concatenate([world.simulation.joints(), world.simulation.base()]))
        assert np.abs(ends[0] - ends[1]).max() < 1e-6, dof.name
    world.simulation.close()
