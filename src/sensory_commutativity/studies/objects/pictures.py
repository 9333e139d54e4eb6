"""Pairs of pictures with outlines of their masks, as several figures show them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..plotting import SKY, VERMILION, label_test_set
from .tables.mask_summary import OUTCOMES

TRUTH, PREDICTION = SKY, VERMILION


class Examples(NamedTuple):
    """What the file mask_examples holds, with unpacked masks.

    Attributes
    ----------
    arrays : dict of str to array
        By the names that :func:`.mask_examples.mask_examples` gives them. Masks are bool
        (..., h, w).
    test_sets : list of str
        Test set of each of the `pictures`.
    """

    arrays: dict[str, np.ndarray]
    test_sets: list[str]


def read_examples(paths: Sequence[Path]) -> Examples:
    """Read the file mask_examples, the only one of `paths`. Raises ArrayFileError."""
    from ...storage.arrays import read_arrays, unpack_masks

    (path,) = paths
    arrays, texts = read_arrays(path, "mask_examples")
    for name in ("masks", "dataset_masks"):
        width = arrays[name.replace("masks", "pictures")].shape[-2]
        arrays[name] = unpack_masks(arrays[name], width)
    return Examples(arrays, texts.json_list("test_sets"))


def draw_examples(examples: Examples, test_sets: Sequence[str]) -> Figure:
    """Draw all examples of some test sets, a row of pairs for each test set."""
    rows = [
        [k for k, name in enumerate(examples.test_sets) if name == test_set]
        for test_set in test_sets
    ]
    n_columns = max([1, *map(len, rows)])
    figure, grid = plt.subplots(
        2 * len(rows), n_columns, figsize=(1.75 * n_columns, 3.85 * len(rows)), squeeze=False
    )
    for axes in grid.flat:
        axes.set_axis_off()
    for r, row in enumerate(rows):
        for c, k in enumerate(row):
            _draw_example(grid[2 * r : 2 * r + 2, c], examples, k)
    lines = [
        Line2D([], [], color=TRUTH, label="what moved"),
        Line2D([], [], color=PREDICTION, linestyle="dashed", label="what RAFT predicts"),
    ]
    figure.legend(handles=lines, fontsize=8, loc="outside lower center", ncols=2)
    return figure


def _draw_example(column: np.ndarray, examples: Examples, k: int) -> None:
    """Draw both pictures of the example `k`, one below the other, into a column of two axes."""
    arrays = examples.arrays
    overlap = arrays["overlap"][k]
    iou = f", IoU {overlap:.2f}" if np.isfinite(overlap) else ""
    outcome = OUTCOMES[arrays["predicted"][k]]
    # Where the view itself is different, every pixel is: an outline would mean nothing.
    predicted = (arrays["probabilities"][k] > 127) & (outcome == "moved")
    for axes, *content in zip(
        column, arrays["pictures"][k], arrays["masks"][k], predicted, strict=True
    ):
        axes.set_axis_on()
        draw_picture(axes, *content)
    column[0].set_title(
        f"{label_test_set(examples.test_sets[k])}\ntrue: {OUTCOMES[arrays['outcome'][k]]}{iou}\n"
        f"predicted: {outcome}",
        fontsize=8,
    )


def draw_picture(
    axes: Axes,
    picture: np.ndarray,
    truth: np.ndarray | None = None,
    prediction: np.ndarray | None = None,
) -> None:
    """Draw a picture, uint8 (h, w, 3), with the outlines of its masks, bool (h, w)."""
    axes.imshow(picture, interpolation="nearest")
    for mask, colour, style in ((truth, TRUTH, "solid"), (prediction, PREDICTION, "dashed")):
        if mask is not None and mask.any() and not mask.all():
            height, width = mask.shape
            padded = np.pad(mask, 1).astype(float)  # closes outlines at the edge of the picture
            axes.contour(
                np.arange(-1, width + 1), np.arange(-1, height + 1), padded, [0.5],
                colors=[colour], linewidths=1.3, linestyles=style,
            )  # fmt: skip
            axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)


def draw_mask(axes: Axes, mask: np.ndarray) -> None:
    """Draw a mask, bool (h, w): white where something changed."""
    axes.imshow(mask, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
