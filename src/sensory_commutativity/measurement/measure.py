"""The SCP of every degree of freedom of a world or environment, in one call.

>>> from sensory_commutativity import Corridor, measure
>>> measure(Corridor(wall=3), n=200, length=5)
SCP of Corridor: 200 starts, sequences of 5 actions, distance mse, seed 0
          SCP  95 % interval
move    0.950  [0.910, 0.973]
eyelid  1.000  [0.981, 1.000]
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..adapters import as_world
from ..errors import ArgumentError, TableError
from ..progress import progress_bar
from ..scp.check import check_world
from ..scp.distances import Distance
from ..scp.experiment import REST_STEPS
from ..scp.world import World
from ..seeding import generator
from .arguments import (
    check_thresholds,
    check_whole_number,
    default_thresholds,
    resolve_distance,
    try_distance,
)
from .controls import COLUMNS, has_controls
from .measurement import Measurement, Settings, same_measurement
from .running import (
    Protocol,
    experiment_seed,
    missing_experiments,
    play_experiments,
    play_in_parallel,
)

SAVE_EVERY = 10.0
"""Seconds between two writes of the file given as `resume`. Chosen: a kill loses little."""
MOST_REST = 100
"""Most steps of rest in a world that tells when it is still. Chosen: Pusher needs about 75."""
CHECK_TRIES, CHECK_LENGTH = 2, 5
"""Random starts of the check before a measurement, and actions from each. Chosen: a few seconds for
the slowest world."""


def measure(
    world: Any,
    n: int = 300,
    length: int = 50,
    distance: str | Distance | None = None,
    thresholds: float | Sequence[float] | None = None,
    seed: int = 0,
    *,
    rest_steps: int | None = None,
    workers: int = 1,
    resume: str | Path | None = None,
    progress: bool | None = None,
    check: bool = True,
) -> Measurement:
    """Measure the Sensory Commutativity Probability of every degree of freedom.

    From each of `n` random starts, and for each degree of freedom, a random sequence of actions is
    played in two orders; the SCP is the share of starts from which the sensors end equal (paper,
    section II-E).

    Parameters
    ----------
    world : World, Gymnasium environment, or callable
        A callable without arguments that returns one of the others is called once per process.
    n : int
        Start situations, at least 1.
    length : int
        Actions in a sequence, at least 1.
    distance : {"mse", "scaled", "vgg16"} or callable, optional
        Mean squared error (the default), root mean square in units of each sensor's spread (the
        default for Gymnasium environments), squared distance of VGG16 features (for images), or a
        function of two observations that returns a float of at least 0.
    thresholds : float or sequence of float, optional
        Largest distances that count as equal; by default 0, with ``scaled`` .01 and .1. They can be
        changed afterwards, :meth:`.Measurement.with_thresholds`.
    seed : int
        Determines starts, sequences and orders. Experiment i is the same for every `n`.
    rest_steps : int, optional
        Steps without a command at the end of each order, so that the agent is at rest; by default
        3. A Gymnasium environment rests until it is still, by default for at most 100 steps.
    workers : int
        Processes. Their number does not change the result.
    resume : path, optional
        Parquet file to which finished experiments are written every ten seconds. If it exists, it
        must come from the same measurement, which goes on from there; `n` may be larger.
    progress : bool, optional
        Whether to show a progress bar; by default only on a terminal.
    check : bool
        Whether to check first that the world can be measured (:func:`.check_world`, short).

    Returns
    -------
    Measurement

    Raises
    ------
    ArgumentError
        If an argument is not valid; the message begins with its name.
    WorldError
        If the world breaks a promise that the experiment rests on.
    MissingExtraError
        If the distance needs a package that is not installed.
    """
    n = check_whole_number("n", n, 1)
    length = check_whole_number("length", length, 1)
    seed = check_whole_number("seed", seed, 0)
    workers = check_whole_number("workers", workers, 1, 1024)
    measured = as_world(world)
    if rest_steps is None:
        rest_steps = MOST_REST if has_controls(measured) else REST_STEPS
    rest_steps = check_whole_number("rest_steps", rest_steps, 0)
    name, function = resolve_distance(distance, measured)
    thresholds = check_thresholds(default_thresholds(name) if thresholds is None else thresholds)
    if not len(measured.dofs):
        raise ArgumentError(
            f"world: {type(measured).__name__} has no degrees of freedom; set dofs to a tuple of "
            "Dof"
        )
    if check:
        check_world(measured, CHECK_TRIES, CHECK_LENGTH, seed).raise_if_failed()
        try_distance(measured, function, seed, CHECK_LENGTH, rest_steps)
    settings = Settings(
        world=getattr(measured, "name", type(measured).__name__),
        length=length,
        rest_steps=rest_steps,
        distance=name,
        seed=seed,
        start_sha256=_start_digest(measured, seed),
    )
    dofs = tuple(measured.dofs)
    columns = tuple(COLUMNS) if has_controls(measured) else ("distance",)
    results = np.full((n, len(dofs), len(columns)), np.nan)
    file = None if resume is None else Path(resume)
    if file is not None:
        _read_finished(file, settings, [dof.name for dof in dofs], columns, results)

    choices = tuple(getattr(measured, "choices", ()))

    def result(finished: np.ndarray) -> Measurement:
        controls = {column: finished[..., k] for k, column in enumerate(columns) if k}
        return Measurement(finished[..., 0], dofs, thresholds, settings, controls, choices)

    protocol = Protocol(seed, length, rest_steps, function)
    missing = missing_experiments(results[..., 0])
    if workers > 1 and len(missing) > 1:
        make_world = _Factory(measured) if measured is world else _Factory(world)
        played = play_in_parallel(make_world, protocol, missing, min(workers, len(missing)))
    else:
        played = play_experiments(measured, protocol, missing)
    saved = time.monotonic()
    with progress_bar(n, n - len(missing), settings.world, "start", progress) as bar:
        for i, row in _checked(played, function, settings.world):
            results[i] = row
            bar.update()
            if file is not None and time.monotonic() - saved >= SAVE_EVERY:
                _save_finished(file, result, results)
                saved = time.monotonic()
    measurement = result(results)
    if file is not None and (missing or not file.exists()):
        measurement.save(file)
    return measurement


class _Factory:
    """A picklable function that returns a world."""

    def __init__(self, source: Any):
        self.source = source

    def __call__(self) -> World:
        return as_world(self.source)


def _start_digest(world: World, seed: int) -> str:
    """SHA-256 of the first observation of experiment 0."""
    world.reset(generator(experiment_seed(seed, 0), "situation"))
    return hashlib.sha256(np.ascontiguousarray(world.observe()).tobytes()).hexdigest()


def _checked(
    played: Iterator[tuple[int, np.ndarray]], distance: Distance, world: str
) -> Iterator[tuple[int, np.ndarray]]:
    """Pass rows on; raises ArgumentError for a distance that is NaN or negative."""
    for i, row in played:
        wrong = row[~(row[:, 0] >= 0), 0]
        if len(wrong):
            raise ArgumentError(
                f"distance: was {float(wrong[0])!r} in experiment {i} of {world}; expected a "
                "number of at least 0: check the observations and the function"
            )
        yield i, row


def _read_finished(
    file: Path,
    settings: Settings,
    names: Sequence[str],
    columns: Sequence[str],
    results: np.ndarray,
) -> None:
    """Fill `results` with what `file` holds, if it exists."""
    if not file.exists():
        if not file.parent.is_dir():
            raise ArgumentError(f"resume: there is no folder {file.parent}; create it")
        return
    try:
        found = Measurement.load(file)
    except TableError as error:
        raise ArgumentError(f"resume: {error}") from None
    different = same_measurement(found, settings, names)
    if different:
        raise ArgumentError(
            f"resume: {file} holds another measurement: {different}; choose another file or the "
            "same settings"
        )
    rows = min(len(found), len(results))
    for k, column in enumerate(columns):
        values = found.controls[column] if k else found.distances
        results[:rows, :, k] = values[:rows]


def _save_finished(
    file: Path, result: Callable[[np.ndarray], Measurement], results: np.ndarray
) -> None:
    """Write the experiments up to the first that is missing."""
    missing = missing_experiments(results[..., 0])
    finished = results[: missing[0]] if missing else results
    if len(finished):
        result(finished).save(file)
