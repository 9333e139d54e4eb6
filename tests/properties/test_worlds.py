"""What every world promises, tried on every world and agent that config/default.yaml uses."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest
from tests.helpers import (
    DOFS,
    EMPTY,
    FLATLAND_PAIRS,
    FREE_SPACE,
    WALLED_PAIRS,
    WORLDS,
    drive,
    enter,
    flatland,
    sample_held_commands,
    forward_kinematics,
    reset_world,
)

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import (
    REST_STEPS,
    commutation_experiment,
    compare_orders,
    final_observation,
    sc_experiment,
)
from sensory_commutativity.scp.sequences import compose, no_op, permute, sample_sequence
from sensory_commutativity.scp.world import World, play
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.agent import N_LINKS
from sensory_commutativity.worlds.flatland.control import EYELID, HEAD
from sensory_commutativity.worlds.flatland.room import MOVABLE
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

every_world = pytest.mark.parametrize("name", WORLDS)
every_pair = pytest.mark.parametrize("pair", FLATLAND_PAIRS, ids="/".join)
every_walled_pair = pytest.mark.parametrize("pair", WALLED_PAIRS, ids="/".join)
every_agent = pytest.mark.parametrize("agent", sorted({agent for _, agent in FLATLAND_PAIRS}))


def trajectory(world: World, actions: np.ndarray) -> np.ndarray:
    """What is seen before the first and after every action."""
    seen = [world.observe()]
    for action in actions:
        world.step(action)
        seen.append(world.observe())
    return np.array(seen)


def state(world: World) -> list[np.ndarray]:
    """All that can be known of where the world has got to, without disturbing it."""
    if isinstance(world, FlatlandWorld):
        return [world.poses(), world.inner, world.observe()]
    return [world.observe()]


def same(a: list[np.ndarray], b: list[np.ndarray]) -> bool:
    return len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def commands(world: World, seed: int, steps: int = 60) -> np.ndarray:
    """Half of them uniform, half at full speed, so that things are run into."""
    rng = np.random.default_rng(seed)
    n = len(world.dofs)
    return compose(sample_held_commands(rng, steps // 2, n), rng.uniform(-1, 1, (steps - steps // 2, n)))


def charge(world: World, seed: int) -> np.ndarray:
    """Straight ahead at full speed while the arms flail: something is in the way sooner or later."""
    actions = commands(world, seed, 40)
    actions[:, 0], actions[:, 1] = 1.0, 0.0
    return actions


# ---- it is a world ---------------------------------------------------------------------------------------------------------


@every_world
def test_has_the_five_methods_and_well_named_dofs(name):
    world = WORLDS[name]()
    assert isinstance(world, World)
    names = [dof.name for dof in world.dofs]
    assert len(set(names)) == len(names) > 0
    for dof in world.dofs:
        assert dof.name == dof.name.lower().replace(" ", "-").replace("_", "-")
        assert dof.speed > 0
        assert dof.low < 0 < dof.high
        assert dof.unit


@every_pair
def test_the_agent_has_the_eight_dofs_of_the_paper(pair):
    world = flatland(pair)
    assert [dof.name for dof in world.dofs] == DOFS
    assert [dof.name for dof in world.dofs if not dof.displaces] == ["head", "eyelid"]


# ---- equal seeds, equal trajectories ---------------------------------------------------------------------------------------


@every_world
def test_equal_seeds_give_equal_trajectories(name):
    world, other = WORLDS[name](), WORLDS[name]()
    actions = commands(world, seed=11)
    first = trajectory(reset_world(world, 3), actions)
    play(reset_world(other, 99), actions)  # a used world must not differ from a new one
    assert np.array_equal(first, trajectory(reset_world(other, 3), actions))
    assert same(state(world), state(other))
    assert np.array_equal(first, trajectory(reset_world(world, 3), actions))


@every_pair
def test_start_situations_differ_between_seeds(pair):
    world = flatland(pair)
    starts = [reset_world(world, seed).poses()[0] for seed in range(20)]
    assert len({tuple(start) for start in starts}) == 20
    assert np.ptp(starts, axis=0).min() > 1.0  # units, units, rad: places and headings spread
    if world.room.things:
        first, second = reset_world(world, 0).poses()[N_LINKS:], reset_world(world, 1).poses()[N_LINKS:]
        assert np.abs(first - second).max(axis=1).min() > 1e-3  # each thing is somewhere else


# ---- snapshots -------------------------------------------------------------------------------------------------------------


@every_world
def test_replay_from_a_restored_start_is_bit_identical(name):
    world = reset_world(WORLDS[name]())
    start, actions = world.snapshot(), commands(world, seed=1)
    first = trajectory(world, actions)
    end = state(world)
    world.restore(start)
    assert np.array_equal(first, trajectory(world, actions))
    assert same(end, state(world))


@every_world
def test_a_snapshot_in_the_middle_of_a_run_is_exact(name):
    world, other = WORLDS[name](), reset_world(WORLDS[name](), 50)
    displaced = 0
    for seed in range(6):
        reset_world(world, seed)
        things_before = movable_things(world)
        play(world, charge(world, seed))
        displaced += len(things_before) > 0 and not np.array_equal(
            things_before, movable_things(world)
        )
        middle, actions = world.snapshot(), commands(world, seed + 100)
        here = state(world)
        original = trajectory(world, actions)  # the original goes on
        end = state(world)
        for restored in (world, other):
            restored.restore(middle)
            assert same(here, state(restored))
            assert np.array_equal(original, trajectory(restored, actions))
            assert same(end, state(restored))
    if isinstance(world, FlatlandWorld) and world.room.things:
        assert displaced  # otherwise nothing was touched, and the test would prove little


def movable_things(world: World) -> np.ndarray:
    """Poses of the things that only the agent can have moved, or another thing."""
    if not isinstance(world, FlatlandWorld):
        return np.zeros(0)
    return world.poses()[N_LINKS:][world.situation.kind == MOVABLE]


@every_world
def test_a_snapshot_outlives_what_happens_after_it(name):
    world = reset_world(WORLDS[name]())
    play(world, commands(world, 1))
    snapshot, here = world.snapshot(), state(world)
    play(world, commands(world, 2))
    reset_world(world, 77)
    play(world, commands(world, 3))
    world.restore(snapshot)
    assert same(here, state(world))


@every_world
def test_looking_and_taking_a_second_snapshot_change_nothing(name):
    world = reset_world(WORLDS[name]())
    play(world, commands(world, 1))
    first, actions = world.snapshot(), commands(world, 2)
    expected = trajectory(world, actions)
    world.restore(first)
    world.observe()
    second = world.snapshot()
    world.observe()
    assert np.array_equal(expected, trajectory(world, actions))
    world.restore(second)
    assert np.array_equal(expected, trajectory(world, actions))


IN_ANOTHER_PROCESS = """
import pickle, sys
from tests.properties.test_worlds import trajectory
from tests.helpers import flatland
pair, snapshot, actions = pickle.load(sys.stdin.buffer)
world = flatland(pair)
world.restore(snapshot)
pickle.dump((trajectory(world, actions), world.poses()), sys.stdout.buffer)
"""


def test_replay_in_another_process_is_bit_identical():
    pair = ("furnished", "polyphemus")
    world = reset_world(flatland(pair), 5)
    play(world, commands(world, 5, 100))
    snapshot, actions = world.snapshot(), commands(world, 6, 100)
    seen = trajectory(world, actions)
    message = pickle.dumps((pair, snapshot, actions))
    run = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS],
        input=message,
        capture_output=True,
        check=True,
        timeout=120,
    )
    seen_there, poses_there = pickle.loads(run.stdout)
    assert np.array_equal(seen, seen_there)
    assert np.array_equal(world.poses(), poses_there)


# ---- observations ----------------------------------------------------------------------------------------------------------


@every_world
def test_observations_never_alias(name):
    world = reset_world(WORLDS[name]())
    first = world.observe()
    kept = first.copy()
    second = world.observe()
    assert not np.shares_memory(first, second)
    first[...] = 7  # the caller may write into it
    assert np.array_equal(world.observe(), kept)
    went_on = False
    for seed in range(10):
        play(world, commands(world, seed))
        went_on |= not np.array_equal(world.observe(), kept)
        assert np.array_equal(second, kept)
    assert went_on


@every_pair
def test_watched_observations_never_alias(pair):
    world = reset_world(flatland(pair))
    start, actions = world.snapshot(), commands(world, 1)
    seen = world.rollout(actions)
    kept = seen.copy()
    world.restore(start)
    again = world.rollout(actions)
    assert not np.shares_memory(seen, again)
    again[...] = 7
    play(world, actions)
    assert np.array_equal(seen, kept)


@every_world
def test_the_caller_s_actions_are_left_alone(name):
    world = reset_world(WORLDS[name]())
    actions = 3 * commands(world, 1)
    kept = actions.copy()
    play(world, actions)
    for action in actions:
        world.step(action)
    assert np.array_equal(actions, kept)


@every_world
def test_playing_at_once_equals_single_steps(name):
    world = reset_world(WORLDS[name]())
    start, actions = world.snapshot(), commands(world, 4)
    for action in actions:
        world.step(action)
    end = state(world)
    world.restore(start)
    play(world, actions)
    assert same(end, state(world))
    world.restore(start)
    play(world, actions[:17])
    play(world, actions[17:])
    assert same(end, state(world))


@every_pair
def test_watching_sees_what_single_steps_see(pair):
    world = reset_world(flatland(pair))
    start, actions = world.snapshot(), commands(world, 4)
    seen = world.rollout(actions)
    assert np.array_equal(seen[-1], world.observe())
    end = state(world)
    world.restore(start)
    assert np.array_equal(seen, trajectory(world, actions)[1:])
    assert same(end, state(world))


@every_world
def test_no_element_of_the_observation_is_constant(name):
    world = WORLDS[name]()
    seen = []
    for seed in range(60):
        reset_world(world, seed)
        play(world, commands(world, seed, 30))
        seen.append(world.observe())
    constant = np.ptp(np.array(seen).astype(float), axis=0) == 0
    if isinstance(world, Corridor) and "box" not in name:
        assert constant.tolist() == [
            False,
            True,
            False,
        ]  # the place of the box, where there is none
    else:
        assert not constant.any()


@every_pair
def test_the_view_is_a_line_of_rgb_pixels(pair):
    seen = reset_world(flatland(pair)).observe()
    assert seen.shape == (64, 3)  # paper, section III-A
    assert seen.dtype == np.uint8


# ---- actions ---------------------------------------------------------------------------------------------------------------


@every_world
def test_actions_are_clipped(name):
    world = reset_world(WORLDS[name]())
    start, actions = world.snapshot(), 3 * commands(world, 8)
    play(world, actions)
    end = state(world)
    world.restore(start)
    play(world, np.clip(actions, -1, 1))
    assert same(end, state(world))
    world.restore(start)
    for action in actions:
        world.step(action)
    assert same(end, state(world))


@every_world
def test_an_action_of_the_wrong_shape_is_refused(name):
    world = reset_world(WORLDS[name]())
    n, here = len(world.dofs), state(world)
    for shape in [(), (0,), (n - 1,), (n + 1,), (1, n), (2, n)]:
        with pytest.raises(ValueError):
            world.step(np.zeros(shape))
    assert same(here, state(world))


@pytest.mark.parametrize("shape", [(8,), (3, 7), (3, 9), (3, 1, 8)], ids=str)
def test_a_sequence_of_the_wrong_shape_is_refused(shape):
    world = reset_world(FlatlandWorld())
    for method in (world.play, world.watch):
        with pytest.raises(ValueError, match="8 elements"):
            method(np.zeros(shape))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("method", ["step", "play", "watch"])
def test_an_action_that_is_no_number_is_refused(method, value):
    """It would stay in the world's state for ever."""
    world = reset_world(FlatlandWorld())
    here, actions = state(world), np.zeros((3, 8))
    actions[1, 2] = value
    with pytest.raises(ValueError, match="not finite"):
        getattr(world, method)(actions[1] if method == "step" else actions)
    assert same(here, state(world))


@pytest.mark.parametrize("use", ["step", "play", "watch", "observe", "snapshot"])
def test_a_world_without_a_situation_says_what_to_do(use):
    world = FlatlandWorld()
    arguments = {
        "step": [np.zeros(8)],
        "play": [np.zeros((2, 8))],
        "watch": [np.zeros((2, 8))],
    }.get(use, [])
    with pytest.raises(RuntimeError, match="reset"):
        getattr(world, use)(*arguments)


# ---- each degree of freedom moves what its name says, and nothing else -----------------------------------------------------


class Moved(NamedTuple):
    """What an action changed, once the agent is at rest again."""

    world: FlatlandWorld
    before: np.ndarray
    after: np.ndarray
    inner_before: np.ndarray
    inner_after: np.ndarray


def alone(agent: str) -> FlatlandWorld:
    """The agent of that name in free space."""
    return FlatlandWorld(
        FREE_SPACE, flatland(next(pair for pair in FLATLAND_PAIRS if pair[1] == agent)).agent
    )


def move(agent: str, dof: str, value: float) -> Moved:
    world = reset_world(alone(agent), 6)
    before, inner = world.poses(), world.inner
    world.play(compose(drive(dof, value, 1), no_op(REST_STEPS, 8)))
    return Moved(world, before, world.poses(), inner, world.inner)


def speed(world: FlatlandWorld, dof: str) -> float:
    return world.dofs[DOFS.index(dof)].speed


@every_agent
@pytest.mark.parametrize("value", [1.0, -0.5])
def test_base_longitudinal_moves_along_the_heading(agent, value):
    moved = move(agent, "base-longitudinal", value)
    heading = moved.before[0, 2]
    expected = (
        value
        * speed(moved.world, "base-longitudinal")
        * np.array([math.cos(heading), math.sin(heading), 0.0])
    )
    assert np.allclose(moved.after - moved.before, expected, atol=1e-5)  # the arms come along
    assert np.array_equal(moved.inner_after[[HEAD, EYELID]], moved.inner_before[[HEAD, EYELID]])


@every_agent
@pytest.mark.parametrize("value", [1.0, -0.5])
def test_base_rotation_turns_on_the_spot(agent, value):
    moved = move(agent, "base-rotation", value)
    body, (x, y, heading) = moved.world.agent, moved.before[0]
    expected = forward_kinematics(
        body, x, y, heading + value * speed(moved.world, "base-rotation"), body.rest_angles
    )
    assert np.allclose(moved.after, expected, atol=1e-3)
    assert np.array_equal(moved.inner_after[[HEAD, EYELID]], moved.inner_before[[HEAD, EYELID]])


@every_agent
@pytest.mark.parametrize("value", [1.0, -0.5])
def test_the_head_turns_the_eye_alone(agent, value):
    moved = move(agent, "head", value)
    assert np.allclose(moved.after, moved.before, atol=1e-9)
    change = moved.inner_after - moved.inner_before
    assert change[HEAD] == pytest.approx(value * 0.25, abs=1e-6)  # authors: 0.25 rad per step
    assert not np.delete(change, [HEAD, 9]).any()  # 9 is the time


@every_agent
@pytest.mark.parametrize(("value", "brightness"), [(1.0, 1.05), (-0.5, 0.975)])
def test_the_eyelid_changes_the_brightness_alone(agent, value, brightness):
    moved = move(agent, "eyelid", value)
    assert np.allclose(moved.after, moved.before, atol=1e-9)
    change = moved.inner_after - moved.inner_before
    assert moved.inner_after[EYELID] == pytest.approx(brightness, abs=1e-6)
    assert not np.delete(change, [EYELID, 9]).any()


JOINTS = ("left-shoulder", "left-elbow", "right-shoulder", "right-elbow")


@every_agent
@pytest.mark.parametrize("value", [1.0, -0.5])
@pytest.mark.parametrize("joint", JOINTS)
def test_a_joint_turns_what_hangs_on_it(agent, joint, value):
    moved = move(agent, joint, value)
    body = moved.world.agent
    angles = body.rest_angles.copy()
    counter_clockwise = 1 if joint.startswith("left") else -1
    angles[JOINTS.index(joint)] += counter_clockwise * value * speed(moved.world, joint)
    assert np.allclose(moved.after, forward_kinematics(body, *moved.before[0], angles), atol=1e-3)
    untouched = {
        "left-shoulder": [0, 3, 4],
        "left-elbow": [0, 1, 3, 4],
        "right-shoulder": [0, 1, 2],
        "right-elbow": [0, 1, 2, 3],
    }[joint]
    assert np.allclose(moved.after[untouched], moved.before[untouched], atol=1e-9)
    assert np.array_equal(moved.inner_after[[HEAD, EYELID]], moved.inner_before[[HEAD, EYELID]])


@pytest.mark.parametrize("joint", ["shoulder", "elbow"])
def test_equal_actions_move_the_arms_as_mirror_images(joint):
    world = enter(FREE_SPACE, 300, 400, 0.0)  # looking along x: the mirror is the line y = 400
    world.play(
        compose(drive(f"left-{joint}", 0.7, 3) + drive(f"right-{joint}", 0.7, 3), no_op(3, 8))
    )
    left, right = world.poses()[1:3], world.poses()[3:5]
    assert np.allclose(left[:, 0], right[:, 0], atol=1e-6)
    assert np.allclose(left[:, 1] - 400, 400 - right[:, 1], atol=1e-6)
    assert np.allclose(left[:, 2], -right[:, 2], atol=1e-6)


@every_agent
def test_all_dofs_at_once_keep_the_linkage_together(agent):
    world = reset_world(alone(agent), 2)
    rng = np.random.default_rng(2)
    for _ in range(10):
        world.play(compose(sample_held_commands(rng, 20, 8), no_op(REST_STEPS, 8)))
        inner = world.inner
        assert np.allclose(world.poses(), forward_kinematics(world.agent, *inner[:3], inner[3:7]), atol=1e-6)


@pytest.mark.parametrize(("value", "stop"), [(1.0, 60.0), (-1.0, -60.0)])
def test_joint_stops_stop(value, stop):
    world = reset_world(flatland(("free-space", "joint-stops")), 1)
    world.play(compose(drive("left-shoulder", value, 30), no_op(3, 8)))
    poses = world.poses()
    turned = poses[1, 2] - poses[0, 2] - world.agent.rest_angles[0]
    assert turned == pytest.approx(math.radians(stop), abs=1e-4)


def test_the_eyelid_stops_where_it_is_shut_and_where_it_is_open():
    world = reset_world(FlatlandWorld(), 1)
    world.play(drive("eyelid", -1.0, 100))
    assert world.inner[EYELID] == 0.0
    assert not world.observe().any()  # shut: all black
    world.play(drive("eyelid", 1.0, 100))
    assert world.inner[EYELID] == 2.0


# ---- commuting -------------------------------------------------------------------------------------------------------------


@every_world
def test_the_identity_permutation_commutes(name):
    world = WORLDS[name]()
    n = len(world.dofs)
    for seed in range(3):
        start, rng = reset_world(world, seed).snapshot(), np.random.default_rng(seed)
        for sequence in [sample_sequence(rng, 50, k, n) for k in range(n)] + [
            sample_held_commands(rng, 50, n)
        ]:
            assert (
                mean_squared_error(*compare_orders(world, start, sequence, sequence[np.arange(50)]))
                == 0
            )


@pytest.mark.parametrize("dof", DOFS)
def test_free_space_commutes(dof):
    world, k = flatland(("free-space", "polyphemus")), DOFS.index(dof)
    for seed in range(25):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        start, sequence = world.snapshot(), sample_sequence(rng, 50, k, 8)
        first = final_observation(world, start, sequence)
        poses = world.poses()
        second = final_observation(world, start, permute(rng, sequence))
        assert mean_squared_error(first, second) == 0
        assert np.abs(world.poses() - poses).max() <= 1e-9


@pytest.mark.parametrize("dof", ["move", "eyelid"])
def test_a_free_corridor_commutes(dof):
    world = reset_world(Corridor())
    k, start = ["move", "eyelid"].index(dof), world.snapshot()
    for seed in range(25):
        rng = np.random.default_rng(seed)
        assert (
            mean_squared_error(*sc_experiment(world, start, sample_sequence(rng, 50, k, 2), rng))
            == 0
        )


@every_walled_pair
@pytest.mark.parametrize("dof", ["head", "eyelid"])
def test_head_and_eyelid_commute_in_every_room(pair, dof):
    world, k = flatland(pair), DOFS.index(dof)
    for seed in range(8):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        assert (
            mean_squared_error(
                *sc_experiment(world, world.snapshot(), sample_sequence(rng, 50, k, 8), rng)
            )
            == 0
        )


@pytest.mark.parametrize(("dof", "place"), [("head", HEAD), ("eyelid", EYELID)])
def test_head_and_eyelid_end_in_the_very_same_place(dof, place):
    """To the last bit, not only to the pixel: sums of commands do not depend on their order."""
    world, k = reset_world(FlatlandWorld()), DOFS.index(dof)
    start = world.snapshot()
    for seed in range(25):
        rng = np.random.default_rng(seed)
        sequence, ends = sample_sequence(rng, 50, k, 8), set()
        for order in (sequence, permute(rng, sequence), sequence[::-1]):
            world.restore(start)
            world.play(order)
            ends.add(world.inner[place])
        assert len(ends) == 1


def test_a_furnished_room_does_not_always_commute():
    world, distances = flatland(("furnished", "polyphemus")), []
    for seed in range(25):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        distances.append(
            mean_squared_error(
                *sc_experiment(world, world.snapshot(), sample_sequence(rng, 50, 0, 8), rng)
            )
        )
    assert any(distance > 0 for distance in distances)
    assert any(distance == 0 for distance in distances)


@pytest.mark.parametrize("still", ["head", "eyelid"])
@pytest.mark.parametrize("dof", DOFS)
def test_what_displaces_nothing_commutes_with_everything(still, dof):
    """Philipona's conjecture (paper, section II-C), in a walled room in which nothing moves by itself."""
    world = FlatlandWorld(EMPTY)
    for seed in range(6):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        h = sample_sequence(rng, 20, DOFS.index(still), 8)
        g = sample_sequence(rng, 60, DOFS.index(dof), 8)
        assert mean_squared_error(*commutation_experiment(world, world.snapshot(), h, g)) == 0


# ---- walls -----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forwards", "backwards"])
@pytest.mark.parametrize(
    ("x", "y", "towards"),
    [(300, 212, -math.pi / 2), (300, 588, math.pi / 2), (212, 400, math.pi), (388, 400, 0.0)],
    ids=["bottom", "top", "left", "right"],
)
def test_blocked_motion_is_lost(x, y, towards, sign):
    """30 steps of 8 units towards a wall 182 away and back are not the same as back and there: nothing is caught up."""
    there, back = drive("base-longitudinal", sign, 30), drive("base-longitudinal", -sign, 30)
    world = enter(EMPTY, x, y, towards if sign > 0 else towards + math.pi)
    start, place = world.snapshot(), world.poses()[0]

    def gone() -> float:
        """How far from the start, towards the wall."""
        return float((world.poses()[0, :2] - place[:2]) @ (math.cos(towards), math.sin(towards)))

    world.play(compose(back[:22], there[:22], no_op(REST_STEPS, 8)))
    assert world.poses()[0] == pytest.approx(place, abs=1e-3)  # nothing was in the way
    world.restore(start)
    world.play(there)
    assert gone() == pytest.approx(182, abs=4)
    world.play(compose(back[:22], no_op(REST_STEPS, 8)))
    assert gone() == pytest.approx(
        182 - 22 * 8, abs=5
    )  # from the wall; had the 58 units that it swallowed been caught up, 240 - 176


@pytest.mark.parametrize(
    ("joint", "link", "x", "aside", "radius"),
    [("shoulder", 1, 265, 85, 25), ("elbow", 2, 307, 98, 15)],
)
@pytest.mark.parametrize("side", ["left", "right"])
def test_an_arm_s_blocked_motion_is_lost(side, joint, link, x, aside, radius):
    """An arm that was turned against a fixed disc, however long, comes off it as soon as it is turned back."""
    sign, link = (1, link) if side == "left" else (-1, link + 2)
    world = enter(
        FREE_SPACE,
        300,
        400,
        0.0,
        [
            {
                "vertices": 0,
                "radius": radius,
                "colour": (255, 0, 0),
                "pose": (x, 400 + sign * aside, 0.0),
            }
        ],
    )
    start = world.poses()[link, 2]
    world.play(drive(f"{side}-{joint}", 1.0, 40))  # 10 rad, were nothing in the way
    blocked = sign * (world.poses()[link, 2] - start)
    assert 0.2 < blocked < 1.5
    world.play(compose(drive(f"{side}-{joint}", -1.0, 8), no_op(REST_STEPS, 8)))
    assert sign * (world.poses()[link, 2] - start) == pytest.approx(blocked - 8 * 0.25, abs=0.05)


@pytest.mark.parametrize("value", [1.0, -1.0])
def test_the_base_does_not_enter_a_wall(value):
    deepest = 0.0
    for heading in np.linspace(-math.pi, math.pi, 16, endpoint=False):
        world = enter(EMPTY, 300, 400, heading)
        for action in drive("base-longitudinal", value, 100):
            world.step(action)
            x, y = world.poses()[0, :2]
            deepest = max(
                deepest, 30 - x, x - 570, 30 - y, y - 770
            )  # base radius 25, walls 5 thick on the inner side
    assert (
        -1.0 < deepest < 4.0
    )  # it reached a wall, and Chipmunk lets bodies overlap a little while they are pressed on


def depth_in_walls(world: FlatlandWorld) -> float:
    """How far the base or an end of an arm's segment is inside a wall; negative where nothing is."""
    poses, half = world.poses(), world.agent.arm_length / 2
    along = half * np.stack([np.cos(poses[1:5, 2]), np.sin(poses[1:5, 2])], 1)
    points = np.concatenate([poses[:1, :2], poses[1:5, :2] + along, poses[1:5, :2] - along])
    reach = world.room.wall_thickness / 2 + np.array([world.agent.base_radius] + [0.0] * 8)[:, None]
    return float(
        max((reach - points).max(), (points + reach - [world.room.width, world.room.height]).max())
    )


@every_walled_pair
def test_no_wall_is_passed(pair):
    """All degrees of freedom at full speed for long; then at rest, when the walls have had time to push everything out."""
    world, pressed = flatland(pair), -math.inf
    for seed in range(4):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        for _ in range(15):
            actions = sample_held_commands(rng, 10, 8)
            actions[:, 0] = 1.0  # into whatever is ahead
            for action in actions:
                world.step(action)
                pressed = max(pressed, depth_in_walls(world))
        world.play(no_op(60, 8))
        assert depth_in_walls(world) < 0.5
        poses = world.poses()
        joints = np.diff(poses[[0, 1, 2, 0, 3, 4], 2])[[0, 1, 3, 4]]
        assert (
            np.abs(poses[:5, :2] - forward_kinematics(world.agent, *poses[0], joints)[:, :2]).max() < 1.0
        )  # the arms are still in their joints
    assert 0 < pressed < world.room.wall_backing  # walls were run into, and are thicker than that


@every_walled_pair
def test_nothing_leaves_the_room(pair):
    world = flatland(pair)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        world.reset(rng)
        for _ in range(10):
            world.play(sample_sequence(rng, 20, 0, 8) + sample_sequence(rng, 20, 1, 8))
            middles = world.poses()[np.r_[0, N_LINKS : N_LINKS + world.room.things], :2]
            assert (middles > 5).all() and (
                middles < np.array([world.room.width, world.room.height]) - 5
            ).all()
