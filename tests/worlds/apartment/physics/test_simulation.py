"""The simulation: free motion commutes, blocked motion is lost, and a replay is exact."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sensory_commutativity.worlds.apartment.physics.simulation import PARKED, Simulation
from sensory_commutativity.worlds.apartment.physics.snapshots import SimulationSnapshot
from sensory_commutativity.worlds.apartment.physics.starts import draw_start
from sensory_commutativity.worlds.apartment.robots.loading import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import Scene
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from tests.helpers import ROOT
from tests.worlds.apartment.examples import ROBOTS, make_fixture, make_object, make_scene

REST_STEPS = 3


def simulate(robot: str, scene: Scene | None = None) -> Simulation:
    return Simulation(scene or make_scene(), load_robot(ROBOTS / f"{robot}.yaml"))


@pytest.fixture(scope="module", params=["fetch", "jackrabbot"])
def simulation(request):
    """Each shipped robot in empty space."""
    simulation = simulate(request.param)
    yield simulation
    simulation.close()


@pytest.fixture(scope="module")
def fetch():
    simulation = simulate("fetch")
    yield simulation
    simulation.close()


@pytest.fixture(scope="module")
def home():
    """Fetch in a furnished apartment."""
    simulation = simulate("fetch", load_scene(ROOT / "config" / "apartments" / "rs-stand-in.yaml"))
    yield simulation
    simulation.close()


def start_at(simulation: Simulation, base=(0.0, 0.0, 0.0)) -> SimulationSnapshot:
    simulation.reset(np.array(base), simulation.robot.start_ranges.mean(1))
    simulation.settle()
    return simulation.snapshot()


def replay(simulation: Simulation, start: SimulationSnapshot, actions: np.ndarray) -> np.ndarray:
    """Play the actions and some rest steps from a snapshot; return everything measurable."""
    simulation.restore(start)
    for action in np.concatenate([actions, np.zeros((REST_STEPS, actions.shape[1]))]):
        simulation.step(action)
    return measure(simulation)


def measure(simulation: Simulation) -> np.ndarray:
    arrays = (
        simulation.base(),
        simulation.joints(),
        simulation.poses().ravel(),
        simulation.objects.displacements(),
    )
    return np.concatenate(arrays)


def test_free_motion_commutes(simulation):
    rng, n_dofs = np.random.default_rng(4), len(simulation.robot.dofs)
    start = start_at(simulation)
    before = measure(simulation)
    for k, dof in enumerate(simulation.robot.dofs):
        actions = np.zeros((20, n_dofs))
        actions[:, k] = rng.uniform(-1, 1, 20)
        ends = []
        for order in (actions, actions[rng.permutation(20)]):
            ends.append(replay(simulation, start, order))
            assert not any(simulation.contact_counts()[1:]), dof.name
        assert np.abs(ends[0] - ends[1]).max() < 1e-5, dof.name  # m, rad
        assert np.abs(ends[0] - before).max() > 1e-3, dof.name  # it did move


def test_an_action_moves_only_what_it_commands(simulation):
    start = start_at(simulation)
    before = np.concatenate([simulation.base(), simulation.joints()])
    names = [joint.name for joint in simulation.robot.joints]
    for k, dof in enumerate(simulation.robot.description.dofs):
        if dof.group == "wheel":
            continue
        actions = np.zeros((3, len(simulation.robot.dofs)))
        actions[:, k] = -0.5
        replay(simulation, start, actions)
        moved = np.concatenate([simulation.base(), simulation.joints()]) - before
        own = 3 + names.index(dof.joints[0])
        assert moved[own] == pytest.approx(-0.15 * dof.velocity, abs=1e-3), dof.name
        assert np.abs(np.delete(moved, own)).max() < 1e-3, dof.name


def test_wheels_drive_the_exact_arc(simulation):
    description = simulation.robot.description
    speed = description.drive.wheel_radius * description.dofs[0].velocity  # m/s
    start = start_at(simulation, (0.2, -0.1, 0.4))
    x, y, heading = simulation.base()
    for right, left in [(1.0, 0.0), (0.0, 1.0), (0.8, 0.8), (-0.6, 0.6), (0.7, -0.2)]:
        actions = np.zeros((15, len(simulation.robot.dofs)))
        actions[:, :2] = right, left
        replay(simulation, start, actions)
        forward = speed * (right + left) / 2 * 1.5
        turn = speed * (right - left) / description.drive.track * 1.5
        if abs(turn) > 1e-9:
            end_x = x + forward / turn * (math.sin(heading + turn) - math.sin(heading))
            end_y = y - forward / turn * (math.cos(heading + turn) - math.cos(heading))
        else:
            end_x, end_y = x + forward * math.cos(heading), y + forward * math.sin(heading)
        expected = pytest.approx((end_x, end_y, heading + turn), abs=1e-5)
        assert simulation.base() == expected, (right, left)


def test_the_base_holds_still_while_the_arm_swings(fetch):
    start = start_at(fetch)
    actions = np.zeros((30, 10))
    actions[:, 3] = np.random.default_rng(5).choice([-1.0, 1.0], 30)
    replay(fetch, start, actions)
    assert np.abs(fetch.base()).max() < 1e-4


def test_blocked_motion_is_lost_and_not_caught_up():
    """Into a wall and back ends elsewhere than back and into the wall."""
    for dof, heading, distance in (("right-wheel", 0.0, 0.38), ("shoulder-pan", math.pi / 2, 0.45)):
        wall = make_fixture("wall", (0.05, 1.0, 1.0), (distance + 0.05, 0.0, 1.0))
        simulation = simulate("fetch", make_scene((wall,)))
        names = [d.name for d in simulation.robot.dofs]
        joints = simulation.robot.start_ranges.mean(1)
        actions = np.zeros((12, 10))
        actions[:6, names.index(dof)], actions[6:, names.index(dof)] = -1.0, 1.0
        if dof == "right-wheel":
            actions[:, 1] = actions[:, 0]
            actions *= -0.5
            pan = [joint.name for joint in simulation.robot.joints].index("shoulder_pan_joint")
            joints[pan] = 1.5  # the arm aside
        simulation.reset(np.array([0.0, 0.0, heading]), joints)
        assert not simulation.collisions.robot_penetrates(), dof
        simulation.settle()
        start = simulation.snapshot()
        replay(simulation, start, actions)
        assert simulation.contact_counts().fixed > 0, dof
        first = np.concatenate([simulation.base(), simulation.joints()])
        replay(simulation, start, actions[::-1])
        second = np.concatenate([simulation.base(), simulation.joints()])
        assert np.abs(first - second).max() > 0.05, dof
        simulation.close()


def test_a_pushed_box_is_displaced_and_counted():
    simulation = simulate("fetch", make_scene((), (make_object("box", 0.15, (0.6, 0.0, 0.151)),)))
    actions = np.zeros((6, 10))
    actions[:, :2] = 0.5
    replay(simulation, start_at(simulation), actions)
    counts = simulation.contact_counts()
    assert counts.steps == 6 + REST_STEPS and counts.movable > 0 and counts.fixed == 0
    assert simulation.objects.displacements() == pytest.approx([0.32 - 0.18], abs=0.1)
    simulation.close()


def test_geometric_queries():
    table = make_fixture("table", (0.5, 0.5, 0.02), (-1.0, 0.0, 0.6))
    cube = make_object("cube", 0.1, (1.0, 1.0, 0.101))
    simulation = simulate("fetch", make_scene((table,), (cube,)))
    simulation.reset(np.array(PARKED), simulation.robot.start_ranges.mean(1))
    queries, objects = simulation.collisions, simulation.objects
    assert queries.surface_below(-1.0, 0.0, 1.0) == pytest.approx(0.62, abs=1e-3)
    assert queries.surface_below(0.0, 0.0, 1.0) == pytest.approx(0.0, abs=1e-3)
    assert queries.surface_below(1.0, 1.0, 1.0) is None  # the cube is in between
    assert queries.nearest_fixture(1.0) == (1.0, None) and queries.clearance(1.0) == 1.0
    assert not queries.object_penetrates(0)
    objects.place(0, np.array([-1.0, 0.0, 0.65, 0.0, 0.0, 0.0, 1.0]))
    assert queries.object_penetrates(0) and not queries.object_penetrates(0, 0.2)
    assert objects.displacements() == pytest.approx([np.linalg.norm([2.0, 1.0, 0.55])], abs=0.01)

    joints = simulation.robot.start_ranges.mean(1)
    assert not simulation.fits(np.array([-1.0, 0.0, 0.0]), joints)  # inside the table
    assert simulation.fits(np.array([0.2, 0.0, 0.0]), joints)
    distance, index = queries.nearest_fixture(2.0)
    assert 0.3 < distance < 0.7 and index == 0
    objects.place(0, np.array([0.2, 0.8, 0.101, 0.0, 0.0, 0.0, 1.0]))
    assert queries.clearance(2.0) < distance  # the cube is nearer than the table
    simulation.close()


def test_a_replay_is_exact_and_independent_of_the_past(home):
    rng = np.random.default_rng(8)
    draw_start(home, rng, within=0.1)
    base, joints = home.base(), home.joints()
    home.reset(base, joints)
    home.settle()
    start = home.snapshot()
    for k in (0, 1, 3, 4, 6):
        actions = np.zeros((25, 10))
        actions[:, k] = rng.uniform(-1, 1, 25)
        first, counts = replay(home, start, actions), home.contact_counts()
        replay(home, start, -actions)
        assert np.array_equal(first, replay(home, start, actions)), k
        assert counts == home.contact_counts(), k
    other = simulate("fetch", home.scene)
    other.reset(base, joints)
    other.settle()
    fresh = other.snapshot()
    assert np.array_equal(replay(home, start, actions), replay(other, fresh, actions))
    with pytest.raises(ValueError, match="of another simulation"):
        other.restore(start)
    other.close()


def test_invalid_actions_are_rejected(fetch):
    with pytest.raises(ValueError, match="an action has 10 elements"):
        fetch.step(np.zeros(3))
    with pytest.raises(ValueError, match="not finite"):
        fetch.step(np.full(10, np.nan))
