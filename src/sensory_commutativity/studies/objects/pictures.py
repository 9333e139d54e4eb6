"""Pairs of pictures with their masks, as several figures show them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..plotting import SKY, VERMILION

TRUTH, PREDICTION = SKY, VERMILION


def show(
    axes: Axes,
    picture: np.ndarray,
    truth: np.ndarray | None = None,
    prediction: np.ndarray | None = None,
) -> None:
    """A picture, uint8 (h, w, 3), with the outlines of its true mask and of the predicted one, bool (h, w)."""
    axes.imshow(picture, interpolation="nearest")
    for mask, colour, style in ((truth, TRUTH, "solid"), (prediction, PREDICTION, "dashed")):
        if mask is not None and mask.any() and not mask.all():
            height, width = mask.shape
            around = np.pad(mask, 1).astype(
                float
            )  # so that outlines are closed where things leave the picture
            axes.contour(
                np.arange(-1, width + 1),
                np.arange(-1, height + 1),
                around,
                [0.5],
                colors=[colour],
                linewidths=1.3,
                linestyles=style,
            )
            axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)


def show_mask(axes: Axes, mask: np.ndarray) -> None:
    """A mask, bool (h, w): white where something changed."""
    axes.imshow(mask, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])


def show_column(
    column: Sequence[Axes],
    pictures: np.ndarray,
    truth: np.ndarray,
    prediction: np.ndarray,
    title: str,
) -> None:
    """Both pictures of a tuple, one below the other."""
    for axes, picture, true, predicted in zip(column, pictures, truth, prediction, strict=True):
        show(axes, picture, true, predicted)
    column[0].set_title(title, fontsize=8)


def legend(figure: Figure) -> None:
    """What the outlines mean, below everything."""
    lines = [
        Line2D([], [], color=TRUTH, label="what moved"),
        Line2D([], [], color=PREDICTION, linestyle="dashed", label="what RAFT predicts"),
    ]
    figure.legend(handles=lines, fontsize=8, loc="outside lower center", ncols=2)
