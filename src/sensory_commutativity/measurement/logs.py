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
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
from pydantic import Field, ValidationError

from ..errors import ArgumentError, TableError
from ..scp.distances import Distance, mean_squared_error, scaled_difference
from ..scp.return_protocol import Legs, compare_legs
from ..scp.sequences import inverse
from ..scp.world import Dof
from ..storage.files import printable, read_bounded
from ..storage.parquet import TableTooLargeError, read_bounded_table
from ..storage.settings import Section
from .arguments import check_thresholds, default_thresholds
from .measurement import Measurement, Settings
from .returning import COLUMNS, RETURN

METADATA = "log"
"""Key of the JSON object in the metadata of the file."""
MAX_BYTES = 1_000_000_000
"""Size of a log. Chosen: hours of a robot with state vectors, minutes of one with images."""
LEGS = 5
"""Legs of a trial that are read: h, back, p, back, p."""
BETWEEN = -1
"""Episode of steps between trials."""
REQUIRED = ("episode", "step", "action", "observation")
SAME = 1e-9
"""By how much two actions may differ that should be equal. Chosen: rounding of their storage."""
REMEDY = "the page 'On a real robot' of the documentation says what a log holds"


class DofDescription(Section):
    """A degree of freedom, as :class:`.Dof`."""

    name: Annotated[str, Field(min_length=1, max_length=100)]
    unit: Annotated[str, Field(max_length=40)] = "1"
    speed: float = float("nan")
    low: float = float("-inf")
    high: float = float("inf")
    displaces: bool = True


class LogDescription(Section):
    """What the columns of a log do not say."""

    world: Annotated[str, Field(max_length=200)] | None = None
    dofs: list[DofDescription | Annotated[str, Field(min_length=1, max_length=100)]] | None = None
    shape: list[Annotated[int, Field(ge=1)]] | None = None
    dtype: Literal["uint8", "int64", "float32", "float64", "bool"] | None = None
    distance: Literal["mse", "scaled"] = "mse"
    unit: list[float | None] | None = None
    seed: Annotated[int, Field(ge=0)] = 0


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
        world=described.world or path.stem, length=trials[0].length,
        rest_steps=trials[0].rest_steps, distance=name, seed=described.seed,
        start_sha256=hashlib.sha256(np.ascontiguousarray(views[0]).tobytes()).hexdigest(),
        protocol=RETURN,
    )  # fmt: skip
    controls = {column: rows[..., k] for k, column in enumerate(COLUMNS) if k}
    chosen = check_thresholds(default_thresholds(name) if thresholds is None else thresholds)
    choices = (f"from {path.name}: {len(trials):,} trials, {len(frame):,} steps",)
    return Measurement(rows[..., 0], dofs, chosen, settings, controls, choices)


def _read(path: Path) -> tuple[pd.DataFrame, LogDescription]:
    try:
        table = read_bounded_table(read_bounded(path, TableError, REMEDY, MAX_BYTES))
    except FileNotFoundError:
        raise TableError(f"{path}: there is no such log; give the path of a Parquet file") from None
    except TableTooLargeError as error:
        raise TableError(f"{path}: {error}; {REMEDY}") from None
    except (pa.ArrowException, OSError, ValueError) as error:
        reason = (str(error).splitlines() or ["?"])[0][:120]
        raise TableError(f"{path}: not a readable Parquet file ({printable(reason)})") from None
    missing = [name for name in REQUIRED if name not in table.column_names]
    if missing:
        raise TableError(
            f"{path}: has no column {missing[0]}; a log has {', '.join(REQUIRED)}; {REMEDY}"
        )
    try:
        described = (table.schema.metadata or {}).get(METADATA.encode(), b"{}")
        description = LogDescription.model_validate_json(described)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise TableError(
            f"{path}: its metadata {METADATA}: {printable(where)}: {first['msg']}; {REMEDY}"
        ) from None
    if not table.num_rows:
        raise TableError(f"{path}: has no rows; record at least one trial")
    kept = [name for name in (*REQUIRED, "leg", "dof") if name in table.column_names]
    for name in kept:
        column = table.column(name)
        lists = name in ("action", "observation")
        right = pa.types.is_list(column.type) if lists else pa.types.is_integer(column.type)
        if column.null_count or not right:
            raise TableError(
                f"{path}: the column {name} must hold {'lists of numbers' if lists else 'integers'}"
                f", and no nulls; {REMEDY}"
            )
    return table.select(kept).to_pandas(), description


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


def _name_dofs(described: LogDescription, n: int, path: Path) -> tuple[Dof, ...]:
    found = described.dofs or [f"action-{k}" for k in range(n)]
    if len(found) != n:
        raise TableError(
            f"{path}: names {len(found)} degrees of freedom, but actions have {n} numbers"
        )
    dofs = tuple(
        Dof(dof, "1", float("nan")) if isinstance(dof, str) else Dof(**dof.model_dump())
        for dof in found
    )
    if len({dof.name for dof in dofs}) < n:
        raise TableError(f"{path}: two degrees of freedom have the same name; rename one")
    return dofs


def _shape(views: np.ndarray, described: LogDescription, path: Path) -> np.ndarray:
    shape = views.shape[1:] if described.shape is None else tuple(described.shape)
    if int(np.prod(shape)) != views.shape[1]:
        raise TableError(
            f"{path}: observations have {views.shape[1]} numbers, which is not the shape {shape}"
        )
    return views.reshape(len(views), *shape).astype(described.dtype or views.dtype)


def _resolve(
    distance: str | Distance | None, described: LogDescription, views: np.ndarray, path: Path
) -> tuple[str, Distance]:
    if callable(distance):
        return getattr(distance, "__qualname__", type(distance).__name__), distance
    name = distance or described.distance
    if name == "mse":
        return name, mean_squared_error
    if name != "scaled":
        raise ArgumentError(
            f"distance: expected mse, scaled or a function of two observations, got {name!r}"
        )
    flat = views.reshape(len(views), -1).astype(float)
    unit = np.where(np.ptp(flat, axis=0) > 0, flat.std(axis=0), np.inf)
    if described.unit is not None:  # null: a sensor that never moves
        unit = np.array([np.inf if one is None else one for one in described.unit])
    if unit.shape != flat.shape[1:] or not (unit > 0).all():
        raise TableError(
            f"{path}: needs a positive unit, or null, for each of the {flat.shape[1]} numbers of "
            "an observation"
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
