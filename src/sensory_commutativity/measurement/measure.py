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
from collections.abc import Iterator, Sequence
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
from .living import Plan, as_steppable, check_plan, measure_living
from .measurement import Measurement, Settings, same_measurement
from .returning import RETURN, Life
from .running import (
    Protocol,
    experiment_seed,
    missing_experiments,
    play_experiments,
    play_in_parallel,
)
from .until import Stopping, check_stopping

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
    protocol: str = "reset",
    reset_every: int | None = None,
    wander: int | None = None,
    until: str | None = None,
    alpha: float = 0.05,
    margin: float = 0.05,
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
        Start situations, at least 1; with `until`, the largest number of them.
    length : int
        Actions in a sequence, at least 1.
    distance : {"mse", "scaled", "vgg16"} or callable, optional
        Mean squared error (the default), root mean square in units of each sensor's spread (the
        default for Gymnasium environments), squared distance of VGG16 features (for images), or a
        function of two observations that returns a float of at least 0.
    thresholds : float or sequence of float, optional
        Largest distances that count as equal; by default 0, with ``scaled`` .1 and .01. The first
        is the one of ``scp()``, ``order()`` and the printed report. They can be changed afterwards,
        :meth:`.Measurement.with_thresholds`.
    seed : int
        Determines starts, sequences and orders. Experiment i is the same for every `n`.
    protocol : {"reset", "return"}
        ``reset``: both orders start from a restored situation. ``return``: nothing is restored; the
        inverse actions lead back from the first order to the start of the second
        (:mod:`.return_protocol`), and the SCP is also given relative to that of a control. `world`
        needs no more than dofs, step and observe.
    reset_every : int, optional
        With ``return``, starts between two resets; by default the world is reset once.
    wander : int, optional
        With ``return``, random actions on the way to the next start; by default `length`.
    until : {"ordered"}, optional
        Stop when every pair of degrees of freedom is ordered or found tied; those that are decided
        are not played any more (:mod:`.sequential`).
    alpha, margin : float in (0, 1)
        With `until`, the largest probability that anything said of the order is wrong, and the
        difference of SCPs below which two may be called tied.
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
    workers = check_whole_number("workers", workers, 1, 1024)
    file = None if resume is None else Path(resume)
    returns = protocol == RETURN
    measured = as_steppable(world) if returns else as_world(world)
    played_by, name = _choose_protocol(measured, length, distance, seed, rest_steps)
    thresholds = check_thresholds(default_thresholds(name) if thresholds is None else thresholds)
    stopping = check_stopping(until, alpha, margin, thresholds[0])
    check_plan(protocol, reset_every, workers, file, stopping)
    if check and not returns:
        check_world(measured, CHECK_TRIES, CHECK_LENGTH, played_by.seed).raise_if_failed()
        try_distance(
            measured, played_by.distance, played_by.seed, CHECK_LENGTH, played_by.rest_steps
        )
    if resume is not None and "<" in name:
        raise ArgumentError(
            f"resume: the distance {name} has no name by which it could be recognized; define it "
            "with def at the top level of a module"
        )
    settings = _describe(measured, played_by, name, protocol, stopping)
    if returns or stopping is not None:
        plan = Plan(_choose_life(reset_every, wander, length) if returns else None, stopping)
        found = measure_living(measured, n, played_by, plan, thresholds, settings, file, progress)
    else:
        found = _measure_apart(
            world, measured, n, played_by, thresholds, settings, file, workers, progress
        )
    if measured is not world and hasattr(measured, "close"):
        measured.close()  # gives an environment back as it was
    return found


def _choose_life(reset_every: int | None, wander: int | None, length: int) -> Life:
    if reset_every is not None:
        reset_every = check_whole_number("reset_every", reset_every, 1)
    return Life(reset_every, length if wander is None else check_whole_number("wander", wander, 0))


def _measure_apart(
    world: Any, measured: World, n: int, protocol: Protocol, thresholds: tuple[float, ...],
    settings: Settings, file: Path | None, workers: int, progress: bool | None,
) -> Measurement:  # fmt: skip
    """Play experiments that do not depend on each other, in any order, in several processes."""
    results = _Results(n, measured, thresholds, settings, file)
    missing = results.missing()
    if workers > 1 and len(missing) > 1:
        # A function makes a world in every process; another source has been adapted already.
        source = world if callable(world) and measured is not world else measured
        played = play_in_parallel(_Factory(source), protocol, missing, min(workers, len(missing)))
    else:
        played = play_experiments(measured, protocol, missing)
    with progress_bar(n, n - len(missing), settings.world, "start", progress) as bar:
        for i, row in _checked(played, settings.world):
            results.add(i, row)
            bar.update()
    return results.finish()


def _choose_protocol(
    world: World, length: int, distance: str | Distance | None, seed: int, rest_steps: int | None
) -> tuple[Protocol, str]:
    """Check these arguments, with the defaults for `world`; also returns the distance's name."""
    if not len(world.dofs):
        raise ArgumentError(
            f"world: {type(world).__name__} has no degrees of freedom; set dofs to a tuple of Dof"
        )
    if rest_steps is None:
        rest_steps = MOST_REST if has_controls(world) else REST_STEPS
    name, function = resolve_distance(distance, world)
    protocol = Protocol(
        seed=check_whole_number("seed", seed, 0),
        length=check_whole_number("length", length, 1),
        rest_steps=check_whole_number("rest_steps", rest_steps, 0),
        distance=function,
    )
    return protocol, name


def _describe(
    world: Any, protocol: Protocol, distance: str, name: str, stopping: Stopping | None
) -> Settings:
    """What the distances depend on."""
    if isinstance(world, World):
        world.reset(generator(experiment_seed(protocol.seed, 0), "situation"))
    first = np.ascontiguousarray(world.observe())
    return Settings(
        world=getattr(world, "name", type(world).__name__),
        length=protocol.length,
        rest_steps=protocol.rest_steps,
        distance=distance,
        seed=protocol.seed,
        start_sha256=hashlib.sha256(first.tobytes()).hexdigest(),
        protocol=name,
        stopping=stopping,
    )


class _Results:
    """Rows of finished experiments, in memory and in a file.

    Parameters
    ----------
    n : int
    world : World
    thresholds : tuple of float
    settings : Settings
    file : Path, optional
        Is read if it exists, and written every SAVE_EVERY seconds.

    Raises
    ------
    ArgumentError
        If the file holds another measurement, or its folder does not exist.
    """

    def __init__(
        self, n: int, world: World, thresholds: tuple[float, ...], settings: Settings,
        file: Path | None,
    ):  # fmt: skip
        self._dofs, self._thresholds, self._settings = tuple(world.dofs), thresholds, settings
        self._choices = tuple(getattr(world, "choices", ()))
        self._columns = tuple(COLUMNS) if has_controls(world) else ("distance",)
        self._rows = np.full((n, len(self._dofs), len(self._columns)), np.nan)
        self._file, self._saved, self._changed = file, time.monotonic(), False
        if file is not None:
            self._read(file)

    def missing(self) -> list[int]:
        """Numbers of the experiments that are not finished."""
        return missing_experiments(self._rows[..., 0])

    def add(self, i: int, row: np.ndarray) -> None:
        """Add the row of experiment `i`, and write the file from time to time."""
        self._rows[i], self._changed = row, True
        if self._file is not None and time.monotonic() - self._saved >= SAVE_EVERY:
            first_missing = next(iter(self.missing()), len(self._rows))
            if first_missing:
                self._measurement(first_missing).save(self._file)
            self._saved = time.monotonic()

    def finish(self) -> Measurement:
        """Write the file, and return everything."""
        measurement = self._measurement(len(self._rows))
        if self._file is not None and (self._changed or not self._file.exists()):
            measurement.save(self._file)
        return measurement

    def _measurement(self, n: int) -> Measurement:
        rows = self._rows[:n]
        controls = {column: rows[..., k] for k, column in enumerate(self._columns) if k}
        return Measurement(
            rows[..., 0], self._dofs, self._thresholds, self._settings, controls, self._choices
        )

    def _read(self, file: Path) -> None:
        if not file.exists():
            if not file.parent.is_dir():
                raise ArgumentError(f"resume: there is no folder {file.parent}; create it")
            return
        try:
            found = Measurement.load(file)
        except TableError as error:
            raise ArgumentError(f"resume: {error}") from None
        names = [dof.name for dof in self._dofs]
        different = same_measurement(found, self._settings, names, self._choices)
        if different:
            raise ArgumentError(
                f"resume: {file} holds another measurement: {different}; choose another file or "
                "the same settings"
            )
        n = min(len(found), len(self._rows))
        for k, column in enumerate(self._columns):
            values = found.controls[column] if k else found.distances
            self._rows[:n, :, k] = values[:n]


class _Factory:
    """A picklable function that returns a world."""

    def __init__(self, source: Any):
        self.source = source

    def __call__(self) -> World:
        return as_world(self.source)


def _checked(
    played: Iterator[tuple[int, np.ndarray]], world: str
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
