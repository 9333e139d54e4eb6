"""Training pairs of each outcome, with their masks (paper, Fig. "dataset", upper half)."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ..pictures import draw_mask, draw_picture, read_examples
from ..tables.mask_summary import OUTCOMES

_ROWS = ("first picture", "its mask", "second picture", "its mask")


@figure(
    title="Training pairs of each outcome, with their masks",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_dataset(files: dict[str, list[Path]], config: Config) -> Figure:
    """A column per pair: both pictures, each above its mask."""
    arrays = read_examples(files["mask_examples"]).arrays
    n = len(arrays["dataset_outcome"])
    figure, grid = plt.subplots(4, n, figsize=(1.45 * n, 6.4), squeeze=False)
    for k, outcome in enumerate(arrays["dataset_outcome"]):
        for view in (0, 1):
            draw_picture(grid[2 * view, k], arrays["dataset_pictures"][k, view])
            draw_mask(grid[2 * view + 1, k], arrays["dataset_masks"][k, view])
        grid[0, k].set_title(OUTCOMES[outcome], fontsize=9)
    for axes, name in zip(grid[:, 0], _ROWS, strict=True):
        axes.set_ylabel(name, fontsize=8.5)
    data = config.masks.data
    figure.suptitle(
        f"The first pairs of {data.pairs:,} of each outcome, made in {data.scene}, field of view "
        f"{data.field_of_view:g} degrees; white: changed",
        fontsize=9.5,
    )
    return figure
