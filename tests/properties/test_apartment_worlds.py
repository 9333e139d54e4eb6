"""The contract of worlds, for every robot of the default configuration, in two scenes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sensory_commutativity.scp.sequences import compose, no_op
from sensory_commutativity.scp.world import play
from sensory_commutativity.studies.apartment.builders import build_scene
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.world import ApartmentWorld
from tests.helpers import DEFAULT, reset_world, sample_held_commands

SETTINGS = load(DEFAULT).apartment
PAIRS = [
    (robot, scene)
    for robot in SETTINGS.robots
    for scene in ("free-space", SETTINGS.reference.scene)
]


def make_world(robot: str, scene: str) -> ApartmentWorld:
    description = SETTINGS.robots[robot].description
    cameras = (Camera(32, 32, 90.0, 1),)
    return ApartmentWorld(build_scene(SETTINGS, scene), load_robot(description), cameras)


@pytest.fixture(scope="module", params=PAIRS, ids="/".join)
def worlds(request):
    """Two worlds with the same robot and scene."""
    pair = make_world(*request.param), make_world(*request.param)
    yield pair
    for world in pair:
        world.simulation.close()


def sample_commands(world: ApartmentWorld, seed: int, steps: int = 30) -> np.ndarray:
    """Half of the steps at full speed, half random."""
    rng, n, fast = np.random.default_rng(seed), len(world.dofs), steps // 2
    return compose(sample_held_commands(rng, fast, n), rng.uniform(-1, 1, (steps - fast, n)))


def measure(world: ApartmentWorld) -> list[np.ndarray]:
    return [world.simulation.poses(), world.observe(), *map(np.asarray, world.happened())]


def equal(first: list[Any], second: list[Any]) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_replays_are_exact(worlds):
    """From a seed, in a used world and a new one; and from a snapshot in the middle of a run."""
    new, used = worlds
    play(reset_world(used, 99), sample_commands(used, 5))
    for world in worlds:
        play(reset_world(world, 3), sample_commands(world, 11))
    assert equal(measure(new), measure(used))

    world = new
    play(reset_world(world, 1), sample_commands(world, 1))
    snapshot, middle = world.snapshot(), measure(world)
    play(world, sample_commands(world, 2))
    end = measure(world)
    play(reset_world(world, 77), sample_commands(world, 3))
    world.restore(snapshot)
    assert equal(middle[:2], measure(world)[:2])  # counts start again
    play(world, sample_commands(world, 2))
    assert equal(end[:2], measure(world)[:2])


def test_observations_are_copies_and_actions_are_clipped_checked_and_not_modified(worlds):
    world, _ = worlds
    observation = reset_world(world, 2).observe()
    expected = observation.copy()
    observation[...] = 7
    assert np.array_equal(world.observe(), expected)

    start = reset_world(world, 4).snapshot()
    actions = 3 * sample_commands(world, 8)
    before, ends = actions.copy(), []
    for sequence in (actions, np.clip(actions, -1, 1)):
        world.restore(start)
        play(world, sequence)
        ends.append(measure(world))
    assert equal(*ends) and np.array_equal(actions, before)
    for invalid in (np.zeros(len(world.dofs) + 1), np.full(len(world.dofs), np.nan)):
        with pytest.raises(ValueError, match="action"):
            world.step(invalid)


def test_each_dof_moves_its_joints_and_commutes_in_free_space():
    for name in SETTINGS.robots:
        world = make_world(name, "free-space")
        for k, dof in enumerate(world.dofs):
            where = f"{name}: {dof.name}"
            start = reset_world(world, 6).snapshot()
            forth, back = np.zeros((2, 4, len(world.dofs)))
            forth[:, k], back[:, k] = 0.5, -0.5
            check_motion(world, k, forth, where)
            ends = []
            for order in (compose(forth, back), compose(back, forth)):
                world.restore(start)
                play(world, compose(order, no_op(3, len(world.dofs))))
                ends.append(np.concatenate([world.simulation.joints(), world.simulation.base()]))
            assert np.abs(ends[0] - ends[1]).max() < 1e-6, where
        world.simulation.close()


def check_motion(world: ApartmentWorld, k: int, actions: np.ndarray, where: str) -> None:
    """Play `actions`, which sum to 2 in degree of freedom `k`, and check what moves, how far."""
    robot, simulation = world.robot, world.simulation
    joints, base = simulation.joints(), simulation.base()
    play(world, compose(actions, no_op(3, len(world.dofs))))
    shifts = simulation.joints() - joints
    moved = np.abs(shifts) > 1e-3
    expected = robot.description.dofs[k].joints
    if set(expected) & set(robot.wheels):
        assert not moved.any() and np.abs(simulation.base() - base).max() > 0.01, where
        return
    names = [joint.name for joint, m in zip(robot.joints, moved, strict=True) if m]
    assert names == expected, where
    assert shifts[moved][0] == pytest.approx(2 * world.dofs[k].speed, rel=5e-3), where
