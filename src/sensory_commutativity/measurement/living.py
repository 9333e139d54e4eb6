"""Measuring start after start: without a restore, or until the order is decided.

Both depend on what came before, so that starts are played one after the other, in one process.
"""

from __future__ import annotations

import time
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..adapters import as_world
from ..errors import ArgumentError
from ..progress import progress_bar
from ..scp.experiment import distances_per_dof
from .measurement import Measurement, Settings
from .returning import (
    COLUMNS,
    RETURN,
    Life,
    describe_inverses,
    play_start,
    prepare_start,
    require_steppable,
)
from .running import Protocol, experiment_seed
from .until import LOOK, Stopping, replay

SAVE_EVERY = 10.0
"""Seconds between two writes of the file. Chosen: a kill loses little."""
PROTOCOLS = ("reset", RETURN)


class Plan(NamedTuple):
    """How starts follow each other.

    Attributes
    ----------
    life : Life, optional
        Without a restore.
    stopping : Stopping, optional
        Until the order is decided.
    """

    life: Life | None
    stopping: Stopping | None


def as_steppable(source: Any) -> Any:
    """What the return protocol can play with: anything with dofs, step and observe."""
    if callable(getattr(source, "observe", None)) and not isinstance(source, type):
        require_steppable(source)
        return source
    return as_world(source, snapshots="none")


def check_plan(
    protocol: str, reset_every: int | None, workers: int, resume: Path | None,
    stopping: Stopping | None,
) -> None:  # fmt: skip
    """Raise ArgumentError for arguments that do not fit together."""
    if protocol not in PROTOCOLS:
        raise ArgumentError(f"protocol: expected one of {', '.join(PROTOCOLS)}; got {protocol!r}")
    if protocol != RETURN:
        if reset_every is not None:
            raise ArgumentError(
                "reset_every: every experiment of the protocol reset is reset; leave it out, or "
                "choose protocol='return'"
            )
        if stopping is None:
            return
    reason = "one life" if protocol == RETURN else "a measurement until ordered"
    if workers != 1:
        raise ArgumentError(f"workers: {reason} is played start after start; leave workers out")
    if resume is not None and resume.exists():
        raise ArgumentError(
            f"resume: {reason} cannot go on from {resume}; choose another file, or delete it"
        )
    if resume is not None and not resume.parent.is_dir():
        raise ArgumentError(f"resume: there is no folder {resume.parent}; create it")


def choices_of(world: Any, plan: Plan) -> tuple[str, ...]:
    """What was chosen, for people."""
    choices = tuple(getattr(world, "choices", ()))
    if plan.life is not None:
        choices += (describe_inverses(world),)
    return choices


def measure_living(
    world: Any,
    n: int,
    protocol: Protocol,
    plan: Plan,
    thresholds: tuple[float, ...],
    settings: Settings,
    file: Path | None,
    progress: bool | None,
) -> Measurement:
    """Play at most `n` starts.

    Parameters
    ----------
    world : SteppableWorld, or World without a life
    n : int
    protocol : Protocol
    plan : Plan
    thresholds, settings
        Of the measurement.
    file : Path, optional
        Is written every SAVE_EVERY seconds, and at the end.
    progress : bool, optional
    """
    names = [dof.name for dof in world.dofs]
    columns = tuple(COLUMNS) if plan.life is not None else ("distance",)
    choices, saved = choices_of(world, plan), time.monotonic()
    rows = np.full((n, len(names), len(columns)), np.nan)
    active: Collection[str] = names

    def measurement(stop: int) -> Measurement:
        controls = {column: rows[:stop, :, k] for k, column in enumerate(columns) if k}
        return Measurement(
            rows[:stop, :, 0], tuple(world.dofs), thresholds, settings, controls, choices
        )

    played = 0
    with progress_bar(n, 0, settings.world, "start", progress) as bar:
        while played < n and active:
            rows[played] = _play(world, played, protocol, plan.life, active)
            _check(rows[played, :, 0], played, settings.world)
            played += 1
            bar.update()
            if plan.stopping is not None and played % LOOK == 0:
                test = replay(rows[:played, :, 0], plan.stopping)
                active = [name for name, on in zip(names, test.active[0], strict=True) if on]
            if file is not None and time.monotonic() - saved >= SAVE_EVERY:
                measurement(played).save(file)
                saved = time.monotonic()
    found = measurement(played)
    if file is not None:
        found.save(file)
    return found


def _play(
    world: Any, i: int, protocol: Protocol, life: Life | None, active: Collection[str]
) -> np.ndarray:
    seed, length = experiment_seed(protocol.seed, i), protocol.length
    if life is None:
        found = distances_per_dof(
            world, seed, length, protocol.distance, protocol.rest_steps, active
        )
        return np.array([[found.get(dof.name, np.nan)] for dof in world.dofs])
    begins = i == 0 if life.reset_every is None else i % life.reset_every == 0
    prepare_start(world, seed, begins, life.wander)
    return play_start(world, seed, length, protocol.distance, protocol.rest_steps, active)


def _check(distances: np.ndarray, i: int, world: str) -> None:
    """Raise ArgumentError for a distance that is negative; NaN is one that was not played."""
    if (distances[~np.isnan(distances)] < 0).any():
        raise ArgumentError(
            f"distance: was negative in experiment {i} of {world}; correct the function"
        )
