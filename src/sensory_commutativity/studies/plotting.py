"""The look that all figures share, and how they are saved."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.animation import PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..storage.atomic import atomic_write
from .config import Config
from .provenance import provenance

if TYPE_CHECKING:
    from ..worlds.apartment.robots.robot import Robot

# Okabe and Ito's colours, which colour-blind readers can tell apart
BLACK, ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE = (
    "#000000", "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7",
)  # fmt: skip
GREY = "#8A8A8A"

DOF_COLOURS = {
    "base-longitudinal": BLUE,
    "base-rotation": SKY,
    "head": GREY,
    "eyelid": BLACK,
    "left-shoulder": VERMILION,
    "right-shoulder": ORANGE,
    "left-elbow": GREEN,
    "right-elbow": PURPLE,
}
DOF_ORDER = [
    "base-longitudinal",
    "base-rotation",
    "left-shoulder",
    "right-shoulder",
    "left-elbow",
    "right-elbow",
    "head",
    "eyelid",
]
DOF_MARKERS = dict(zip(DOF_ORDER, "osv^<>DX", strict=True))

SPACE_COLOURS = {
    "full": BLACK,
    "truncated": BLUE,
    "adapted": VERMILION,
    "random-half": GREEN,
    "inverse": PURPLE,
}
SPACE_MARKERS = {"full": "o", "truncated": "s", "adapted": "^", "random-half": "D", "inverse": "v"}
SPACE_LINES = {"full": "-", "truncated": "-", "adapted": "-", "random-half": "--", "inverse": ":"}
MEASURE_LABELS = {
    "final_return": "final return",
    "auc": "mean return over the run",
    "success_rate": "final success rate",
    "steps_to_threshold": "steps to the threshold return (thousands)",
}

GROUP_COLOURS = {
    "wheel": BLUE,
    "torso": VERMILION,
    "shoulder": ORANGE,
    "elbow": GREEN,
    "wrist": PURPLE,
}
"""Kinds of joints that the robots here have; others are given what is left."""

_RC = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "savefig.dpi": 160,
    "pdf.fonttype": 42,
}


def group_colours(robot: Robot) -> dict[str, str]:
    """Colour of each group of a robot's degrees of freedom, in the order in which it names them; the same for all robots."""
    groups = list(dict.fromkeys(dof.group for dof in robot.description.dofs))
    others = [group for group in groups if group not in GROUP_COLOURS]
    spare = (SKY, GREY, BLACK, YELLOW)
    return {
        group: GROUP_COLOURS.get(group) or spare[others.index(group) % len(spare)]
        for group in groups
    }


def dof_styles(robot: Robot) -> dict[str, dict[str, str]]:
    """How each degree of freedom of a robot is drawn as a line: colour of its group, marker and dashes of its own."""
    colours = group_colours(robot)
    ways = [(marker, line) for line in ("-", "--", ":") for marker in "os^vD"]
    styles = [dict(marker=marker, linestyle=line) for marker, line in ways]
    return {
        dof.name: dict(color=colours[dof.group], **styles[i % len(styles)])
        for i, dof in enumerate(robot.description.dofs)
    }


MODEL_LABELS = {"raft": "RAFT", "flownet": "FlowNet-S", "difference": "image difference"}


def test_set_label(test_set: str) -> str:
    """Name of a test set of the mask predictor for people."""
    return test_set.replace("-", " ")


def dof_label(dof: str, lines: bool = False) -> str:
    """left-elbow -> left elbow, on two lines if asked."""
    return dof.replace("-", "\n" if lines else " ")


def save_figure(draw: Callable[[], Figure], out: Path, config: Config) -> None:
    """Draw a figure in the common style; save it as `out` (PNG) and beside it as PDF.

    The files hold their provenance but no date, so that equal tables give equal files.
    """
    about = provenance(config)
    with plt.rc_context(_RC):
        figure = draw()
        with atomic_write(out) as temporary:
            figure.savefig(temporary, format="png", metadata={"Software": None, **about})
        with atomic_write(out.with_suffix(".pdf")) as temporary:
            nothing = dict.fromkeys(("CreationDate", "Producer", "Creator"))
            metadata = {**nothing, "Keywords": json.dumps(about)}
            figure.savefig(temporary, format="pdf", metadata=metadata)
    plt.close(figure)


class Film(PillowWriter):
    """Context manager that writes a GIF, with its provenance as the comment.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What :meth:`grab_frame` captures; closed at the end.
    out : Path
    config : Config
    fps : int
    dpi : int
    """

    def __init__(self, figure: Figure, out: Path, config: Config, fps: int, dpi: int):
        super().__init__(fps=fps)
        self._figure, self._dpi = figure, dpi
        self._comment = json.dumps(provenance(config))
        self._writing = atomic_write(out)

    def __enter__(self) -> Film:
        self.setup(self._figure, str(self._writing.__enter__()), dpi=self._dpi)
        return self

    def __exit__(self, kind: Any, error: Any, traceback: Any) -> None:
        if kind is None:
            self.finish()
        self._writing.__exit__(kind, error, traceback)
        plt.close(self._figure)

    def finish(self) -> None:
        first, *others = self._frames
        first.save(
            self.outfile, format="GIF", save_all=True, append_images=others,
            duration=int(1000 / self.fps), loop=0, comment=self._comment,
        )  # fmt: skip


def reference_rows(scp: pd.DataFrame, config: Config, threshold: float = 0.0) -> pd.DataFrame:
    """The rows of flatland_scp of the reference agent in the reference world, in the order of the figures."""
    reference = config.flatland.reference
    rows = scp[
        (scp["world"] == reference.world)
        & (scp["agent"] == reference.agent)
        & (scp["threshold"] == threshold)
    ]
    return rows.set_index("dof").loc[DOF_ORDER].reset_index()


def dof_bars(
    axes: Axes,
    dofs: list[str],
    values: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    digits: int | None = None,
) -> None:
    """A bar per degree of freedom, coloured as everywhere, with the interval [low, high] and, if asked, its value above."""
    values = np.asarray(values, float)
    error = np.maximum(0.0, [values - np.asarray(low), np.asarray(high) - values])
    axes.bar(range(len(dofs)), values, color=[DOF_COLOURS[d] for d in dofs], width=0.75)
    axes.errorbar(
        range(len(dofs)),
        values,
        yerr=error,
        fmt="none",
        ecolor="#444444",
        elinewidth=1.2,
        capsize=2.5,
    )
    axes.set_xticks(
        range(len(dofs)),
        [dof_label(d) for d in dofs],
        rotation=45,
        ha="right",
        rotation_mode="anchor",
    )
    if digits is not None:
        for x, (value, top) in enumerate(zip(values, np.asarray(high), strict=True)):
            axes.annotate(
                probability_text(value, digits),
                (x, max(value, top)),
                textcoords="offset points",
                xytext=(0, 3),
                ha="center",
                fontsize=7,
            )


def probability_text(value: float, digits: int) -> str:
    """A probability for people: only 1 itself is written as 1, and nothing below it is rounded up to it."""
    return "1" if value == 1 else f"{min(value, 1 - 10**-digits):.{digits}f}"


def p_text(p: float) -> str:
    """A p-value for people."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.0995 else f"p = {p:.2f}"


def probability_axis(axes: Axes, name: str = "SCP") -> None:
    axes.set_ylim(0, 1.12)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.set_ylabel(name)
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
