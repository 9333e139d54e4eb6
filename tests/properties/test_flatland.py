"""Degrees of freedom, commutation and contacts in Flatland, for the agents of default.yaml."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensory_commutativity.scp.distances import mean_squared_error
from sensory_commutativity.scp.experiment import (
    REST_STEPS,
    commutation_experiment,
    compare_orders,
    play_order,
)
from sensory_commutativity.scp.sequences import compose, no_op, permute, sample_sequence
from sensory_commutativity.scp.world import World
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.agent import JOINT_NAMES, N_LINKS, Polyphemus
from sensory_commutativity.worlds.flatland.control import EYELID, HEAD, TARGET, TIME
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import (
    DOFS,
    EMPTY,
    FLATLAND_PAIRS,
    FREE_SPACE,
    WALLED_PAIRS,
    drive,
    forward_kinematics,
    make_flatland,
    make_world,
    reset_world,
    sample_held_commands,
)

AGENTS = {name: make_flatland((world, name)).agent for world, name in FLATLAND_PAIRS}

# ---- degrees of freedom --------------------------------------------------------------------------


def move(agent: Polyphemus, dof: str, value: float) -> tuple[np.ndarray, ...]:
    """Poses before and after one action in free space, and controller states before and after."""
    world = reset_world(FlatlandWorld(FREE_SPACE, agent), 6)
    poses, state = world.poses(), world.controller_state
    world.play(compose(drive(dof, value, 1), no_op(REST_STEPS, 8)))
    return poses, world.poses(), state, world.controller_state


def test_base_longitudinal_moves_along_the_heading():
    for name, agent in AGENTS.items():
        for value in (1.0, -0.5):
            before, after, state, new_state = move(agent, "base-longitudinal", value)
            heading, speed = before[0, 2], agent.dofs[0].speed
            direction = np.array([math.cos(heading), math.sin(heading), 0.0])
            # the arms come along
            assert np.allclose(after - before, value * speed * direction, atol=1e-5), name
            assert np.array_equal(new_state[[HEAD, EYELID]], state[[HEAD, EYELID]]), name


def test_base_rotation_turns_on_the_spot():
    for name, agent in AGENTS.items():
        for value in (1.0, -0.5):
            before, after, state, new_state = move(agent, "base-rotation", value)
            x, y, heading = before[0]
            heading += value * agent.dofs[1].speed
            expected = forward_kinematics(agent, x, y, heading, agent.rest_angles)
            assert np.allclose(after, expected, atol=1e-3), name
            assert np.array_equal(new_state[[HEAD, EYELID]], state[[HEAD, EYELID]]), name


def test_head_and_eyelid_move_nothing_else():
    for name, agent in AGENTS.items():
        for dof, index, change in [("head", HEAD, 0.25), ("eyelid", EYELID, 0.05)]:  # authors
            for value in (1.0, -0.5):
                before, after, state, new_state = move(agent, dof, value)
                assert np.allclose(after, before, atol=1e-9), name
                difference = new_state - state
                assert difference[index] == pytest.approx(value * change, abs=1e-6), name
                assert not np.delete(difference, [index, TIME]).any(), name


def test_joints_turn_the_links_beyond_them():
    fixed_links = dict(
        zip(JOINT_NAMES, ([0, 3, 4], [0, 1, 3, 4], [0, 1, 2], [0, 1, 2, 3]), strict=True)
    )
    for name, agent in AGENTS.items():
        for j, joint in enumerate(JOINT_NAMES):
            for value in (1.0, -0.5):
                before, after, state, new_state = move(agent, joint, value)
                counter_clockwise = 1 if joint.startswith("left") else -1
                angles = agent.rest_angles.copy()
                angles[j] += counter_clockwise * value * agent.dofs[4 + j].speed
                expected = forward_kinematics(agent, *before[0], angles)
                assert np.allclose(after, expected, atol=1e-3), (name, joint)
                fixed = fixed_links[joint]
                assert np.allclose(after[fixed], before[fixed], atol=1e-9), (name, joint)
                assert np.array_equal(new_state[[HEAD, EYELID]], state[[HEAD, EYELID]])


def test_equal_actions_move_the_arms_as_mirror_images():
    for joint in ("shoulder", "elbow"):
        world = make_world(FREE_SPACE, 300, 400, 0.0)  # the mirror is the line y = 400
        actions = drive(f"left-{joint}", 0.7, 3) + drive(f"right-{joint}", 0.7, 3)
        world.play(compose(actions, no_op(3, 8)))
        left, right = world.poses()[1:3], world.poses()[3:5]
        assert np.allclose(left[:, 0], right[:, 0], atol=1e-6)
        assert np.allclose(left[:, 1] - 400, 400 - right[:, 1], atol=1e-6)
        assert np.allclose(left[:, 2], -right[:, 2], atol=1e-6)


def test_all_dofs_at_once_keep_the_linkage_together():
    for name, agent in AGENTS.items():
        world = reset_world(FlatlandWorld(FREE_SPACE, agent), 2)
        rng = np.random.default_rng(2)
        for _ in range(10):
            world.play(compose(sample_held_commands(rng, 20, 8), no_op(REST_STEPS, 8)))
            x, y, heading, *joints = world.controller_state[TARGET]
            expected = forward_kinematics(agent, x, y, heading, joints)
            assert np.allclose(world.poses(), expected, atol=1e-6), name


def test_joint_and_eyelid_stops():
    for value, stop in [(1.0, 60.0), (-1.0, -60.0)]:
        world = reset_world(make_flatland(("free-space", "joint-stops")), 1)
        world.play(compose(drive("left-shoulder", value, 30), no_op(3, 8)))
        poses = world.poses()
        turn = poses[1, 2] - poses[0, 2] - world.agent.rest_angles[0]
        assert turn == pytest.approx(math.radians(stop), abs=1e-4)
    world = reset_world(FlatlandWorld(), 1)
    world.play(drive("eyelid", -1.0, 100))
    assert world.controller_state[EYELID] == 0.0
    assert not world.observe().any()  # closed: all black
    world.play(drive("eyelid", 1.0, 100))
    assert world.controller_state[EYELID] == 2.0


# ---- commutation ---------------------------------------------------------------------------------


def random_experiment(world: World, seed: int, dof: int) -> float:
    """Distance of an SC-experiment of 50 actions from a random start."""
    rng = np.random.default_rng(seed)
    world.reset(rng)
    start, sequence = world.snapshot(), sample_sequence(rng, 50, dof, len(world.dofs))
    return mean_squared_error(*compare_orders(world, start, sequence, permute(rng, sequence)))


def test_free_space_commutes():
    """Observations are equal, and poses to 1e-9."""
    for k, dof in enumerate(Corridor.dofs):
        assert [random_experiment(Corridor(), seed, k) for seed in range(25)] == [0] * 25, dof
    world = make_flatland(("free-space", "polyphemus"))
    for k, dof in enumerate(world.dofs):
        for seed in range(25):
            rng = np.random.default_rng(seed)
            world.reset(rng)
            start, sequence = world.snapshot(), sample_sequence(rng, 50, k, 8)
            play_order(world, start, sequence)
            view, poses = world.observe(), world.poses()
            play_order(world, start, permute(rng, sequence))
            assert np.array_equal(world.observe(), view), dof
            assert np.abs(world.poses() - poses).max() <= 1e-9, dof


def test_head_and_eyelid_commute_in_every_room():
    for pair in WALLED_PAIRS:
        world = make_flatland(pair)
        for dof in ("head", "eyelid"):
            distances = [random_experiment(world, seed, DOFS.index(dof)) for seed in range(8)]
            assert distances == [0] * 8, (pair, dof)


def test_final_head_and_eyelid_are_bit_identical():
    """Sums of commands do not depend on their order, not even below a pixel."""
    world = reset_world(FlatlandWorld())
    start = world.snapshot()
    for dof, index in [("head", HEAD), ("eyelid", EYELID)]:
        for seed in range(25):
            rng = np.random.default_rng(seed)
            sequence, ends = sample_sequence(rng, 50, DOFS.index(dof), 8), set()
            for order in (sequence, permute(rng, sequence), sequence[::-1]):
                world.restore(start)
                world.play(order)
                ends.add(world.controller_state[index])
            assert len(ends) == 1, dof


def test_a_furnished_room_does_not_always_commute():
    world = make_flatland(("furnished", "polyphemus"))
    distances = [random_experiment(world, seed, 0) for seed in range(25)]
    assert any(distance > 0 for distance in distances)
    assert any(distance == 0 for distance in distances)


def test_dofs_that_displace_nothing_commute_with_all_dofs():
    """Philipona's conjecture (paper, section II-C), in a walled room without moving objects."""
    world = FlatlandWorld(EMPTY)
    for sensor_dof in ("head", "eyelid"):
        for k, dof in enumerate(DOFS):
            for seed in range(6):
                rng = np.random.default_rng(seed)
                world.reset(rng)
                h = sample_sequence(rng, 20, DOFS.index(sensor_dof), 8)
                g = sample_sequence(rng, 60, k, 8)
                outcome = commutation_experiment(world, world.snapshot(), h, g)
                assert mean_squared_error(*outcome) == 0, (sensor_dof, dof)


# ---- walls and contacts --------------------------------------------------------------------------


def test_blocked_motion_of_the_base_is_lost():
    """30 steps of 8 units towards a wall at 182, and back: nothing is made up for later."""
    starts = [
        (300, 212, -math.pi / 2), (300, 588, math.pi / 2), (212, 400, math.pi), (388, 400, 0.0),
    ]  # fmt: skip
    for x, y, direction in starts:
        for sign in (1.0, -1.0):
            approach, retreat = (drive("base-longitudinal", s * sign, 30) for s in (1.0, -1.0))
            world = make_world(EMPTY, x, y, direction if sign > 0 else direction + math.pi)
            start, base = world.snapshot(), world.poses()[0]
            towards = np.array([math.cos(direction), math.sin(direction)])
            world.play(compose(retreat[:22], approach[:22], no_op(REST_STEPS, 8)))
            assert world.poses()[0] == pytest.approx(base, abs=1e-3)  # nothing was in the way
            world.restore(start)
            world.play(approach)
            assert (world.poses()[0, :2] - base[:2]) @ towards == pytest.approx(182, abs=4)
            world.play(compose(retreat[:22], no_op(REST_STEPS, 8)))
            # from the wall, not from the 240 that were commanded
            distance = (world.poses()[0, :2] - base[:2]) @ towards
            assert distance == pytest.approx(182 - 22 * 8, abs=5), (x, y, sign)


def test_blocked_motion_of_an_arm_is_lost():
    """An arm that was pressed against a fixed disc leaves it as soon as it is turned back."""
    for joint, link, x, aside, radius in [("shoulder", 1, 265, 85, 25), ("elbow", 2, 307, 98, 15)]:
        for side, sign in [("left", 1), ("right", -1)]:
            i = link if side == "left" else link + 2
            disc = {"vertices": 0, "radius": radius, "colour": (255, 0, 0)}
            disc["pose"] = (x, 400 + sign * aside, 0.0)
            world = make_world(FREE_SPACE, 300, 400, 0.0, [disc])
            start = world.poses()[i, 2]
            world.play(drive(f"{side}-{joint}", 1.0, 40))  # 10 rad, if nothing were in the way
            blocked = sign * (world.poses()[i, 2] - start)
            assert 0.2 < blocked < 1.5, (side, joint)
            world.play(compose(drive(f"{side}-{joint}", -1.0, 8), no_op(REST_STEPS, 8)))
            turn = sign * (world.poses()[i, 2] - start)
            assert turn == pytest.approx(blocked - 8 * 0.25, abs=0.05), (side, joint)


def depth_in_walls(world: FlatlandWorld) -> float:
    """How deep the base or an end of an arm segment is inside a wall; negative outside."""
    poses, half = world.poses(), world.agent.arm_length / 2
    along = half * np.stack([np.cos(poses[1:5, 2]), np.sin(poses[1:5, 2])], 1)
    points = np.concatenate([poses[:1, :2], poses[1:5, :2] + along, poses[1:5, :2] - along])
    reach = world.room.wall_thickness / 2 + np.array([world.agent.base_radius] + [0.0] * 8)[:, None]
    size = np.array([world.room.width, world.room.height])
    return float(max((reach - points).max(), (points + reach - size).max()))


def test_the_base_does_not_enter_walls():
    for value in (1.0, -1.0):
        deepest = -math.inf
        for heading in np.linspace(-math.pi, math.pi, 16, endpoint=False):
            world = make_world(EMPTY, 300, 400, heading)
            for action in drive("base-longitudinal", value, 100):
                world.step(action)
                x, y = world.poses()[0, :2]  # base radius 25, inner half of the walls 5
                deepest = max(deepest, 30 - x, x - 570, 30 - y, y - 770)
        # it reaches a wall, and Chipmunk lets pressed bodies overlap a little
        assert -1.0 < deepest < 4.0


def test_no_wall_is_passed():
    """After long pressure and then rest, the walls have pushed everything out."""
    for pair in WALLED_PAIRS:
        world, deepest = make_flatland(pair), -math.inf
        for seed in range(4):
            rng = np.random.default_rng(seed)
            world.reset(rng)
            for _ in range(15):
                actions = sample_held_commands(rng, 10, 8)
                actions[:, 0] = 1.0
                for action in actions:
                    world.step(action)
                    deepest = max(deepest, depth_in_walls(world))
            world.play(no_op(60, 8))
            assert depth_in_walls(world) < 0.5, pair
            poses = world.poses()
            joints = poses[1:5, 2] - poses[[0, 1, 0, 3], 2]
            expected = forward_kinematics(world.agent, *poses[0], joints)
            # the arms are still in their joints
            assert np.abs(poses[:5, :2] - expected[:, :2]).max() < 1.0, pair
        # walls were hit, and are thicker than the penetration
        assert 0 < deepest < world.room.wall_backing, pair


def test_nothing_leaves_the_room():
    for pair in WALLED_PAIRS:
        world = make_flatland(pair)
        size = np.array([world.room.width, world.room.height])
        for seed in range(3):
            rng = np.random.default_rng(seed)
            world.reset(rng)
            for _ in range(10):
                world.play(sample_sequence(rng, 20, 0, 8) + sample_sequence(rng, 20, 1, 8))
                centres = world.poses()[np.r_[0, N_LINKS : N_LINKS + world.room.objects], :2]
                assert (centres > 5).all() and (centres < size - 5).all(), pair
