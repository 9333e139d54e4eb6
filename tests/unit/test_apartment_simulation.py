"""The robots on PyBullet: what touches nothing commutes, what is blocked is lost, and a replay is exact."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from sensory_commutativity.worlds.apartment.geometry import box
from sensory_commutativity.worlds.apartment.physics.simulation import Simulation
from sensory_commutativity.worlds.apartment.physics.starts import draw_start
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import (
    Area,
    Fixture,
    Movable,
    Part,
    Scene,
    Solid,
)
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene

CONFIG = Path(__file__).parents[2] / "config"
ROOM = (Area("room", (-2, 2), (-2, 2)),)
EMPTY = Scene("empty", (), (), ROOM)
REST = 3


def made(name: str, scene: Scene = EMPTY) -> Simulation:
    return Simulation(scene, load_robot(CONFIG / "robots" / f"{name}.yaml"))


@pytest.fixture(scope="module", params=["fetch", "jackrabbot"])
def robot(request):
    simulation = made(request.param)
    yield simulation
    simulation.close()


@pytest.fixture(scope="module")
def fetch():
    simulation = made("fetch")
    yield simulation
    simulation.close()


@pytest.fixture(scope="module")
def home():
    simulation = made("fetch", load_scene(CONFIG / "apartments" / "rs-stand-in.yaml"))
    yield simulation
    simulation.close()


def begin(simulation: Simulation, base=(0.0, 0.0, 0.0)):
    simulation.place(np.array(base), simulation.robot.start_ranges.mean(1))
    simulation.settle()
    return simulation.snapshot()


def play(simulation: Simulation, start, actions: np.ndarray) -> None:
    simulation.restore(start)
    for action in np.concatenate([actions, np.zeros((REST, actions.shape[1]))]):
        simulation.step(action)


def state(simulation: Simulation) -> np.ndarray:
    return np.concatenate(
        [
            simulation.base(),
            simulation.joints(),
            simulation.poses().ravel(),
            simulation.object_shifts(),
        ]
    )


def test_what_touches_nothing_commutes(robot):
    rng = np.random.default_rng(4)
    start = begin(robot)
    for k, dof in enumerate(robot.robot.dofs):
        actions = np.zeros((20, len(robot.robot.dofs)))
        actions[:, k] = rng.uniform(-1, 1, 20)
        ends = []
        for order in (actions, actions[rng.permutation(20)]):
            play(robot, start, order)
            ends.append(state(robot))
            assert not any(robot.touches()[1:])
        assert np.abs(ends[0] - ends[1]).max() < 1e-5, dof.name  # hundredths of a millimetre
        assert np.abs(ends[0] - state_of(robot, start)).max() > 1e-3, dof.name  # it did move


def state_of(simulation: Simulation, start) -> np.ndarray:
    simulation.restore(start)
    return state(simulation)


def test_an_action_moves_what_it_commands(robot):
    start = begin(robot)
    before = np.concatenate([robot.base(), robot.joints()])
    names = [joint.name for joint in robot.robot.joints]
    for k, dof in enumerate(robot.robot.description.dofs):
        if dof.group == "wheel":
            continue
        actions = np.zeros((3, len(robot.robot.dofs)))
        actions[:, k] = -0.5
        play(robot, start, actions)
        moved = np.concatenate([robot.base(), robot.joints()]) - before
        own = 3 + names.index(dof.joints[0])
        assert moved[own] == pytest.approx(-0.15 * dof.velocity, abs=1e-3)
        assert np.abs(np.delete(moved, own)).max() < 1e-3


@pytest.mark.parametrize(
    ("right", "left"), [(1.0, 0.0), (0.0, 1.0), (0.8, 0.8), (-0.6, 0.6), (0.7, -0.2)]
)
def test_wheels_drive_the_exact_arc(robot, right, left):
    begin(robot, (0.2, -0.1, 0.4))
    x, y, heading = robot.base()
    drive, speed = robot.robot.description.drive, robot.robot.description.dofs[0].velocity
    actions = np.zeros((15, len(robot.robot.dofs)))
    actions[:, :2] = right, left
    play(robot, robot.snapshot(), actions)
    forward = drive.wheel_radius * speed * (right + left) / 2 * 1.5
    turn = drive.wheel_radius * speed * (right - left) / drive.track * 1.5
    if abs(turn) > 1e-9:
        x += forward / turn * (math.sin(heading + turn) - math.sin(heading))
        y -= forward / turn * (math.cos(heading + turn) - math.cos(heading))
    else:
        x, y = x + forward * math.cos(heading), y + forward * math.sin(heading)
    assert robot.base() == pytest.approx((x, y, heading + turn), abs=1e-5)


def test_the_base_holds_still_while_the_arm_swings(fetch):
    start = begin(fetch)
    actions = np.zeros((30, 10))
    actions[:, 3] = np.random.default_rng(5).choice([-1.0, 1.0], 30)
    play(fetch, start, actions)
    assert np.abs(fetch.base()).max() < 1e-4


def wall(x: float) -> Fixture:
    return Fixture(
        "wall",
        (Part(box((0.05, 1, 1)), (1, 1, 1)),),
        (Solid("box", (0.05, 1.0, 1.0), (x + 0.05, 0.0, 1.0)),),
    )


@pytest.mark.parametrize(("dof", "heading"), [("right-wheel", 0.0), ("shoulder-pan", math.pi / 2)])
def test_what_is_blocked_is_lost_and_not_caught_up(dof, heading):
    """Into the wall and back ends elsewhere than back and into the wall; and the base does not go through."""
    simulation = made(
        "fetch", Scene("walled", (wall(0.38 if dof == "right-wheel" else 0.45),), (), ROOM)
    )
    names = [d.name for d in simulation.robot.dofs]
    joints = simulation.robot.start_ranges.mean(1)
    if dof == "right-wheel":
        joints = np.where(
            [j.name == "shoulder_pan_joint" for j in simulation.robot.joints], 1.5, joints
        )  # the arm aside
    simulation.place(np.array([0.0, 0.0, heading]), joints)
    assert not simulation.penetrates()
    simulation.settle()
    start = simulation.snapshot()
    actions = np.zeros((12, 10))
    actions[:6, names.index(dof)], actions[6:, names.index(dof)] = -1.0, 1.0
    if dof == "right-wheel":
        actions[:, 1] = actions[:, 0]
        actions *= -0.5
    ends = []
    for order in (actions, actions[::-1]):
        play(simulation, start, order)
        ends.append(np.concatenate([simulation.base(), simulation.joints()]))
        if order is actions:
            assert simulation.touches().fixed > 0
    assert np.abs(ends[0] - ends[1]).max() > 0.05
    simulation.close()


def test_a_box_is_pushed_and_told(fetch):
    thing = Movable(
        "box",
        "box",
        2.0,
        (Part(box((0.15, 0.15, 0.15)), (1, 1, 1)),),
        (Solid("box", (0.15, 0.15, 0.15)),),
        (0.6, 0.0, 0.151),
    )
    simulation = made("fetch", Scene("boxed", (), (thing,), ROOM))
    actions = np.zeros((6, 10))
    actions[:, :2] = 0.5
    play(simulation, begin(simulation), actions)
    touches = simulation.touches()
    assert (
        touches.movable > 0
        and touches.fixed == 0
        and simulation.object_shifts()[0] == pytest.approx(0.32 - 0.18, abs=0.1)
    )
    simulation.close()


def test_a_replay_is_exact_and_independent_of_what_happened_before(home):
    rng = np.random.default_rng(8)
    draw_start(home, rng, within=0.1)
    base, joints = home.base(), home.joints()
    home.place(base, joints)
    home.settle()
    start = home.snapshot()
    for k in (0, 1, 3, 4, 6):
        actions = np.zeros((25, 10))
        actions[:, k] = rng.uniform(-1, 1, 25)
        play(home, start, actions)
        first, touched = state(home), home.touches()
        play(home, start, -actions)
        play(home, start, actions)
        assert np.array_equal(first, state(home)) and touched == home.touches()
    again = made("fetch", home.scene)
    again.place(base, joints)
    again.settle()
    fresh = again.snapshot()
    play(home, start, actions)
    play(again, fresh, actions)
    assert np.array_equal(state(home), state(again))
    again.close()


def test_misuse_is_refused(fetch, robot):
    start = begin(fetch)
    other = made("fetch")
    with pytest.raises(ValueError, match="of another simulation"):
        other.restore(start)
    other.close()
    with pytest.raises(ValueError, match="an action has 10 elements"):
        fetch.step(np.zeros(3))
    with pytest.raises(ValueError, match="not finite"):
        fetch.step(np.full(10, np.nan))
