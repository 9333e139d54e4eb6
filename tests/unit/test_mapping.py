"""mapping/: places on a grid, what a swept arm meets, SC-experiments at a place."""

from __future__ import annotations

import numpy as np
import pytest
from sensory_commutativity.helpers import DEFAULT

from sensory_commutativity.change_detection.simulated.local_scp import experiments_at
from sensory_commutativity.change_detection.simulated.poses import Pose, grid_poses
from sensory_commutativity.change_detection.simulated.reach import (
    MOST,
    swept_reach,
    usual_excursion,
    usual_reach,
)
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment import geometry
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.robot import load_robot
from sensory_commutativity.worlds.apartment.scenes.scene import Area, Fixture, Part, Scene, Solid
from sensory_commutativity.worlds.apartment.world import ApartmentWorld

PAN = 3  # shoulder-pan of Fetch, in the order of its degrees of freedom


def block(name: str, half: tuple[float, float, float], at: tuple[float, float, float]) -> Fixture:
    return Fixture(
        name,
        (Part(geometry.placed(geometry.box(half), at), (0.7, 0.6, 0.5)),),
        (Solid("box", half, at),),
    )


@pytest.fixture(scope="module")
def world():
    """Fetch between a pillar to its left, which its arm hits when it sweeps there, and a low table ahead."""
    pillar, table = (
        block("pillar", (0.1, 0.1, 1.0), (0.55, 0.45, 1.0)),
        block("table", (0.3, 0.5, 0.2), (0.8, 0.0, 0.2)),
    )
    scene = Scene("two", (pillar, table), (), (Area("room", (-1.0, 1.0), (-1.0, 1.0)),))
    robot = load_robot(load(DEFAULT).apartment.robots["fetch"].description)
    found = ApartmentWorld(scene, robot, (Camera(64, 64, 90.0, 1),))
    yield found
    found.simulation.close()


def test_places_are_centred_in_every_room():
    scene = Scene(
        "rooms", (), (), (Area("a", (0.0, 1.0), (0.0, 2.1)), Area("b", (5.0, 5.2), (0.0, 1.0)))
    )
    found = grid_poses(scene, 0.5, 2)
    assert len(found) == 2 * (2 * 4 + 1 * 2)
    assert {place.x for place in found if place.room == "a"} == {0.25, 0.75}
    assert sorted({round(place.y, 3) for place in found if place.room == "a"}) == [
        0.3,
        0.8,
        1.3,
        1.8,
    ]
    assert {place.x for place in found if place.room == "b"} == {5.1} and {
        place.heading for place in found
    } == {0.0, np.pi}


def test_how_far_half_of_all_experiments_get_on_either_side():
    """The maximum of a long random walk is distributed as the magnitude of its end, .674 standard deviations in the median; two orders get on."""
    low, high = usual_excursion(1, 2.0, np.random.default_rng(0))
    assert (low, high) == pytest.approx((0, 0), abs=0.1)  # a single step goes up or down, not both
    assert usual_excursion(400, 2.0, np.random.default_rng(0)) == pytest.approx(
        2 * np.array(usual_excursion(400, 1.0, np.random.default_rng(0)))
    )
    low, high = usual_excursion(400, 1.0, np.random.default_rng(0))
    deviation = np.sqrt(400 / 3)
    assert 0.67 * deviation < high < 1.15 * deviation and low == pytest.approx(-high, rel=0.1)


def test_a_swept_arm_meets_what_is_in_its_way(world):
    joint = [one.name for one in world.robot.joints].index("shoulder_pan_joint")
    start = world.robot.start_ranges.mean(1)

    def swept(base, angle, start=start):
        return swept_reach(
            world.simulation, np.array(base), joint, (-angle, angle), ["table"], start
        )

    narrow, wide = swept([0.0, 0.0, 0.0], 0.05), swept([0.0, 0.0, 0.0], 1.0)
    assert narrow.clearance > 0 >= wide.clearance and wide.nearest == "pillar"
    assert narrow.over_low and wide.over_low
    away = swept([0.0, 0.0, np.pi], 0.05)
    assert away.clearance > narrow.clearance and not away.over_low
    assert swept([-50.0, 0.0, 0.0], 0.05) == (MOST, "", False)
    turned = start.copy()
    turned[joint] += 0.95
    assert swept([0.0, 0.0, 0.0], 0.05, turned).clearance <= 0  # it begins where the pillar is


def test_what_half_of_the_starts_meet_counts(world):
    joint = [one.name for one in world.robot.joints].index("shoulder_pan_joint")
    free = world.robot.start_ranges.mean(1)
    blocked = free.copy()
    blocked[joint] += 0.95

    def met(starts):
        return (
            usual_reach(
                world.simulation, np.zeros(3), joint, (-0.05, 0.05), ["table"], np.array(starts)
            ).clearance
            <= 0
        )

    assert met([free, blocked]) and met([blocked, free, blocked]) and not met([free, blocked, free])


def test_experiments_where_something_is_in_the_way_and_where_not(world):
    blocked = experiments_at(
        Pose("room", 0.0, 0.0, 0.45), world, PAN, 60, 6, np.random.default_rng(1)
    )
    free = experiments_at(
        Pose("room", -5.0, 0.0, np.pi), world, PAN, 60, 6, np.random.default_rng(1)
    )
    assert blocked.pictures.shape == (6, 2, 64, 64, 3) and blocked.pictures.dtype == np.uint8
    assert not free.different.any() and blocked.different.any()
    again = experiments_at(
        Pose("room", 0.0, 0.0, 0.45), world, PAN, 60, 6, np.random.default_rng(1)
    )
    assert np.array_equal(blocked.pictures, again.pictures)


def test_there_is_no_experiment_where_the_robot_cannot_stand(world):
    assert (
        experiments_at(Pose("room", 0.75, 0.0, 0.0), world, PAN, 10, 2, np.random.default_rng(1))
        is None
    )
