"""SC-experiments on objects with ground truth, the test data of mask predictors.

The authors labelled fifty tuples of two pictures and two masks by hand (paper, section IV-A,
"Inference" and "Evaluation"); here the simulator provides the labels. The experiments drive one
degree of freedom with either of the paper's two kinds of sequences (appendix D): twenty random
actions against a permutation of them, or ten full-speed actions to the left and ten to the right
against the other order. Two alternatives that the paper discusses start from the same situation:
comparing the first picture with the last one, and returning to the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...scp.experiment import REST_STEPS, compare_orders, play_order
from ...scp.sequences import compose, permute, sample_sequence
from ...storage.arrays import pack_masks
from ..outcome import OUTCOMES, displaced_objects, label_pair
from .photometric import apply_camera_noise, sample_light
from .scene_sampler import SceneSampler, View

KINDS = ("random", "left-right")
"""Kinds of sequences."""
COMPARISONS = ("sc-experiment", "first-last", "return")
"""What is compared: the ends of both orders; the start and the end of the first order; the start
and the situation after the robot returned to it from the end of the first order."""
EXPERIMENTS_PER_LAYOUT = 20
"""Experiments with the same layout of objects. Chosen."""
MAX_RETURN_STEPS = 60
"""Steps within which the robot returns to its start. Chosen: three times as long as it was away."""
RETURN_TOLERANCE = 1e-4
"""Distance from its start, rad or m, within which a joint has returned. Chosen."""


class ObjectExperiment(NamedTuple):
    """An SC-experiment and, if they were played, its alternatives.

    Attributes
    ----------
    kind : str
        One of KINDS.
    views : tuple of pairs of View
        The two views that are compared, one pair for each of COMPARISONS that was played.
    displaced : tuple of int arrays
        Indices of the objects that moved between them.
    touched_fixed : bool
        Whether the robot touched a fixture in either of the two orders.
    touched_fixed_first : bool
        The same for the first order only.
    """

    kind: str
    views: tuple[tuple[View, View], ...]
    displaced: tuple[np.ndarray, ...]
    touched_fixed: bool
    touched_fixed_first: bool


class _Ending(NamedTuple):
    """What is recorded at the end of an order."""

    view: View
    object_poses: np.ndarray  # float64 (objects, 7)
    touched_fixed: bool


class ObjectExperimentRunner:
    """Plays SC-experiments with one degree of freedom in a cluttered scene.

    Parameters
    ----------
    sampler : SceneSampler
    dof : int
        Index of the degree of freedom.
    length : int
        Number of actions in a sequence; even.
    alternatives : bool
        Whether to play all of COMPARISONS, or only the first.
    rest_steps : int
        Steps without a command that end each order.
    """

    def __init__(
        self,
        sampler: SceneSampler,
        dof: int,
        length: int,
        alternatives: bool = False,
        rest_steps: int = REST_STEPS,
    ):
        self.sampler = sampler
        self.world = sampler.world
        self.simulation = sampler.simulation
        self.rng = sampler.rng
        self.dof, self.length, self.rest_steps = dof, length, rest_steps
        self.alternatives = alternatives

    def play(self) -> ObjectExperiment:
        """Play an experiment of a random kind in a new random situation."""
        self._sample_situation()
        kind = KINDS[int(self.rng.integers(len(KINDS)))]
        first, second = self._sample_orders(kind)
        start = self.world.snapshot()
        start_joints, begin = self.simulation.joints(), self._observe()
        ends = compare_orders(
            self.world, start, first, second, self.rest_steps, observe=self._observe
        )
        compared = [(ends.first, ends.second)]
        if self.alternatives:
            play_order(self.world, start, first, self.rest_steps)
            self._return_to(start_joints)
            compared += [(begin, ends.first), (begin, self._observe())]
        return ObjectExperiment(
            kind,
            views=tuple((a.view, b.view) for a, b in compared),
            displaced=tuple(displaced_objects(a.object_poses, b.object_poses) for a, b in compared),
            touched_fixed=ends.first.touched_fixed or ends.second.touched_fixed,
            touched_fixed_first=ends.first.touched_fixed,
        )

    def _sample_situation(self) -> None:
        """Place the robot near an object or anywhere, at rest."""
        simulation = self.simulation
        self.sampler.sample_situation(EXPERIMENTS_PER_LAYOUT)
        # placing it once more restores the objects, so that rejected situations leave no trace
        simulation.reset(simulation.base(), simulation.joints())
        simulation.settle()

    def _sample_orders(self, kind: str) -> tuple[np.ndarray, np.ndarray]:
        """Sample the two orders of an experiment: float64 (length, n_dofs) each."""
        n_dofs = len(self.world.dofs)
        if kind == "random":
            sequence = sample_sequence(self.rng, self.length, self.dof, n_dofs)
            return sequence, permute(self.rng, sequence)
        left = np.zeros((self.length // 2, n_dofs))
        left[:, self.dof] = 1.0
        return compose(left, -left), compose(-left, left)

    def _observe(self) -> _Ending:
        view = self.sampler.render_view(light=sample_light(self.rng))
        touched_fixed = self.simulation.contact_counts().fixed > 0
        return _Ending(view, self.simulation.objects.poses(), touched_fixed)

    def _return_to(self, start_joints: np.ndarray) -> None:
        """Drive the degree of freedom back to its start, unless something is in the way."""
        robot, world = self.simulation.robot, self.world
        moved_joint = robot.description.dofs[self.dof].joints[0]
        joint = [j.name for j in robot.joints].index(moved_joint)
        action = np.zeros(len(world.dofs))
        for _ in range(MAX_RETURN_STEPS):
            error = start_joints[joint] - self.simulation.joints()[joint]
            if abs(error) < RETURN_TOLERANCE:
                break
            action[self.dof] = np.clip(error / world.dofs[self.dof].speed, -1, 1)
            world.step(action)
        for _ in range(self.rest_steps):
            world.step(np.zeros(len(world.dofs)))


def assemble_tuples(
    experiments: Sequence[ObjectExperiment], sampler: SceneSampler
) -> dict[str, np.ndarray]:
    """Turn experiments into labelled pairs of noisy pictures.

    Parameters
    ----------
    experiments : sequence of ObjectExperiment
        n experiments with p comparisons each.
    sampler : SceneSampler
        The one that they were played with, with c cameras.

    Returns
    -------
    dict
        ``pictures`` uint8 (n, c, p, 2, h, w, 3); ``masks`` uint8 (n, c, p, 2, h, w / 8), packed;
        ``outcome`` int8 (n, c, p), indices into OUTCOMES; ``kind`` int8 (n,), indices into KINDS;
        ``touched_fixed`` and ``touched_fixed_first`` bool (n,); ``moved`` int16 (n, p), how many
        objects moved.
    """
    cameras, rng = sampler.cameras, sampler.rng
    pictures, masks, outcomes = [], [], []
    for experiment in experiments:
        for k, camera in enumerate(cameras):
            for (a, b), displaced in zip(experiment.views, experiment.displaced, strict=True):
                pair = a.pictures[k], b.pictures[k]
                outcome, mask = label_pair(*pair, a.camera_pose, b.camera_pose, displaced, camera)
                pictures.append(np.stack([apply_camera_noise(view.rgb, rng) for view in pair]))
                masks.append(pack_masks(mask))
                outcomes.append(OUTCOMES.index(outcome))
    shape = len(experiments), len(cameras), len(experiments[0].views)
    n_moved = [[len(displaced) for displaced in e.displaced] for e in experiments]
    return dict(
        pictures=np.stack(pictures).reshape(*shape, *pictures[0].shape),
        masks=np.stack(masks).reshape(*shape, *masks[0].shape),
        outcome=np.array(outcomes, np.int8).reshape(shape),
        kind=np.array([KINDS.index(e.kind) for e in experiments], np.int8),
        touched_fixed=np.array([e.touched_fixed for e in experiments]),
        touched_fixed_first=np.array([e.touched_fixed_first for e in experiments]),
        moved=np.array(n_moved, np.int16),
    )
