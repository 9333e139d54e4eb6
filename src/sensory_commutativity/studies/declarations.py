"""Declarations: what a study computes, from what, and which settings it depends on.

A table, a file of arrays, a model or a figure is declared once, by a decorator on the function that
computes it. From the declaration follow the schema, the checks when a table is read, the command
line, the names of the files, and the hash of the settings on which the workflow's rules depend. The
rules themselves are written out in ``workflow/rules/``, so that the chain can be read there.

A module ``studies/STUDY/tables/NAME.py`` declares the table NAME. Figures are declared in
``studies/STUDY/figures/``, arrays in ``studies/STUDY/arrays/``, models in
``studies/STUDY/models/``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from ..errors import UserError
from ..storage.columns import Column
from .config import Config

if TYPE_CHECKING:
    import pandas as pd  # takes a third of a second, and most commands only look names up


@dataclass(frozen=True)
class Shard:
    """A share of the units (experiments, pairs, scenes, poses) of one run, for one job.

    Attributes
    ----------
    run : str
        Name of the run, unique within the table or arrays.
    start, stop : int
        The units start <= i < stop.
    index, count : int
        Number of the shard, from 0, and how many shards the run has; 0 and 0 for a run that is
        never cut.
    """

    run: str
    start: int
    stop: int
    index: int = 0
    count: int = 0

    @property
    def name(self) -> str:
        """``RUN`` or ``RUN.I-of-N``, the stem of the shard's file name."""
        return f"{self.run}.{self.part}" if self.count else self.run

    @property
    def part(self) -> str:
        """``I-of-N``, from 1."""
        return f"{self.index + 1}-of-{self.count}"


@dataclass(frozen=True)
class Shards:
    """How work is cut into shards. Every unit has a random stream of its own, so no result
    depends on how work is cut.

    Attributes
    ----------
    runs : callable
        Configuration -> name of each run and its number of units, in the order of the rows.
    settings : callable
        Configuration and name of a run -> everything that a unit of the run depends on, apart from
        the root seed and the inputs; anything that JSON can hold, or models of the configuration.
    per_shard : callable, optional
        Configuration -> most units in a shard. By default runs are not cut.
    """

    runs: Callable[[Config], Mapping[str, int]]
    settings: Callable[[Config, str], object]
    per_shard: Callable[[Config], int] | None = None

    def of_run(self, config: Config, run: str) -> list[Shard]:
        """All shards of a run, in order. Raises UserError if there is no such run."""
        runs = self.runs(config)
        if run not in runs:
            known = ", ".join(runs)
            raise UserError(f"the configuration has no run {run!r}; choose one of {known}")
        units = runs[run]
        if self.per_shard is None:
            return [Shard(run, 0, units)]
        size = self.per_shard(config)
        count = math.ceil(units / size)
        return [Shard(run, i * size, min(units, (i + 1) * size), i, count) for i in range(count)]

    def all(self, config: Config) -> list[Shard]:
        """All shards of all runs, in order."""
        return [shard for run in self.runs(config) for shard in self.of_run(config, run)]

    def find(self, config: Config, name: str) -> Shard:
        """The shard of this name. Raises UserError if the configuration has none."""
        shards = {shard.name: shard for shard in self.all(config)}
        if name not in shards:
            known = ", ".join(list(shards)[:8]) + (", ..." if len(shards) > 8 else "")
            raise UserError(
                f"the configuration has no shard {name!r}; it has {len(shards)}: {known}"
            )
        return shards[name]


@dataclass(frozen=True)
class Batched:
    """Rows that are computed batch by batch, so that a killed job resumes.

    Attributes
    ----------
    compute : callable
        The rows of units start <= i < stop; they do not depend on how units are cut.
    size : int
        Units in a batch; a few seconds of work.
    units : int, optional
        How many there are; by default those of the shard.
    metadata : mapping of str to str
        Stored in the file, and the same in all shards of a table.
    """

    compute: Callable[[int, int], pd.DataFrame]
    size: int = 100
    units: int | None = None
    metadata: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Expected:
    """Which rows a complete table has.

    Attributes
    ----------
    columns : tuple of str
        Part of the key; with none, any number of rows is complete.
    counts : mapping
        Values of `columns` -> number of rows; None for any number above 0.
    """

    columns: tuple[str, ...]
    counts: Mapping[tuple, int | None]


Expectation = Expected | tuple[Expected, ...]
"""What must hold of the rows: several if they are counted by several groups of columns."""


@dataclass(frozen=True)
class TrainingOutput:
    """Where training writes a model and its curve, and what it records in them.

    Attributes
    ----------
    model : Path
        File of the model.
    curve : Path
        File of the training curve; checkpoints lie beside it. The file of the model, if there is no
        curve.
    settings_digest : str
        Hash of everything that determines the model, for checkpoints.
    metadata : mapping of str to str
        Provenance, to be stored in the model.
    write_curve : callable
        Writes the curve, a DataFrame.
    """

    model: Path
    curve: Path
    settings_digest: str
    metadata: Mapping[str, str]
    write_curve: Callable[[pd.DataFrame], None]


Inputs = Sequence[str] | Callable[[Config, str | None], Sequence[str]]


def no_settings(config: Config) -> None:
    """Settings of what depends on its inputs and the root seed alone."""


@dataclass(frozen=True, kw_only=True)
class Product:
    """What all declarations share.

    Attributes
    ----------
    name : str
        Name of the function, of its module, of the file and of the rule.
    title : str
        One line for people.
    inputs : tuple of str, or callable
        Names of tables, arrays and models that it is computed from: ``NAME`` for all of it,
        ``NAME/RUN`` for one run, ``NAME/RUN:{part}`` for the shard of that run with the same number
        as the shard at hand. A callable returns them for the configuration and the name of a run,
        which is None for a product without shards.
    settings : callable
        Configuration -> everything else that it depends on, apart from the root seed.
    shards : Shards, optional
    compute : callable
        Called as ``compute(*inputs, config)``, for a shard as ``compute(*inputs, config, run)``.
        Tables are passed as DataFrames, models as paths, arrays as lists of paths.
    """

    name: str
    title: str
    inputs: Inputs = ()
    settings: Callable[[Config], object] = no_settings
    shards: Shards | None = None
    compute: Callable[..., Any]

    suffix = ""
    folder = "data"

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.compute(*args, **kwargs)

    def input_names(self, config: Config, run: str | None = None) -> tuple[str, ...]:
        """Names of the inputs, of one run if it has runs."""
        return tuple(self.inputs(config, run) if callable(self.inputs) else self.inputs)

    def file(self, shard: Shard | None = None) -> PurePosixPath:
        """Where it is stored, relative to the folder of the run."""
        if shard is None:
            return PurePosixPath("tables") / f"{self.name}{self.suffix}"
        return PurePosixPath(self.folder) / self.name / f"{shard.name}{self.suffix}"


@dataclass(frozen=True, kw_only=True)
class Table(Product):
    """A table: one tidy Parquet file.

    Attributes
    ----------
    columns : tuple of Column
    expected : callable, optional
        Configuration -> which rows a complete table has; by default any number above 0.
    expected_shard : callable, optional
        Configuration and shard -> which rows it has; by default any number above 0.
    gather : callable, optional
        All rows of all shards, DataFrame -> the rows of the table.
    shards_only : bool
        Whether the rows are kept in shards alone, because no table is read as a whole.
    """

    columns: tuple[Column, ...]
    expected: Callable[[Config], Expectation] | None = None
    expected_shard: Callable[[Config, Shard], Expectation] | None = None
    gather: Callable[[pd.DataFrame], pd.DataFrame] | None = None
    shards_only: bool = False

    suffix = ".parquet"

    @property
    def key(self) -> list[str]:
        """Names of the columns that identify a row."""
        return [column.name for column in self.columns if column.key]

    @property
    def column_names(self) -> list[str]:
        return [column.name for column in self.columns]


@dataclass(frozen=True, kw_only=True)
class Arrays(Product):
    """Arrays in HDF5 files.

    ``compute`` returns the arrays by name, and texts about them by name. For a shard it is called
    as ``compute(*inputs, config, shard)``.
    """

    suffix = ".h5"


@dataclass(frozen=True, kw_only=True)
class Model(Product):
    """A trained model, one file per run.

    ``compute(*inputs, config, run, output)`` writes the model and, if it has one, its training
    curve, a shard of the table `curve`; `output` is a :class:`TrainingOutput`.

    Attributes
    ----------
    path : str
        Path of the file relative to the folder of the run, with ``{run}``.
    curve : str, optional
        Name of the table.
    """

    path: str
    curve: str | None = None

    def file(self, shard: Shard | None = None) -> PurePosixPath:
        if shard is None:
            raise ValueError(f"{self.name} has a file per run")
        return PurePosixPath(self.path.format(run=shard.run))


@dataclass(frozen=True, kw_only=True)
class Figure(Product):
    """A figure, saved as PNG and PDF: ``compute(tables, config)`` returns a matplotlib figure."""

    suffix = ".png"

    def file(self, shard: Shard | None = None) -> PurePosixPath:
        return PurePosixPath("figures") / f"{self.name}{self.suffix}"


@dataclass(frozen=True, kw_only=True)
class Animation(Product):
    """A GIF: ``compute(*inputs, config, run, out)`` writes it; `run` is None without shards."""

    suffix = ".gif"

    def file(self, shard: Shard | None = None) -> PurePosixPath:
        run = f"_{shard.run}" if shard else ""
        return PurePosixPath("figures") / f"{self.name}{run}{self.suffix}"


def table(
    *,
    title: str,
    columns: Sequence[Column],
    inputs: Inputs = (),
    settings: Callable[[Config], object] = no_settings,
    expected: Callable[[Config], Expectation] | None = None,
    expected_shard: Callable[[Config, Shard], Expectation] | None = None,
    shards: Shards | None = None,
    gather: Callable[[pd.DataFrame], pd.DataFrame] | None = None,
    shards_only: bool = False,
) -> Callable[[Callable[..., Any]], Table]:
    """Declare a table that the decorated function computes; see :class:`Table`.

    The function returns a DataFrame, or a :class:`Batched`, which it must do for shards.
    """
    return lambda function: Table(
        name=function.__name__, title=title, columns=tuple(columns), inputs=inputs,
        settings=settings, expected=expected, expected_shard=expected_shard, shards=shards,
        gather=gather, shards_only=shards_only, compute=function,
    )  # fmt: skip


def arrays(
    *,
    title: str,
    inputs: Inputs = (),
    settings: Callable[[Config], object] = no_settings,
    shards: Shards | None = None,
) -> Callable[[Callable[..., Any]], Arrays]:
    """Declare arrays that the decorated function computes; see :class:`Arrays`."""
    return lambda function: Arrays(
        name=function.__name__, title=title, inputs=inputs, settings=settings,
        shards=shards, compute=function,
    )  # fmt: skip


def model(
    *, title: str, path: str, shards: Shards, inputs: Inputs = (), curve: str | None = None
) -> Callable[[Callable[..., Any]], Model]:
    """Declare a model that the decorated function trains; see :class:`Model`."""
    return lambda function: Model(
        name=function.__name__, title=title, inputs=inputs, shards=shards, path=path,
        curve=curve, compute=function,
    )  # fmt: skip


def figure(
    *,
    title: str,
    inputs: Inputs = (),
    settings: Callable[[Config], object] = no_settings,
) -> Callable[[Callable[..., Any]], Figure]:
    """Declare a figure that the decorated function draws; see :class:`Figure`."""
    return lambda function: Figure(
        name=function.__name__, title=title, inputs=inputs, settings=settings,
        compute=function,
    )  # fmt: skip


def animation(
    *,
    title: str,
    inputs: Inputs = (),
    settings: Callable[[Config], object] = no_settings,
    shards: Shards | None = None,
) -> Callable[[Callable[..., Any]], Animation]:
    """Declare an animation that the decorated function writes; see :class:`Animation`."""
    return lambda function: Animation(
        name=function.__name__, title=title, inputs=inputs, settings=settings,
        shards=shards, compute=function,
    )  # fmt: skip
