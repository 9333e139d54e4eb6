"""SC-experiments on objects, labelled by the simulator: what the mask predictor is tested on (paper, section IV-A, "Inference" and "Evaluation").

The authors labelled fifty tuples of two pictures and two masks by hand; the simulator knows what moved and where the robot ended. One degree of
freedom is driven, in both of the paper's ways: twenty random steps against a permutation of them, and ten steps to the left and ten to the right
against the other order. Two alternatives that the paper discusses are played from the same start: the first picture against the last, and going
back to where the robot started.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...scp.experiment import REST_STEPS
from ...scp.sequences import compose, no_op, permute, sample_sequence
from ...scp.world import play
from ...storage.arrays import pack
from ..outcome import OUTCOMES, outcome_of
from .photometric import apply_camera_noise, sample_light
from .scene_sampler import SceneSampler, View, displaced

KINDS = ("random", "left-right")
"""Kinds of sequences (paper, appendix D)."""
COMPARISONS = ("sc-experiment", "first-last", "return")
"""What is compared: both orders; the start and the end of the first order; the start, and the robot back there after the first order."""
EXPERIMENTS_PER_SCATTER = 20
BESIDE = 0.75
"""Of the situations, those with the hand beside an object; chosen: anywhere alone, few experiments move anything."""
RETURN_STEPS = 60
"""Most steps in which the robot goes back to where it started; chosen: three times as long as it was away."""
RETURNED = 1e-4
"""Rad or metres from its start within which a joint has returned."""


class Played(NamedTuple):
    """An SC-experiment, and what other ways of comparing pictures have to go by.

    Attributes
    ----------
    kind : str
        One of KINDS.
    views : tuple of View
        Of each of the COMPARISONS that were made, the two views that are compared.
    moved : tuple of int arrays
        And the objects that are elsewhere in one view than in the other.
    touched_fixed, touched_fixed_first : bool
        Whether the robot touched what does not move, in either order, and in the first.
    """

    kind: str
    views: tuple[tuple[View, View], ...]
    moved: tuple[np.ndarray, ...]
    touched_fixed: bool
    touched_fixed_first: bool


class ObjectExperiments:
    """Plays SC-experiments of one degree of freedom in a household.

    Parameters
    ----------
    household : SceneSampler
    dof : int
        Which degree of freedom is driven.
    length : int
        Steps of a sequence, an even number.
    alternatives : bool
        Whether to make all of the COMPARISONS; else only the first.
    """

    def __init__(self, household: SceneSampler, dof: int, length: int, alternatives: bool = False):
        self.household, self.world, self.rng = household, household.world, household.rng
        self.dof, self.length, self.alternatives = dof, length, alternatives
        self._since = EXPERIMENTS_PER_SCATTER

    def play(self) -> Played:
        """An experiment in a new situation, of either kind."""
        if self._since >= EXPERIMENTS_PER_SCATTER:
            self.household.scatter()
            self._since = 0
        self._since += 1
        self._begin()
        kind = KINDS[int(self.rng.integers(len(KINDS)))]
        one, other = self._orders(kind)
        simulation, n = self.household.simulation, len(self.world.dofs)
        start = self.world.snapshot()
        origin, begin, before = simulation.joints(), self._look(), simulation.object_poses()
        views, poses, touched = [], [], []
        for order in (one, other):
            self.world.restore(start)
            play(self.world, compose(order, no_op(REST_STEPS, n)))
            views.append(self._look())
            poses.append(simulation.object_poses())
            touched.append(simulation.touches().fixed > 0)
        compared, moved = [(views[0], views[1])], [displaced(*poses)]
        if self.alternatives:
            compared.append((begin, views[0]))
            moved.append(displaced(before, poses[0]))
            self.world.restore(start)
            play(self.world, compose(one, no_op(REST_STEPS, n)))
            self._go_back(origin)
            compared.append((begin, self._look()))
            moved.append(displaced(before, simulation.object_poses()))
        return Played(kind, tuple(compared), tuple(moved), any(touched), touched[0])

    def _look(self) -> View:
        return self.household.look(light=sample_light(self.rng))

    def _begin(self) -> None:
        """A situation: the robot with its hand beside an object, or anywhere."""
        simulation, household = self.household.simulation, self.household
        if self.rng.uniform() >= BESIDE or not household.begin_near_an_object():
            household.begin()
        simulation.place(
            simulation.base(), simulation.joints()
        )  # so that what was tried before makes no difference
        simulation.settle()

    def _orders(self, kind: str) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.world.dofs)
        if kind == "random":
            sequence = sample_sequence(self.rng, self.length, self.dof, n)
            return sequence, permute(self.rng, sequence)
        left = np.zeros((self.length // 2, n))
        left[:, self.dof] = 1.0
        return compose(left, -left), compose(-left, left)

    def _go_back(self, origin: np.ndarray) -> None:
        """Drive the degree of freedom to where its joint started, as far as nothing is in the way."""
        robot, simulation = self.household.simulation.robot, self.household.simulation
        joint = [j.name for j in robot.joints].index(robot.description.dofs[self.dof].joints[0])
        action = np.zeros(len(self.world.dofs))
        for _ in range(RETURN_STEPS):
            left = origin[joint] - simulation.joints()[joint]
            if abs(left) < RETURNED:
                break
            action[self.dof] = np.clip(left / self.world.dofs[self.dof].speed, -1, 1)
            self.world.step(action)
        play(self.world, no_op(REST_STEPS, len(self.world.dofs)))


def tuples_of(played: list[Played], household: SceneSampler) -> dict[str, np.ndarray]:
    """The tuples that the cameras of a household make of n experiments, with c cameras and p comparisons.

    Returns
    -------
    dict
        pictures uint8 (n, c, p, 2, h, w, 3), masks uint8 (n, c, p, 2, h, w / 8) packed, outcome int8 (n, c, p): indices into OUTCOMES, kind int8 (n,):
        in KINDS, touched_fixed and touched_fixed_first bool (n,), moved int16 (n, p): how many objects moved.
    """
    cameras, rng = household.cameras, household.rng
    pictures, masks, outcome = [], [], []
    for one in played:
        for k, camera in enumerate(cameras):
            for (first, second), moved in zip(one.views, one.moved, strict=True):
                a, b = first.pictures[k], second.pictures[k]
                what, true = outcome_of(a, b, first.eye, second.eye, moved, camera)
                pictures.append(
                    np.stack([apply_camera_noise(a.rgb, rng), apply_camera_noise(b.rgb, rng)])
                )
                masks.append(pack(true))
                outcome.append(OUTCOMES.index(what))
    shape = len(played), len(cameras), len(played[0].views)
    return dict(
        pictures=np.stack(pictures).reshape(*shape, *pictures[0].shape),
        masks=np.stack(masks).reshape(*shape, *masks[0].shape),
        outcome=np.array(outcome, np.int8).reshape(shape),
        kind=np.array([KINDS.index(one.kind) for one in played], np.int8),
        touched_fixed=np.array([one.touched_fixed for one in played]),
        touched_fixed_first=np.array([one.touched_fixed_first for one in played]),
        moved=np.array([[len(moved) for moved in one.moved] for one in played], np.int16),
    )
