"""SC-experiments with objects, apartments and a field of view that were not trained with (paper, Fig. "generalisation")."""

from __future__ import annotations

import json

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from ....change_detection.outcome import OUTCOMES
from ...config import Config
from ...declarations import figure
from ...plotting import test_set_label
from ..pictures import legend, show_column


def examples(read: tuple[dict[str, np.ndarray], dict[str, str]], wanted: list[str]) -> Figure:
    """The tuples put aside of some test sets, a row of pairs for each; `read`: arrays of mask_examples and what they come from."""
    arrays, about = read
    names = json.loads(about["test_sets"])
    rows = [[k for k, name in enumerate(names) if name == test_set] for test_set in wanted]
    across = max(1, *(len(row) for row in rows))
    figure, grid = plt.subplots(
        2 * len(rows), across, figsize=(1.75 * across, 3.85 * len(rows)), squeeze=False
    )
    for axes in grid.flat:
        axes.set_axis_off()
    for r, row in enumerate(rows):
        for c, k in enumerate(row):
            column = grid[2 * r : 2 * r + 2, c]
            for axes in column:
                axes.set_axis_on()
            overlap = (
                f", IoU {arrays['overlap'][k]:.2f}" if np.isfinite(arrays["overlap"][k]) else ""
            )
            said = OUTCOMES[arrays["predicted"][k]]
            predicted = (arrays["probabilities"][k] > 127) & (
                said == "moved"
            )  # another view is another view everywhere: no outlines
            title = f"{test_set_label(wanted[r])}\ntrue: {OUTCOMES[arrays['outcome'][k]]}{overlap}\npredicted: {said}"
            show_column(column, arrays["pictures"][k], arrays["masks"][k], predicted, title)
    legend(figure)
    return figure


@figure(
    title="SC-experiments with objects, apartments and a field of view that were not trained with",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_generalisation(tables: dict, config: Config) -> Figure:
    names = list(dict.fromkeys(json.loads(tables["mask_examples"][1]["test_sets"])))
    figure = examples(tables["mask_examples"], [name for name in names if name != "as-trained"])
    figure.suptitle(
        "Moved at the 10th, 50th and 90th percentile of overlap, then the first tuple of each other outcome",
        fontsize=9,
    )
    return figure
