"""Trials of the return protocol in apartments, each beside the experiment with a restored start.

A push against a wall turns the base, so that the return does not lead back. Where it did not, the
second order is also played after each of two corrections: driving back by odometry, and turning
until the camera sees the start again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd

from ....scp.experiment import orders_of_dof, play_order
from ....scp.return_protocol import play_trial
from ....seeding import generator, seed_for
from ....storage.columns import FLOAT, Column
from ...apartment.builders import (
    apartment_world,
    perceptual_features,
    settings_of_run,
)
from ...apartment.config import ApartmentRun
from ...config import Config
from ...declarations import Batched, Shards, table
from ..builders import apartment_runs, reset_free
from ..columns import DISTANCES, DOF, EXPERIMENT, WORLD

if TYPE_CHECKING:
    from ....worlds.apartment.world import ApartmentWorld

BACK = 0.002
"""Metres and rad within which a return led the base back. Chosen: below a pixel."""
PAIRS = {
    "reset": ("first", "true"),
    "distance": ("first", "second"),
    "control": ("second", "repeated"),
    "returned": ("start", "returned"),
    "waited": ("start", "returned_again"),
}
"""Column -> the two views whose distance it is."""


def _as_run(config: Config, run: str) -> ApartmentRun:
    chosen, length = apartment_runs(config)[run], config.apartment.sequence_length
    return ApartmentRun(chosen.robot, chosen.scene, "anywhere", length, chosen.experiments)


class Offset(NamedTuple):
    """How far a return ended from the start."""

    base: float  # m
    turn: float  # rad
    joint: float  # rad or m, the largest of all joints


class ApartmentTrials:
    """Trials of one robot in one scene.

    Parameters
    ----------
    world : ApartmentWorld
        With one camera.
    rest_steps : int
    features : object
        With a method ``distances`` of two arrays of images.
    """

    def __init__(self, world: ApartmentWorld, rest_steps: int, features: Any):
        self.world, self.rest_steps, self.features = world, rest_steps, features

    def play(self, seed: int, length: int, start: Any, k: int) -> tuple[float, ...]:
        """One trial of degree of freedom `k` from the snapshot `start`.

        Returns
        -------
        tuple of float
            The columns from reset to loop_closure.
        """
        world = self.world
        sequence, permuted = orders_of_dof(world, seed, length, k, start)
        play_order(world, start, permuted, self.rest_steps)
        true = world.observe()
        world.restore(start)
        base, joints = world.simulation.base(), world.simulation.joints()
        returns: list[tuple[Any, Offset]] = []

        def after_return() -> None:
            if not returns:  # a snapshot lets both corrections begin here
                returns.append((world.snapshot(), self._offset(base, joints)))

        legs = play_trial(
            world, sequence, permuted, self.rest_steps, None, after_return, come_back=False
        )
        views = {**legs._asdict(), "true": true}
        first = [views[a] for a, _ in PAIRS.values()]
        second = [views[b] for _, b in PAIRS.values()]
        returned, offset = returns[0]
        if max(offset.base, offset.turn) > BACK:  # otherwise there is nothing to correct
            corrected = self._correct(returned, permuted, base, legs.start)
            first += [legs.first] * len(corrected)
            second += corrected
        distances = self.features.distances(np.concatenate(first), np.concatenate(second))
        plain = tuple(map(float, distances[: len(PAIRS)]))
        others = tuple(map(float, distances[len(PAIRS) :])) or (plain[1],) * 2
        return (*plain, *offset, *others)

    def _correct(
        self, returned: Any, permuted: np.ndarray, base: np.ndarray, view: np.ndarray
    ) -> list[np.ndarray]:
        """Views at the end of the second order after each of the corrections."""
        from ....worlds.apartment.returning import drive_back, turn_to_view

        views = []
        for correct, target in ((drive_back, base), (turn_to_view, view)):
            self.world.restore(returned)
            correct(self.world, target)
            play_order(self.world, self.world.snapshot(), permuted, self.rest_steps)
            views.append(self.world.observe())
        return views

    def _offset(self, base: np.ndarray, joints: np.ndarray) -> Offset:
        """How far the robot is from its start."""
        moved = self.world.simulation.base() - base
        bent = self.world.simulation.joints() - joints
        endless = np.isinf(self.world.robot.limits).any(axis=1)
        bent = np.where(endless, np.angle(np.exp(1j * bent)), bent)
        turn = abs(float(np.angle(np.exp(1j * moved[2]))))
        return Offset(float(np.hypot(*moved[:2])), turn, float(np.abs(bent).max(initial=0.0)))


@table(
    title="Trials of the return protocol in apartments",
    columns=(
        WORLD,
        DOF,
        EXPERIMENT,
        *DISTANCES,
        Column("base_offset", FLOAT, "m", "distance of the base from its start after a return"),
        Column("turn_offset", FLOAT, "rad", "difference of its heading"),
        Column("joint_offset", FLOAT, "rad or m", "largest difference of a joint"),
        Column("odometry", FLOAT, "1", "as distance, driving back by odometry after the return"),
        Column("loop_closure", FLOAT, "1", "as distance, turning until the start is seen again"),
    ),
    shards=Shards(
        runs=lambda config: {
            name: run.experiments for name, run in apartment_runs(config).items()
        },
        settings=lambda config, run: settings_of_run(config, _as_run(config, run)),
        per_shard=lambda config: reset_free(config).experiments_per_job,
    ),
)  # fmt: skip
def reset_free_apartment(config: Config, run: str) -> Batched:
    """Play the trials of one robot in one scene; a unit is a start situation."""
    import torch

    torch.set_num_threads(1)
    chosen, length = apartment_runs(config)[run], config.apartment.sequence_length
    world = apartment_world(config, chosen.robot, chosen.scene, "anywhere")
    features = perceptual_features(config)
    trials = ApartmentTrials(world, config.apartment.rest_steps, features)

    def compute(start: int, stop: int) -> pd.DataFrame:
        rows = []
        for i in range(start, stop):
            seed = seed_for(config.seed, "reset-free", run, i)
            world.reset(generator(seed, "situation"))
            situation = world.snapshot()
            for k, dof in enumerate(world.dofs):
                rows.append((run, dof.name, i, *trials.play(seed, length, situation, k)))
        return pd.DataFrame(rows, columns=reset_free_apartment.column_names)

    return Batched(compute, size=2, metadata=features.metadata)
