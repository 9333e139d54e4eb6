"""SC-experiments whose second order is imagined by a forward model, beside the true one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from ....scp.experiment import compare_orders, orders_per_dof
from ....scp.sequences import compose, no_op, sample_sequence
from ....seeding import generator, seed_for
from ....storage.columns import FLOAT, TEXT, Column
from ...atlas.builders import build_environment
from ...config import Config
from ...declarations import Shards, table
from ..builders import imagined_runs
from ..columns import DOF, EXPERIMENT
from ..config import ImaginedConfig

if TYPE_CHECKING:
    from ....adapters.gymnasium import GymnasiumWorld
    from ..forward_model import Babbling

SEQUENCES_PER_START = 4
"""Sequences of the babbling between two resets: each begins where the last ended. Chosen."""
ENVIRONMENT = Column("environment", TEXT, "", "key of reset_free.imagined", key=True)


class ScaledSensors:
    """Sensors of an environment that move at all, in units of their spread.

    Parameters
    ----------
    world : GymnasiumWorld
    """

    def __init__(self, world: GymnasiumWorld):
        self._moves = np.isfinite(world.unit)
        self._unit = world.unit[self._moves]

    def scale(self, observation: np.ndarray) -> np.ndarray:
        return observation[self._moves] / self._unit


def known_commands(world: GymnasiumWorld, actions: np.ndarray) -> np.ndarray:
    """What a robot knows beforehand of its commands: actions, and what its control makes of them.

    Parameters
    ----------
    world : GymnasiumWorld
        Where the sequence will be played from; stays as it is.
    actions : float (steps, n)

    Returns
    -------
    float (steps, 2 n)
    """
    control, kept = world.control, world.control.state.copy()
    commands = np.asarray(control.commands(actions), float).reshape(len(actions), -1)
    control.state = kept
    return np.concatenate([actions, commands], axis=1)


def babble(world: GymnasiumWorld, settings: ImaginedConfig, seed: int) -> Babbling:
    """Random sequences of single degrees of freedom, each followed by a rest."""
    from ..forward_model import Babbling

    sensors, n = ScaledSensors(world), len(world.dofs)
    observations, commands = [], []
    for i in range(settings.sequences):
        rng = generator(seed, "babbling", i)
        if i % SEQUENCES_PER_START == 0:
            world.reset(rng)
        sequence = sample_sequence(rng, settings.length, int(rng.integers(n)), n)
        sequence = world.limit(world.snapshot(), sequence)
        played = compose(sequence, no_op(settings.rest_steps, n))
        commands.append(known_commands(world, played))
        seen = [sensors.scale(world.observe())]
        for action in played:
            world.step(action)
            seen.append(sensors.scale(world.observe()))
        observations.append(seen)
    return Babbling(np.array(observations), np.array(commands))


def root_mean_square(difference: np.ndarray) -> np.ndarray:
    """Over the last axis."""
    return np.sqrt((difference**2).mean(axis=-1))


@table(
    title="SC-experiments with an imagined order",
    columns=(
        ENVIRONMENT,
        DOF,
        EXPERIMENT,
        Column("true", FLOAT, "1", "distance of the ends of both orders, played"),
        Column("error", FLOAT, "1", "distance of the end of the first order, played and imagined"),
        Column(
            "score", FLOAT, "1", "of the first order, played, and of the second, imagined"
        ),
        Column("imagined", FLOAT, "1", "of the ends of both orders, both imagined"),
        Column("unchanged", FLOAT, "1", "of the end of the first order and of the start"),
        Column("touched", FLOAT, "1", "1 if bodies touched in an order", nullable=True),
    ),
    shards=Shards(
        runs=lambda config: {
            name: run.experiments for name, run in imagined_runs(config).items()
        },
        settings=lambda config, run: imagined_runs(config)[run],
    ),
)  # fmt: skip
def reset_free_imagined_experiments(config: Config, run: str) -> pd.DataFrame:
    """Train the model of one environment on babbling, and judge it at other starts.

    Distances are root mean squares in units of each sensor's spread.
    """
    import torch

    from ..forward_model import ForwardModel

    torch.set_num_threads(1)
    settings = imagined_runs(config)[run]
    world = build_environment(settings)
    seed = seed_for(config.seed, "imagined", run)
    model = ForwardModel(babble(world, settings, seed), settings.members, settings.epochs, seed)
    sensors, rest = ScaledSensors(world), no_op(settings.rest_steps, len(world.dofs))
    rows, starts, firsts, seconds, endings = [], [], [], [], []
    for i in range(settings.experiments):
        own = seed_for(seed, "experiment", i)
        world.reset(generator(own, "situation"))
        start, view = world.snapshot(), sensors.scale(world.observe())
        for dof, first, second in orders_per_dof(world, own, settings.length, start):
            first, second = compose(first, rest), compose(second, rest)
            ends, touched = _play(world, start, first, second, sensors)
            rows.append((run, dof, i, touched))
            world.restore(start)
            starts.append(view)
            firsts.append(known_commands(world, first))
            seconds.append(known_commands(world, second))
            endings.append(ends)
    both = np.array(endings)
    imagined = [
        model.imagine(np.array(starts), np.array(orders)).mean(axis=0)
        for orders in (firsts, seconds)
    ]
    frame = pd.DataFrame(rows, columns=["environment", "dof", "experiment", "touched"])
    return frame.assign(
        true=root_mean_square(both[:, 0] - both[:, 1]),
        error=root_mean_square(both[:, 0] - imagined[0]),
        score=root_mean_square(both[:, 0] - imagined[1]),
        imagined=root_mean_square(imagined[0] - imagined[1]),
        unchanged=root_mean_square(both[:, 0] - np.array(starts)),
    )


def _play(
    world: GymnasiumWorld, start: object, first: np.ndarray, second: np.ndarray,
    sensors: ScaledSensors,
) -> tuple[tuple[np.ndarray, np.ndarray], float]:  # fmt: skip
    """The ends of both orders, and whether bodies touched that do not without commands."""
    touched: list[frozenset] = []

    def observe() -> np.ndarray:
        touched.append(world.happened().touched)
        return sensors.scale(world.observe())

    compare_orders(world, start, np.zeros_like(first), first, 0, observe)
    ends = compare_orders(world, start, first, second, 0, observe)
    idle = touched[0]
    contact = any(one - idle for one in touched[2:])
    return (ends.first, ends.second), float(contact) if world.knows_contacts else float("nan")
