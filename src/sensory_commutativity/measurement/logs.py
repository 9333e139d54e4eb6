"""Logs of a robot that moved by the return protocol: how they are written, and measured.

A log is a Parquet file with a row per step:

===========  ==============  ===========================================================
column       type            meaning
===========  ==============  ===========================================================
episode      int             number of the trial; negative for steps between trials
step         int             0, 1, 2, ... within the episode
time         float           seconds since the beginning of the log
action       list of float   one number per degree of freedom, in [-1, 1]; zeros in step 0
observation  list of number  what the sensors said *after* the action, flattened
leg          int             optional: 0 in step 0, then 1, 2, ... for each leg of the trial
dof          int             optional: the degree of freedom that acts, from 0
===========  ==============  ===========================================================

An episode is a trial of one degree of freedom: a sequence, rest, its inverse, rest, a permutation
of the sequence, rest, its inverse, rest, and the permutation again, rest; what follows is not read.
Without the column ``leg``, legs are told by the rests: steps whose action is zero. Without ``dof``,
it is the one whose actions are not zero.

The metadata ``log``, a JSON object, may name what the columns do not say: ``world``, ``dofs`` (a
list of names), ``shape`` and ``dtype`` of an observation, ``distance`` (``mse`` or ``scaled``), and
``unit``, the unit of each number of an observation for ``scaled``.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import ArgumentError, TableError
from ..scp.distances import Distance, mean_squared_error, scaled_difference
from ..scp.return_protocol import Legs, compare_legs
from ..scp.sequences import inverse
from ..scp.world import Dof, Observation, SteppableWorld
from ..storage.atomic import atomic_write
from ..storage.provenance import environment
from .arguments import check_thresholds, default_thresholds
from .measurement import Measurement, Settings
from .returning import COLUMNS, RETURN

METADATA = "log"
"""Key of the JSON object in the metadata of the file."""
LEGS = 5
"""Legs of a trial that are read: h, back, p, back, p."""
BETWEEN = -1
"""Episode of steps between trials."""
REQUIRED = ("episode", "step", "action", "observation")
FORWARDED = (
    "reset", "snapshot", "restore", "limit", "has_inverse", "distance", "unit", "choices",
    "observes_images", "knows_contacts", "reaches_stop", "reseed",
)  # fmt: skip
"""What a recorder offers where the world within does."""
SAME = 1e-9
"""By how much two actions may differ that should be equal. Chosen: rounding of their storage."""


# ---- writing --------------------------------------------------------------------------------


class Recorder:
    """A world whose steps are recorded; otherwise it is the world within.

    Parameters
    ----------
    world : SteppableWorld
    clock : callable, optional
        Returns the time in seconds; by default that of the computer.
    """

    def __init__(self, world: SteppableWorld, clock: Callable[[], float] = time.monotonic):
        self.world, self.dofs, self._clock = world, tuple(world.dofs), clock
        self.name = getattr(world, "name", type(world).__name__)
        self.rows: list[tuple[int, int, float, int, int, np.ndarray, np.ndarray]] = []
        self._episode, self._trials, self._step, self._leg, self._dof = BETWEEN, 0, 0, 0, BETWEEN
        self._began: float | None = None
        for name in FORWARDED:
            if hasattr(world, name):
                setattr(self, name, getattr(world, name))
        if hasattr(world, "rest"):
            self.rest = self._rest

    def begin_trial(self, dof: int) -> None:
        self._episode, self._step, self._leg, self._dof = self._trials, 0, 0, dof
        self._trials += 1
        self._record(np.zeros(len(self.dofs)))

    def end_trial(self) -> None:
        self._episode, self._step, self._leg, self._dof = BETWEEN, 0, 0, BETWEEN

    def step(self, action: np.ndarray) -> None:
        self.world.step(action)
        self._record(np.asarray(action, np.float64))

    def play(self, actions: np.ndarray) -> None:
        """Play a leg, step by step; a leg begins with each call."""
        self._leg += 1
        for action in actions:
            self.step(action)

    def observe(self) -> Observation:
        return self.world.observe()

    def _rest(self, most: int) -> None:
        """Rest as the world within does; what it does meanwhile is recorded as one step."""
        self.world.rest(most)  # type: ignore[attr-defined]
        self._record(np.zeros(len(self.dofs)))

    def _record(self, action: np.ndarray) -> None:
        now = self._clock()
        self._began = now if self._began is None else self._began
        view = np.array(self.world.observe())
        self.rows.append(
            (self._episode, self._step, now - self._began, self._leg, self._dof, action, view)
        )
        self._step += 1


def write_log(path: str | Path, recorder: Recorder, distance: str = "mse") -> Path:
    """Write what was recorded; the file says how to measure it.

    Raises
    ------
    ArgumentError
        If nothing was recorded.
    """
    path = Path(path)
    if not recorder.rows:
        raise ArgumentError(f"{path}: nothing was recorded; measure with protocol='return' first")
    episode, step, seconds, leg, dof, actions, views = zip(*recorder.rows, strict=True)
    described: dict[str, Any] = dict(
        world=recorder.name, dofs=[asdict(dof) for dof in recorder.dofs], distance=distance,
        shape=list(views[0].shape), dtype=str(views[0].dtype),
    )  # fmt: skip
    if distance == "scaled":
        scaled: Any = recorder.world
        units = np.ravel(scaled.unit)
        described["unit"] = [float(unit) if np.isfinite(unit) else None for unit in units]
    flat = [np.ravel(view) for view in views]
    table = pa.table(
        dict(
            episode=pa.array(episode, pa.int64()), step=pa.array(step, pa.int64()),
            time=pa.array(seconds, pa.float64()), leg=pa.array(leg, pa.int64()),
            dof=pa.array(dof, pa.int64()),
            action=pa.array(list(actions), pa.list_(pa.float64())),
            observation=pa.array(flat, pa.list_(pa.from_numpy_dtype(flat[0].dtype))),
        )
    )  # fmt: skip
    metadata = {METADATA: json.dumps(described), **environment()}
    with atomic_write(path) as temporary:
        pq.write_table(table.replace_schema_metadata(metadata), temporary, compression="zstd")
    return path


# ---- reading --------------------------------------------------------------------------------


class Trial(NamedTuple):
    """A trial that was recorded."""

    dof: int
    length: int
    rest_steps: int
    legs: Legs


def measure_log(
    path: str | Path,
    distance: str | Distance | None = None,
    thresholds: float | Sequence[float] | None = None,
) -> Measurement:
    """Measure what a robot recorded that moved by the return protocol.

    The result is that of :func:`.measure` with ``protocol="return"`` while it was recorded.

    Parameters
    ----------
    path : path
        A log; the module says what it holds.
    distance : {"mse", "scaled"} or callable, optional
        By default the one that the log names, or else mean squared error. Without units in the log,
        ``scaled`` takes the spread of each number over the whole log.
    thresholds : float or sequence of float, optional
        As for :func:`.measure`.

    Returns
    -------
    Measurement
        Row i holds the i-th trial of every degree of freedom; NaN where it was tried less often
        than another.

    Raises
    ------
    TableError
        If the file is missing or no log, or if an episode is no trial of the return protocol; the
        message names the episode.
    """
    path = Path(path)
    frame, described = _read(path)
    views, actions = _stack(frame, "observation", path), _stack(frame, "action", path)
    dofs = _name_dofs(described, actions.shape[1], path)
    views = _shape(views, described, path)
    name, function = _resolve(distance, described, views, path)
    trials = [
        _read_trial(path, int(episode), group, actions, views)
        for episode, group in frame[frame["episode"] >= 0].groupby("episode", sort=True)
    ]
    if not trials:
        raise TableError(f"{path}: has no trial; number them in the column episode, from 0")
    rows = _arrange(trials, len(dofs), function)
    settings = Settings(
        world=str(described.get("world", path.stem)), length=trials[0].length,
        rest_steps=trials[0].rest_steps, distance=name, seed=int(described.get("seed", 0)),
        start_sha256=hashlib.sha256(np.ascontiguousarray(views[0]).tobytes()).hexdigest(),
        protocol=RETURN,
    )  # fmt: skip
    controls = {column: rows[..., k] for k, column in enumerate(COLUMNS) if k}
    chosen = check_thresholds(default_thresholds(name) if thresholds is None else thresholds)
    choices = (f"from {path.name}: {len(trials):,} trials, {len(frame):,} steps",)
    return Measurement(rows[..., 0], dofs, chosen, settings, controls, choices)


def _read(path: Path) -> tuple[pd.DataFrame, dict[str, Any]]:
    try:
        table = pq.read_table(path)
        described = json.loads((table.schema.metadata or {}).get(METADATA.encode(), b"{}"))
    except FileNotFoundError:
        raise TableError(f"{path}: there is no such log; give the path of a Parquet file") from None
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = str(error).splitlines()[0]
        raise TableError(f"{path}: not a readable Parquet file ({reason})") from None
    missing = [name for name in REQUIRED if name not in table.column_names]
    if missing or not isinstance(described, dict):
        raise TableError(
            f"{path}: has no column {missing[0] if missing else METADATA}; a log has "
            f"{', '.join(REQUIRED)} (docs, 'On a real robot')"
        )
    if not table.num_rows:
        raise TableError(f"{path}: has no rows; record at least one trial")
    kept = [name for name in (*REQUIRED, "leg", "dof") if name in table.column_names]
    return table.select(kept).to_pandas(), described


def _stack(frame: pd.DataFrame, column: str, path: Path) -> np.ndarray:
    """The lists of a column as an array (rows, size)."""
    sizes = {np.size(value) for value in frame[column]}
    if len(sizes) != 1 or not min(sizes):
        raise TableError(
            f"{path}: the lists in the column {column} have different lengths, "
            f"{', '.join(map(str, sorted(sizes)[:4]))}; every row needs one number per "
            f"{'degree of freedom' if column == 'action' else 'sensor'}"
        )
    values = np.stack([np.asarray(value) for value in frame[column]])
    if values.dtype.kind not in "biuf" or not np.isfinite(values).all():
        raise TableError(f"{path}: the column {column} holds values that are no finite numbers")
    return values


def _name_dofs(described: dict[str, Any], n: int, path: Path) -> tuple[Dof, ...]:
    found = described.get("dofs", [f"action-{k}" for k in range(n)])
    if len(found) != n:
        raise TableError(
            f"{path}: names {len(found)} degrees of freedom, but actions have {n} numbers"
        )
    return tuple(
        Dof(**dof) if isinstance(dof, dict) else Dof(str(dof), "1", float("nan")) for dof in found
    )


def _shape(views: np.ndarray, described: dict[str, Any], path: Path) -> np.ndarray:
    shape = tuple(described.get("shape", views.shape[1:]))
    if int(np.prod(shape)) != views.shape[1]:
        raise TableError(
            f"{path}: observations have {views.shape[1]} numbers, which is not the shape {shape}"
        )
    return views.reshape(len(views), *shape).astype(described.get("dtype", views.dtype))


def _resolve(
    distance: str | Distance | None, described: dict[str, Any], views: np.ndarray, path: Path
) -> tuple[str, Distance]:
    if callable(distance):
        return getattr(distance, "__qualname__", type(distance).__name__), distance
    name = distance or described.get("distance", "mse")
    if name == "mse":
        return name, mean_squared_error
    if name != "scaled":
        raise ArgumentError(
            f"distance: expected mse, scaled or a function of two observations, got {name!r}"
        )
    flat = views.reshape(len(views), -1).astype(float)
    moves = np.ptp(flat, axis=0) > 0
    unit = np.array(described.get("unit", np.where(moves, flat.std(axis=0), np.inf)), float)
    unit = np.where(np.isnan(unit), np.inf, unit)  # null in the log: a sensor that never moves
    if unit.shape != flat.shape[1:]:
        raise TableError(
            f"{path}: has {unit.size} units for observations of {flat.shape[1]} numbers"
        )
    return name, lambda first, second: scaled_difference(np.ravel(first), np.ravel(second), unit)


def _read_trial(
    path: Path, episode: int, group: pd.DataFrame, actions: np.ndarray, views: np.ndarray
) -> Trial:
    """The legs of an episode; raises TableError if it is no trial."""

    def refuse(reason: str) -> TableError:
        return TableError(f"{path}: episode {episode} {reason}")

    if group["step"].tolist() != list(range(len(group))):
        raise refuse("lacks steps or has them out of order; number them 0, 1, 2, ...")
    rows = group.index.to_numpy()
    legs = group["leg"].to_numpy() if "leg" in group else _find_legs(actions[rows])
    if set(range(LEGS + 1)) - set(legs.tolist()) or (np.diff(legs) < 0).any():
        raise refuse(
            f"has {int(legs.max())} legs, not the {LEGS} of a trial: a sequence, its inverse, a "
            "permutation, its inverse, the permutation again, each followed by a rest"
        )
    played = [_strip(actions[rows[legs == leg]]) for leg in range(1, LEGS + 1)]
    moved = np.flatnonzero(np.abs(played[0]).max(axis=0, initial=0.0) > 0)
    if "dof" in group and not len(moved):
        moved = group["dof"].unique()  # it had no room to move
    if len(moved) != 1 or not 0 <= moved[0] < actions.shape[1]:
        raise refuse(f"commands {len(moved)} degrees of freedom; a trial commands one")
    k = int(moved[0])
    first, back, second, back_again, repeated = played
    for leg, found, expected, should in (
        (2, back, inverse(first), "the inverse of leg 1"),
        (3, np.sort(second[:, k]), np.sort(first[:, k]), "a permutation of leg 1"),
        (4, back_again, inverse(second), "the inverse of leg 3"),
        (5, repeated, second, "leg 3 again"),
    ):
        if found.shape != expected.shape or np.abs(found - expected).max(initial=0.0) > SAME:
            raise refuse(f"is no trial: leg {leg} is not {should}")
    ends = [rows[legs == leg][-1] for leg in range(LEGS + 1)]
    rest = int((legs == 1).sum()) - len(first)
    return Trial(k, len(first), rest, Legs(*(views[end] for end in ends)))


def _strip(actions: np.ndarray) -> np.ndarray:
    """Without the rest at the end."""
    commanded = np.flatnonzero(np.abs(actions).max(axis=1, initial=0.0) > 0)
    return actions[: commanded[-1] + 1] if len(commanded) else actions[:0]


def _find_legs(actions: np.ndarray) -> np.ndarray:
    """Number the legs by the rests between them: int (rows,)."""
    acts = np.abs(actions).max(axis=1) > 0
    begins = acts & ~np.concatenate([[False], acts[:-1]])
    return np.cumsum(begins)


def _arrange(trials: list[Trial], n_dofs: int, distance: Distance) -> np.ndarray:
    """Distances, float (n, n_dofs, columns): the i-th trial of every degree of freedom in row i."""
    counts = np.bincount([trial.dof for trial in trials], minlength=n_dofs)
    rows = np.full((int(counts.max()), n_dofs, len(COLUMNS)), np.nan)
    done = np.zeros(n_dofs, int)
    for trial in trials:
        rows[done[trial.dof], trial.dof] = compare_legs(trial.legs, distance)
        done[trial.dof] += 1
    return rows
