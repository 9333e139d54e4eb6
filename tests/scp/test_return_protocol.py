"""The return protocol: known answers in the corridor and in Flatland, and what it asks for."""

from __future__ import annotations

import numpy as np
import pytest

from sensory_commutativity import ArgumentError, Corridor, mean_squared_error
from sensory_commutativity.scp.experiment import compare_orders
from sensory_commutativity.scp.return_protocol import (
    compare_legs,
    known_inverses,
    play_trial,
    trials_per_dof,
    wander,
)
from sensory_commutativity.scp.world import SteppableWorld
from sensory_commutativity.worlds.flatland.world import FlatlandWorld
from tests.helpers import EMPTY, FREE_SPACE, drive, make_world, reset_world


class OnlySteps:
    """A corridor that can be commanded and observed, and nothing else."""

    def __init__(self, **options):
        self._world = Corridor(**options)
        self.dofs = self._world.dofs

    def step(self, action):
        self._world.step(action)

    def observe(self):
        return self._world.observe()


def moves(*steps: float) -> np.ndarray:
    return np.array([[step, 0.0] for step in steps])


def test_where_nothing_is_touched_all_views_are_those_of_the_restored_protocol() -> None:
    world = reset_world(FlatlandWorld(FREE_SPACE))
    rng = np.random.default_rng(1)
    for dof in ("base-longitudinal", "base-rotation", "head", "eyelid", "left-elbow"):
        sequence = drive(dof, 1.0, 20) * rng.uniform(-1, 1, (20, 1))
        permuted = sequence[rng.permutation(20)]
        start = world.snapshot()
        true = compare_orders(world, start, sequence, permuted)
        world.restore(start)
        legs = play_trial(world, sequence, permuted)
        assert np.array_equal(legs.first, true.first) and np.array_equal(legs.second, true.second)
        assert set(compare_legs(legs, mean_squared_error)) == {0.0}
        assert np.array_equal(world.observe(), legs.start)  # it came back


def test_known_answers_at_a_wall() -> None:
    """From cell 0 with a wall behind cell 1: of 1, 1, -1 the second step is blocked."""
    world = OnlySteps(wall=1)
    assert isinstance(world, SteppableWorld)
    legs = play_trial(world, moves(1, 1, -1), moves(1, -1, 1))
    cells = [int(view[0]) for view in legs]
    # h: 1, 1, 0; back (1, -1, -1): 1, 0, -1; p: 0, -1, 0; back: -1, 0, -1; p: 0, -1, 0
    assert cells == [0, 0, -1, 0, -1, 0]
    assert world.observe()[0] == -1
    found = compare_legs(legs, lambda a, b: float(abs(a[0] - b[0])))
    assert found == (0.0, 0.0, 1.0, 1.0)


def test_a_push_is_seen_and_the_same_order_again_is_not() -> None:
    """A box in cell 1: h pushes it two cells away; p, after the return, finds it gone."""
    legs = play_trial(OnlySteps(box=1), moves(1, 1, -1, -1), moves(-1, -1, 1, 1))
    boxes = [int(view[1]) for view in legs]
    assert boxes == [1, 3, 3, 3, 3, 3]
    found = compare_legs(legs, mean_squared_error)
    assert found.returned > 0 and found.distance == found.control == 0


def test_after_return_is_called_twice_and_the_last_return_can_be_left_out() -> None:
    called = []
    world = OnlySteps()
    legs = play_trial(
        world, moves(1, 1), moves(1, 1), after_return=lambda: called.append(world.observe()),
        come_back=False,
    )  # fmt: skip
    assert [int(view[0]) for view in called] == [0, 0]
    assert world.observe()[0] == legs.repeated[0] == 2


def test_a_blocked_base_does_not_come_back_in_flatland() -> None:
    """Towards a wall and back, and the reverse: the wall takes some of the first forward motion."""
    world = make_world(EMPTY, EMPTY.width - 170.0, 400.0, 0.0)
    forth = np.concatenate([drive("base-longitudinal", 1, 20), drive("base-longitudinal", -1, 20)])
    legs = play_trial(world, forth, forth[::-1].copy(), observe=world.poses)
    x = np.array([poses[0, 0] for poses in legs]) - legs.start[0, 0]
    assert (x[1:3] < -10).all() and np.ptp(x[2:]) < 0.1


def test_trials_can_be_chosen_and_are_the_same_then() -> None:
    world = reset_world(FlatlandWorld(EMPTY))
    every = dict(trials_per_dof(world, 5, 10, mean_squared_error))
    assert list(every) == [dof.name for dof in world.dofs]
    reset_world(world)
    assert dict(trials_per_dof(world, 5, 10, mean_squared_error, dofs=["head"])) == {
        "head": every["head"]
    }


def test_wandering_leads_elsewhere_and_leaves_the_eyelid_alone() -> None:
    world = reset_world(FlatlandWorld(EMPTY))
    before = world.poses(), world.controller_state
    wander(world, 3, 40)
    assert np.abs(world.poses()[0, :2] - before[0][0, :2]).max() > 1
    assert np.array_equal(world.controller_state[7:9], before[1][7:9])  # head and eyelid


def test_inverses_are_known_unless_a_world_says_otherwise() -> None:
    world = OnlySteps()
    assert known_inverses(world).tolist() == [True, True]
    world.has_inverse = lambda: [False, True]
    assert known_inverses(world).tolist() == [False, True]


def test_actions_are_checked() -> None:
    with pytest.raises(ArgumentError, match=r"sequence: expected an array of the shape"):
        play_trial(OnlySteps(), moves(1), np.zeros((3, 3)))
    with pytest.raises(ArgumentError, match=r"actions lie in \[-1, 1\]"):
        play_trial(OnlySteps(), moves(2), moves(1))
