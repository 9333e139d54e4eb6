"""The result of a measurement: distances, SCPs, their order, a figure, and a file."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ..errors import ArgumentError, TableError
from ..scp.estimate import estimate_scp
from ..scp.world import Dof
from ..storage.columns import FLOAT, INT, TEXT, Column
from ..storage.provenance import environment
from ..storage.seal import SEAL_KEY
from ..storage.tables import ROWS_HASH, has_column, read_metadata, read_table, write_table
from . import controls, returning
from .arguments import check_thresholds
from .order import DofOrder, order_dofs
from .report import add_report, describe_report
from .until import Stopping, order_sequentially

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TABLE = "measurement"
"""Name of the table in a file of :meth:`Measurement.save`."""
COLUMNS = (
    Column("experiment", INT, "1", "number of the start situation", key=True),
    Column("dof", TEXT, "", "degree of freedom that acted", key=True),
    Column("distance", FLOAT, "1", "distance of the two final observations"),
)
CONTROLLED = (
    *COLUMNS,
    *(
        Column(name, FLOAT, "1", text, nullable=True)
        for name, text in controls.COLUMNS.items()
        if name != "distance"
    ),
)
"""With the controls of an environment."""
RETURNED = (
    *COLUMNS,
    *(
        Column(name, FLOAT, "1", text)
        for name, text in returning.COLUMNS.items()
        if name != "distance"
    ),
)
"""With the control of the return protocol."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
"""Of the thresholds in a figure: colours that colour-blind readers can tell apart (Okabe and Ito
2008, https://jfly.uni-koeln.de/color)."""


@dataclass(frozen=True)
class Settings:
    """What a measurement's distances depend on.

    Attributes
    ----------
    world : str
        Name of the world.
    length, rest_steps : int
        Actions in a sequence, and steps without a command after it.
    distance : str
        Name of the distance.
    seed : int
    start_sha256 : str
        SHA-256 of the first observation of the first experiment: tells worlds of one name apart.
    protocol : {"reset", "return"}
        Whether each order starts from a restored situation, or is followed by a return.
    stopping : Stopping, optional
        The rule by which sampling stopped.
    """

    world: str
    length: int
    rest_steps: int
    distance: str
    seed: int
    start_sha256: str
    protocol: str = "reset"
    stopping: Stopping | None = None

    def __post_init__(self) -> None:
        if isinstance(self.stopping, dict):  # from a file
            object.__setattr__(self, "stopping", Stopping(**self.stopping))


@dataclass(frozen=True, eq=False)
class Measurement:
    """The SCP of every degree of freedom of a world.

    Attributes
    ----------
    distances : float64 (n, n_dofs)
        Distance of the two final observations, one row per start, one column per degree of freedom;
        NaN where sampling until ordered needed no experiment, or a log has none.
    dofs : tuple of Dof
    thresholds : tuple of float
        Largest distances that count as equal.
    settings : Settings
    controls : mapping of str to float64 (n, n_dofs)
        What the controls of an environment (:data:`.controls.COLUMNS`) or of the return protocol
        (:data:`.returning.COLUMNS`) measured; empty for a world without them.
    choices : tuple of str
        What was chosen for an environment, and why, for people.
    provenance : mapping of str to str
        Code, platform and packages that measured.
    """

    distances: np.ndarray
    dofs: tuple[Dof, ...]
    thresholds: tuple[float, ...]
    settings: Settings
    controls: Mapping[str, np.ndarray] = field(default_factory=dict)
    choices: tuple[str, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=environment)

    def __len__(self) -> int:
        """Number of start situations, n."""
        return len(self.distances)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the degrees of freedom."""
        return tuple(dof.name for dof in self.dofs)

    @property
    def experiments(self) -> pd.DataFrame:
        """One row per SC-experiment: experiment, dof, distance, and the controls, if any."""
        n, n_dofs = self.distances.shape
        frame = pd.DataFrame(
            dict(
                experiment=np.repeat(np.arange(n), n_dofs),
                dof=np.tile(np.array(self.names, object), n),
                distance=self.distances.ravel(),
                **{name: values.ravel() for name, values in self.controls.items()},
            )
        )
        return frame[frame["distance"].notna()].reset_index(drop=True)

    @property
    def table(self) -> pd.DataFrame:
        """One row per degree of freedom and threshold: dof, threshold, n, commuted, scp, ci_low,
        ci_high (95 %, Wilson); for an environment also the columns of :func:`.report.add_report`,
        and by the return protocol those of :func:`.returning.add_relative`.
        """
        table = estimate_scp(self.experiments, ["dof"], self.thresholds)
        if self.settings.protocol == returning.RETURN:
            return returning.add_relative(table, self.distances, self.controls, self.names)
        return add_report(table, self.distances, self.controls, self.names)

    def with_thresholds(self, *thresholds: float) -> Measurement:
        """Return the same experiments with other thresholds; nothing is played again."""
        return replace(self, thresholds=check_thresholds(thresholds))

    def scp(self, threshold: float | None = None) -> dict[str, float]:
        """SCP of each degree of freedom, at the first threshold by default."""
        order = self.order(threshold).table.set_index("dof")["scp"]
        return {name: float(order[name]) for name in self.names}

    def order(self, threshold: float | None = None, alpha: float = 0.05) -> DofOrder:
        """Order the degrees of freedom from lowest to highest SCP.

        Parameters
        ----------
        threshold : float, optional
            By default the first of `thresholds`.
        alpha : float in (0, 1)
            Level at which two degrees of freedom count as different.
        """
        if threshold is None:
            threshold = self.thresholds[0]
        (threshold,) = check_thresholds(threshold)
        if not 0 < alpha < 1:
            raise ArgumentError(f"alpha: expected a number between 0 and 1, got {alpha!r}")
        stopping = self.settings.stopping
        if stopping is not None:
            if threshold != stopping.threshold:
                raise ArgumentError(
                    f"threshold: sampling stopped by the order at {stopping.threshold:g}, so that "
                    "it says nothing about others; leave it out"
                )
            return order_sequentially(self.distances, self.names, stopping)
        complete = ~np.isnan(self.distances).any(axis=1)  # a log may have more of one than another
        return order_dofs(self.distances[complete], self.names, threshold, alpha)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the SCP of every degree of freedom with its 95 % interval, lowest at the top.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            By default a new figure.
        """
        if ax is None:
            import matplotlib.pyplot as plt

            height = 1.4 + 0.3 * len(self.dofs)
            _, ax = plt.subplots(figsize=(6.4, height), layout="constrained")
        order = {name: i for i, name in enumerate(self.order().dofs)}
        spread = 0.18 if len(self.thresholds) > 1 else 0.0
        offsets = np.linspace(-spread, spread, len(self.thresholds))
        for k, (threshold, rows) in enumerate(self.table.groupby("threshold", sort=False)):
            y = rows["dof"].map(order).to_numpy() + offsets[k]
            errors = [rows["scp"] - rows["ci_low"], rows["ci_high"] - rows["scp"]]
            ax.errorbar(
                rows["scp"], y, xerr=errors, fmt="o", markersize=4, capsize=2,
                color=COLOURS[k % len(COLOURS)], label=f"threshold {threshold:g}",
            )  # fmt: skip
        ax.set_yticks(range(len(order)), list(order))
        ax.set_ylim(len(order) - 0.5, -0.5)
        ax.set_xlim(-0.03, 1.03)
        ax.grid(axis="x", alpha=0.3)
        ax.set_xlabel("SCP (95 % interval)")
        ax.set_title(f"{self.settings.world}: n = {len(self):,} starts", fontsize="medium")
        if len(self.thresholds) > 1:
            ax.legend(fontsize="small")
        return ax

    def save(self, path: str | Path) -> Path:
        """Write a Parquet file: the experiments as a table, all else in its metadata."""
        path = Path(path)
        contents = dict(
            settings=asdict(self.settings),
            thresholds=list(self.thresholds),
            dofs=[asdict(dof) for dof in self.dofs],
        )
        contents["choices"] = list(self.choices)
        metadata = {TABLE: json.dumps(contents), **self.provenance}
        columns: tuple[Column, ...] = COLUMNS
        if self.controls:
            columns = RETURNED if "control" in self.controls else CONTROLLED
        write_table(path, TABLE, columns, self.experiments, metadata)
        return path

    @classmethod
    def load(cls, path: str | Path) -> Measurement:
        """Read a file of :meth:`save`.

        Raises
        ------
        TableError
            If the file is missing, damaged, incomplete, or something else.
        """
        path = Path(path)
        kinds = (CONTROLLED, RETURNED)
        columns = next((kind for kind in kinds if has_column(path, kind[-1].name)), COLUMNS)
        frame = read_table(path, TABLE, columns, require_hash=False)  # earlier versions had none
        metadata = read_metadata(path)
        try:
            contents = json.loads(metadata.pop(TABLE))
            dofs = tuple(Dof(**dof) for dof in contents["dofs"])
            settings = Settings(**contents["settings"])
            thresholds = check_thresholds(contents["thresholds"])
            choices = tuple(contents.get("choices", ()))
        except (KeyError, TypeError, ValueError):
            raise TableError(
                f"{path}: its metadata do not describe a measurement; measure again"
            ) from None
        gaps = settings.stopping is not None or settings.protocol == returning.RETURN
        if gaps:
            frame = _fill(frame, [dof.name for dof in dofs])
        n, names = len(frame) // max(len(dofs), 1), [dof.name for dof in dofs]
        complete = len(frame) == n * len(dofs) and (
            frame["dof"].tolist() == names * n
            and frame["experiment"].tolist() == np.repeat(np.arange(n), len(dofs)).tolist()
        )
        if not complete or not n or (frame["distance"].isna().any() and not gaps):
            raise TableError(f"{path}: experiments are missing or out of order; measure again")
        for key in ("table", ROWS_HASH, SEAL_KEY):
            metadata.pop(key, None)
        distances = frame["distance"].to_numpy().reshape(n, len(dofs))
        controls = {
            column.name: frame[column.name].to_numpy().reshape(n, len(dofs))
            for column in columns[len(COLUMNS) :]
        }
        return cls(distances, dofs, thresholds, settings, controls, choices, metadata)

    def __str__(self) -> str:
        settings = self.settings
        lines = [
            f"SCP of {settings.world}: {len(self):,} starts, sequences of {settings.length} "
            f"actions, distance {settings.distance}, seed {settings.seed}"
            + (", return protocol" if settings.protocol == returning.RETURN else "")
        ]
        width = max(map(len, self.names))
        thresholds = len(self.thresholds) > 1
        head = f"{'':{width}}  {'threshold':>9}" if thresholds else f"{'':{width}}"
        lines.append(f"{head}  {'SCP':>5}  95 % interval")
        for row in self.table.itertuples():
            threshold = f"  {row.threshold:>9g}" if thresholds else ""
            interval = f"[{row.ci_low:.3f}, {row.ci_high:.3f}]"
            lines.append(f"{row.dof:{width}}{threshold}  {row.scp:5.3f}  {interval}")
        if settings.protocol == returning.RETURN:
            described = returning.describe_relative(self.table, self.thresholds)
            lines = [lines[0], *self.choices, *described]
        elif self.controls:
            lines = [lines[0], *self.choices, *describe_report(self.table, self.thresholds)]
        return "\n".join(lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        """The table, for notebooks."""
        head = "<br>".join(html.escape(line) for line in (str(self).splitlines()[0], *self.choices))
        return f"<p>{head}</p>{self.table.to_html(index=False, float_format='%.3f')}"


def _fill(frame: pd.DataFrame, names: Sequence[str]) -> pd.DataFrame:
    """Add a row, of NaN, for every experiment that sampling until ordered did not need."""
    experiments = np.arange(int(frame["experiment"].max()) + 1 if len(frame) else 0)
    wanted = pd.MultiIndex.from_product([experiments, names], names=["experiment", "dof"])
    return frame.set_index(["experiment", "dof"]).reindex(wanted).reset_index()


def same_measurement(
    found: Measurement, settings: Settings, names: Sequence[str], choices: Sequence[str]
) -> str:
    """What differs between a kept measurement and the one asked for; empty if nothing does."""
    asked: dict[str, Any] = {**asdict(settings), "dofs": tuple(names), "choices": tuple(choices)}
    kept: dict[str, Any] = {**asdict(found.settings), "dofs": found.names}
    kept["choices"] = found.choices
    different = [key for key, value in asked.items() if kept[key] != value]
    return ", ".join(f"{key} {kept[key]} (now {asked[key]})" for key in different)
