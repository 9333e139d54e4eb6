"""Common style of all figures, and how figures and animations are saved."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence
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
from numpy.typing import ArrayLike
from PIL.Image import Image

from ..storage.atomic import atomic_write
from ..storage.seal import SEAL, SEAL_KEY, seal
from .config import Config
from .provenance import provenance

if TYPE_CHECKING:
    from ..worlds.apartment.robots.robot import Robot

# Colours that colour-blind readers can distinguish: Okabe and Ito (2008), Color Universal Design,
# https://jfly.uni-koeln.de/color/
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#8A8A8A"
DARK_GREY = "#555555"
"""Of symbols in legends that stand for several colours."""

DOF_COLOURS = {
    "base-longitudinal": BLUE,
    "base-rotation": SKY,
    "left-shoulder": VERMILION,
    "right-shoulder": ORANGE,
    "left-elbow": GREEN,
    "right-elbow": PURPLE,
    "head": GREY,
    "eyelid": BLACK,
}
"""Colours of the degrees of freedom of Flatland, in the order of the figures."""
DOF_ORDER = list(DOF_COLOURS)
DOF_MARKERS = dict(zip(DOF_ORDER, "osv^<>DX", strict=True))
GROUP_COLOURS = {
    "wheel": BLUE, "torso": VERMILION, "shoulder": ORANGE, "elbow": GREEN, "wrist": PURPLE
}  # fmt: skip
"""Colours of groups of joints; other groups get the remaining colours."""

SPACE_COLOURS = {
    "full": BLACK, "truncated": BLUE, "adapted": VERMILION, "base-random": ORANGE,
    "random-half": GREEN, "inverse": PURPLE,
}  # fmt: skip
SPACE_MARKERS = {
    "full": "o", "truncated": "s", "adapted": "^", "base-random": "P", "random-half": "D",
    "inverse": "v",
}  # fmt: skip
SPACE_LINES = {
    "full": "-", "truncated": "-", "adapted": "-", "base-random": "-.", "random-half": "--",
    "inverse": ":",
}  # fmt: skip
MEASURE_LABELS = {
    "final_return": "final return",
    "auc": "mean return over the run",
    "success_rate": "final success rate",
    "steps_to_threshold": "steps to the threshold return (thousands)",
}

MODEL_LABELS = {"raft": "RAFT", "flownet": "FlowNet-S", "difference": "image difference"}
MODEL_STYLES = {
    "raft": (VERMILION, "-", "o"), "flownet": (BLUE, "--", "s"), "difference": (GREY, ":", "^")
}  # fmt: skip
"""Colour, line style and marker of each model."""

STYLE: dict[Any, Any] = {
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


# ---- saving -----------------------------------------------------------------------------------


def save_figure(draw: Callable[[], Figure], out: Path, config: Config) -> None:
    """Draw a figure in the common style, and save it as PNG and, beside it, as PDF.

    The files hold the provenance but no date, so that equal tables give equal files.

    Parameters
    ----------
    draw : callable
        Returns the figure. Called within the common style.
    out : Path
        The PNG file.
    config : Config
    """
    png, pdf = render_figure(draw, provenance(config))
    for path, content in ((out, png), (out.with_suffix(".pdf"), pdf)):
        with atomic_write(path) as temporary:
            temporary.write_bytes(content)


def render_figure(
    draw: Callable[[], Figure], metadata: Mapping[str, str], sealed: bool = True
) -> tuple[bytes, bytes]:
    """Draw a figure in the common style: the contents of a PNG and of a PDF file.

    Parameters
    ----------
    draw : callable
        Returns the figure. Called within the common style.
    metadata : mapping of str to str
        What both files say of themselves.
    sealed : bool
        Whether the PDF carries a hash of itself (:mod:`..storage.seal`); PNG has checksums.
    """
    png, pdf = io.BytesIO(), io.BytesIO()
    with plt.rc_context(STYLE):
        figure = draw()
        figure.savefig(png, format="png", metadata={"Software": None, **metadata})
        omitted = dict.fromkeys(("CreationDate", "Producer", "Creator"))
        keywords = json.dumps({SEAL_KEY: SEAL, **metadata} if sealed else dict(metadata))
        figure.savefig(pdf, format="pdf", metadata={**omitted, "Keywords": keywords})
    plt.close(figure)
    return png.getvalue(), seal(pdf.getvalue()) if sealed else pdf.getvalue()


class GifWriter(PillowWriter):
    """Context manager that writes an animation as GIF, with the provenance as its comment.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        What :meth:`grab_frame` captures. Closed at the end.
    out : Path
    config : Config
    fps : int
        Frames per second.
    dpi : int
        Pixels per inch of the figure.
    """

    def __init__(self, figure: Figure, out: Path, config: Config, fps: int, dpi: int):
        super().__init__(fps=fps)
        self._frames: list[Image]  # set by PillowWriter.setup
        self._figure, self._dpi = figure, dpi
        self._comment = json.dumps({SEAL_KEY: SEAL, **provenance(config)})
        self._writing = atomic_write(out)

    def __enter__(self) -> GifWriter:
        self.setup(self._figure, str(self._writing.__enter__()), dpi=self._dpi)
        return self

    def __exit__(self, kind: Any, error: Any, traceback: Any) -> None:
        if kind is None:
            self.finish()
        self._writing.__exit__(kind, error, traceback)
        plt.close(self._figure)

    def finish(self) -> None:
        """Write the file and seal it. PillowWriter's own method writes no comment."""
        first, *rest = self._frames
        content = io.BytesIO()
        first.save(
            content, format="GIF", save_all=True, append_images=rest,
            duration=int(1000 / self.fps), loop=0, comment=self._comment,
        )  # fmt: skip
        Path(self.outfile).write_bytes(seal(content.getvalue()))


# ---- labels -----------------------------------------------------------------------------------


def dof_label(dof: str, lines: bool = False) -> str:
    """Label of a degree of freedom: ``left-elbow`` gives "left elbow", on two lines if asked."""
    return dof.replace("-", "\n" if lines else " ")


def label_test_set(test_set: str) -> str:
    """Label of a test set of the mask models."""
    return test_set.replace("-", " ")


def format_probability(value: float, digits: int) -> str:
    """Format a probability; only 1 itself becomes "1", and no smaller value is rounded up to 1."""
    return "1" if value == 1 else f"{min(value, 1 - 10**-digits):.{digits}f}"


def format_p_value(p: float) -> str:
    """Format a p-value with its name, such as "p = 0.012"."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}" if p < 0.0995 else f"p = {p:.2f}"


# ---- degrees of freedom of a robot ------------------------------------------------------------


def group_colours(robot: Robot) -> dict[str, str]:
    """Colour of each group of degrees of freedom, in the order of the robot's description.

    A group of GROUP_COLOURS has the same colour for all robots.
    """
    groups = list(dict.fromkeys(dof.group for dof in robot.description.dofs))
    unknown = [group for group in groups if group not in GROUP_COLOURS]
    spare = (SKY, GREY, BLACK, YELLOW)
    return {
        group: GROUP_COLOURS.get(group) or spare[unknown.index(group) % len(spare)]
        for group in groups
    }


def dof_styles(robot: Robot) -> dict[str, dict[str, Any]]:
    """Line of each degree of freedom: the colour of its group, its own marker and line style."""
    colours = group_colours(robot)
    lines = ("-", "--", ":")
    styles = [dict(marker=marker, linestyle=line) for line in lines for marker in "os^vD"]
    return {
        dof.name: dict(color=colours[dof.group], **styles[i % len(styles)])
        for i, dof in enumerate(robot.description.dofs)
    }


# ---- parts of figures -------------------------------------------------------------------------


def select_reference(scp: pd.DataFrame, config: Config, threshold: float = 0.0) -> pd.DataFrame:
    """Rows of flatland_scp of the reference agent in the reference world, in DOF_ORDER."""
    reference = config.flatland.reference
    rows = scp[
        (scp["world"] == reference.world)
        & (scp["agent"] == reference.agent)
        & (scp["threshold"] == threshold)
    ]
    return rows.set_index("dof").loc[DOF_ORDER].reset_index()


def error_lengths(values: ArrayLike, low: ArrayLike, high: ArrayLike) -> np.ndarray:
    """Lengths of error bars for the intervals [low, high]: (2, n), for the argument `yerr`."""
    values = np.asarray(values, float)
    return np.maximum(0.0, [values - np.asarray(low), np.asarray(high) - values])


def draw_bars(
    axes: Axes,
    dofs: Sequence[str],
    values: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    colours: Sequence[str],
    digits: int | None = None,
) -> None:
    """Draw a bar per degree of freedom with its interval [low, high].

    With `digits`, the value, a probability, is written above its bar.
    """
    values, high = np.asarray(values, float), np.asarray(high)
    axes.bar(range(len(dofs)), values, color=colours, width=0.75)
    axes.errorbar(
        range(len(dofs)), values, yerr=error_lengths(values, low, high), fmt="none",
        ecolor="#444444", elinewidth=1.2, capsize=2.5,
    )  # fmt: skip
    slant_xticks(axes, [dof_label(dof) for dof in dofs])
    if digits is not None:
        for x, (value, top) in enumerate(zip(values, high, strict=True)):
            annotate_above(axes, x, max(value, top), format_probability(value, digits), 7)


def draw_dof_bars(
    axes: Axes, values: ArrayLike, low: ArrayLike, high: ArrayLike, digits: int | None = None
) -> None:
    """Draw a bar per degree of freedom of Flatland, in DOF_ORDER; see :func:`draw_bars`."""
    draw_bars(axes, DOF_ORDER, values, low, high, list(DOF_COLOURS.values()), digits)


def annotate_above(axes: Axes, x: float, y: float, text: str, size: float, gap: float = 3) -> None:
    """Write `text`, centred, `gap` points above a point."""
    axes.annotate(
        text, (x, y), textcoords="offset points", xytext=(0, gap), ha="center", fontsize=size
    )


def slant_xticks(
    axes: Axes, labels: Sequence[str], rotation: float = 45, size: float | None = None
) -> None:
    """Put a slanted label at each of 0, 1, 2, ... on the x axis."""
    style: dict[str, Any] = {} if size is None else {"fontsize": size}
    axes.set_xticks(
        range(len(labels)), labels, rotation=rotation, ha="right", rotation_mode="anchor", **style
    )


def set_probability_axis(axes: Axes, name: str = "SCP") -> None:
    """Make the y axis one of probabilities, with a dotted line at 1."""
    axes.set_ylim(0, 1.12)
    axes.set_yticks(np.linspace(0, 1, 6))
    axes.set_ylabel(name)
    axes.axhline(1, color=GREY, linewidth=0.8, linestyle=":", zorder=0)
