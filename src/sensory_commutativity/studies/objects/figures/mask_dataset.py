"""Pairs that the models learn from, of each outcome (paper, Fig. "dataset", upper half)."""

from __future__ import annotations

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ....change_detection.outcome import OUTCOMES
from ...config import Config
from ...declarations import figure
from ..pictures import show, show_mask

_ROWS = ("first picture", "its mask", "second picture", "its mask")


@figure(
    title="Pairs that the models learn from, of each outcome",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_dataset(tables: dict, config: Config) -> Figure:
    arrays, _ = tables["mask_examples"]
    outcome, n = arrays["dataset_outcome"], len(arrays["dataset_outcome"])
    figure, grid = plt.subplots(4, n, figsize=(1.45 * n, 6.4), squeeze=False)
    for k in range(n):
        for view in (0, 1):
            show(grid[2 * view, k], arrays["dataset_pictures"][k, view])
            show_mask(grid[2 * view + 1, k], arrays["dataset_masks"][k, view])
        grid[0, k].set_title(OUTCOMES[outcome[k]], fontsize=9)
    for axes, name in zip(grid[:, 0], _ROWS, strict=True):
        axes.set_ylabel(name, fontsize=8.5)
    data = config.masks.data
    figure.suptitle(
        f"The first pairs of {data.pairs:,} of each outcome, made in {data.scene}, field of view {data.field_of_view:g} degrees; white: changed",
        fontsize=9.5,
    )
    return figure
