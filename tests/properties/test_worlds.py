"""The promises of every world, tested on every world and agent of config/config.yaml."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys

import numpy as np
import pytest

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import compare_orders
from sensory_commutativity.scp.sequences import compose, sample_sequence
from sensory_commutativity.scp.world import SequencePlayer, World, play
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.agent import N_LINKS
from sensory_commutativity.worlds.flatland.room import MOVABLE
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import (
    DOFS,
    FLATLAND_PAIRS,
    ROOT,
    WORLDS,
    make_flatland,
    reset_world,
    sample_held_commands,
)


def play_observed(world: World, actions: np.ndarray) -> np.ndarray:
    """Observations before the first and after every action."""
    observations = [world.observe()]
    for action in actions:
        world.step(action)
        observations.append(world.observe())
    return np.array(observations)


def state_of(world: World) -> list[np.ndarray]:
    """All that is known about the state of the world, read without changing it."""
    if isinstance(world, FlatlandWorld):
        return [world.poses(), world.controller_state, world.observe()]
    return [world.observe()]


def equal(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def sample_commands(world: World, seed: int, steps: int = 60) -> np.ndarray:
    """Half of the actions at full speed, to run into objects, and half of them uniform."""
    rng, n = np.random.default_rng(seed), len(world.dofs)
    held = sample_held_commands(rng, steps // 2, n)
    return compose(held, rng.uniform(-1, 1, (steps - steps // 2, n)))


def sample_charge(world: World, seed: int) -> np.ndarray:
    """Straight ahead at full speed, with random arms: something will be in the way."""
    actions = sample_commands(world, seed, 40)
    actions[:, 0], actions[:, 1] = 1.0, 0.0
    return actions


# ---- the protocol --------------------------------------------------------------------------------


def test_worlds_fulfil_the_protocol():
    for name, make in WORLDS.items():
        world = make()
        assert isinstance(world, World), name
        assert isinstance(world, SequencePlayer) == isinstance(world, FlatlandWorld)
        dof_names = [dof.name for dof in world.dofs]
        assert len(set(dof_names)) == len(dof_names) > 0
        for dof in world.dofs:
            assert dof.name == dof.name.lower().replace(" ", "-").replace("_", "-")
            assert dof.speed > 0 and dof.low < 0 < dof.high and dof.unit, (name, dof)
        if isinstance(world, FlatlandWorld):
            assert dof_names == DOFS
            assert [dof.name for dof in world.dofs if not dof.displaces] == ["head", "eyelid"]
            view = reset_world(world).observe()
            assert view.shape == (64, 3) and view.dtype == np.uint8  # paper, section III-A


# ---- seeds ---------------------------------------------------------------------------------------


def test_equal_seeds_give_equal_trajectories():
    for name, make in WORLDS.items():
        world, used = make(), make()
        actions = sample_commands(world, seed=11)
        first = play_observed(reset_world(world, 3), actions)
        play(reset_world(used, 99), actions)
        assert np.array_equal(first, play_observed(reset_world(used, 3), actions)), name
        assert equal(state_of(world), state_of(used)), name
        assert np.array_equal(first, play_observed(reset_world(world, 3), actions)), name


def test_start_situations_differ_between_seeds():
    for pair in FLATLAND_PAIRS:
        world = make_flatland(pair)
        poses = np.array([reset_world(world, seed).poses() for seed in range(20)])
        assert len({tuple(base) for base in poses[:, 0]}) == 20, pair
        assert np.ptp(poses[:, 0], axis=0).min() > 1.0, pair  # units, units, rad
        if world.room.objects:
            moved = np.abs(poses[0, N_LINKS:] - poses[1, N_LINKS:])
            assert moved.max(axis=1).min() > 1e-3, pair  # every object has another pose


# ---- snapshots -----------------------------------------------------------------------------------


def test_replay_from_a_restored_start_is_bit_identical():
    for name, make in WORLDS.items():
        world = reset_world(make())
        start, actions = world.snapshot(), sample_commands(world, seed=1)
        first, end = play_observed(world, actions), state_of(world)
        world.restore(start)
        assert np.array_equal(first, play_observed(world, actions)), name
        assert equal(end, state_of(world)), name


def movable_poses(world: World) -> np.ndarray:
    """Poses of the objects that move only if the agent or another object pushes them."""
    if not isinstance(world, FlatlandWorld):
        return np.zeros(0)
    return world.poses()[N_LINKS:][world.situation.kind == MOVABLE]


def test_snapshots_within_a_sequence_are_exact():
    for name, make in WORLDS.items():
        world, second = make(), reset_world(make(), 50)
        displaced = False
        for seed in range(6):
            before = movable_poses(reset_world(world, seed))
            play(world, sample_charge(world, seed))
            displaced |= not np.array_equal(before, movable_poses(world))
            snapshot, actions = world.snapshot(), sample_commands(world, seed + 100)
            state = state_of(world)
            continued = play_observed(world, actions)
            end = state_of(world)
            for restored in (world, second):
                restored.restore(snapshot)
                assert equal(state, state_of(restored)), name
                assert np.array_equal(continued, play_observed(restored, actions)), name
                assert equal(end, state_of(restored)), name
        if isinstance(world, FlatlandWorld) and world.room.objects:
            assert displaced, name  # otherwise there was no contact to remember


def test_snapshots_outlive_what_happens_afterwards():
    for name, make in WORLDS.items():
        world = reset_world(make())
        play(world, sample_commands(world, 1))
        snapshot, state = world.snapshot(), state_of(world)
        play(world, sample_commands(world, 2))
        reset_world(world, 77)
        play(world, sample_commands(world, 3))
        world.restore(snapshot)
        assert equal(state, state_of(world)), name


def test_observing_and_another_snapshot_change_nothing():
    for name, make in WORLDS.items():
        world = reset_world(make())
        play(world, sample_commands(world, 1))
        first, actions = world.snapshot(), sample_commands(world, 2)
        expected = play_observed(world, actions)
        world.restore(first)
        world.observe()
        second = world.snapshot()
        world.observe()
        assert np.array_equal(expected, play_observed(world, actions)), name
        world.restore(second)
        assert np.array_equal(expected, play_observed(world, actions)), name


IN_ANOTHER_PROCESS = """
import pickle, sys
from tests.helpers import make_flatland
from tests.properties.test_worlds import play_observed
pair, snapshot, actions = pickle.load(sys.stdin.buffer)
world = make_flatland(pair)
world.restore(snapshot)
pickle.dump((play_observed(world, actions), world.poses()), sys.stdout.buffer)
"""


def test_replay_in_another_process_is_bit_identical():
    pair = ("furnished", "polyphemus")
    world = reset_world(make_flatland(pair), 5)
    play(world, sample_commands(world, 5, 100))
    snapshot, actions = world.snapshot(), sample_commands(world, 6, 100)
    views = play_observed(world, actions)
    run = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS],
        input=pickle.dumps((pair, snapshot, actions)),
        capture_output=True,
        check=True,
        timeout=120,
        cwd=ROOT,
    )
    other_views, other_poses = pickle.loads(run.stdout)
    assert np.array_equal(views, other_views)
    assert np.array_equal(world.poses(), other_poses)


# ---- observations --------------------------------------------------------------------------------


def test_observations_never_alias():
    for name, make in WORLDS.items():
        world = reset_world(make())
        first = world.observe()
        copy = first.copy()
        second = world.observe()
        assert not np.shares_memory(first, second), name
        first[...] = 7  # the caller may write into it
        assert np.array_equal(world.observe(), copy), name
        changed = False
        for seed in range(10):
            play(world, sample_commands(world, seed))
            changed |= not np.array_equal(world.observe(), copy)
            assert np.array_equal(second, copy), name
        assert changed, name


def test_no_element_of_the_observation_is_constant():
    for name, make in WORLDS.items():
        world = make()
        observations = []
        for seed in range(60):
            reset_world(world, seed)
            play(world, sample_commands(world, seed, 30))
            observations.append(world.observe())
        constant = np.ptp(np.array(observations).astype(float), axis=0) == 0
        if isinstance(world, Corridor) and "box" not in name:
            assert constant.tolist() == [False, True, False], name  # there is no box
        else:
            assert not constant.any(), name


# ---- actions -------------------------------------------------------------------------------------


def test_play_and_rollout_equal_single_steps():
    for name, make in WORLDS.items():
        world = reset_world(make())
        start, actions = world.snapshot(), sample_commands(world, 4)
        observations, end = play_observed(world, actions), state_of(world)
        for parts in ([actions], [actions[:17], actions[17:]]):
            world.restore(start)
            for part in parts:
                play(world, part)
            assert equal(end, state_of(world)), name
        if isinstance(world, FlatlandWorld):
            world.restore(start)
            views = world.rollout(actions)
            assert np.array_equal(views, observations[1:]), name
            assert equal(end, state_of(world)), name
            world.rollout(actions)[...] = 7
            assert np.array_equal(views, observations[1:]), name  # no view of internal memory


def test_actions_are_clipped_and_not_changed():
    for name, make in WORLDS.items():
        world = reset_world(make())
        start, actions = world.snapshot(), 3 * sample_commands(world, 8)
        copy = actions.copy()
        play(world, np.clip(actions, -1, 1))
        end = state_of(world)
        world.restore(start)
        play(world, actions)
        assert equal(end, state_of(world)), name
        world.restore(start)
        for action in actions:
            world.step(action)
        assert equal(end, state_of(world)), name
        assert np.array_equal(actions, copy), name


def test_actions_of_the_wrong_shape_are_refused():
    for name, make in WORLDS.items():
        world = reset_world(make())
        n, state = len(world.dofs), state_of(world)
        for shape in [(), (0,), (n - 1,), (n + 1,), (1, n), (2, n)]:
            with pytest.raises(ValueError):
                world.step(np.zeros(shape))
        assert equal(state, state_of(world)), name
    world = reset_world(FlatlandWorld())
    for shape in [(8,), (3, 7), (3, 9), (3, 1, 8)]:
        for method in (world.play, world.rollout):
            with pytest.raises(ValueError, match="8 elements"):
                method(np.zeros(shape))


def test_actions_that_are_not_finite_are_refused():
    """They would stay in the state of the world for ever."""
    world = reset_world(FlatlandWorld())
    state = state_of(world)
    for value in (math.nan, math.inf, -math.inf):
        actions = np.zeros((3, 8))
        actions[1, 2] = value
        for method, argument in [
            (world.step, actions[1]),
            (world.play, actions),
            (world.rollout, actions),
        ]:
            with pytest.raises(ValueError, match="not finite"):
                method(argument)
    assert equal(state, state_of(world))


def test_a_world_without_a_situation_asks_for_a_reset():
    world = FlatlandWorld()
    for method, *arguments in [
        (world.step, np.zeros(8)),
        (world.play, np.zeros((2, 8))),
        (world.rollout, np.zeros((2, 8))),
        (world.observe,),
        (world.snapshot,),
    ]:
        with pytest.raises(RuntimeError, match="reset"):
            method(*arguments)


# ---- commutation ---------------------------------------------------------------------------------


def test_the_identity_permutation_commutes():
    for name, make in WORLDS.items():
        world = make()
        n = len(world.dofs)
        for seed in range(3):
            start, rng = reset_world(world, seed).snapshot(), np.random.default_rng(seed)
            sequences = [sample_sequence(rng, 50, k, n) for k in range(n)]
            for sequence in [*sequences, sample_held_commands(rng, 50, n)]:
                outcome = compare_orders(world, start, sequence, sequence.copy())
                assert mean_squared_error(*outcome) == 0, name
