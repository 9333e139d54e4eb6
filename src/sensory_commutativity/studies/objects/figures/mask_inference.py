"""SC-experiments in the training apartment, and what RAFT makes of them (paper, Fig. "dataset", lower half)."""

from __future__ import annotations

from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from .mask_generalisation import examples


@figure(
    title="SC-experiments in the training apartment, and what RAFT makes of them",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_inference(tables: dict, config: Config) -> Figure:
    figure = examples(tables["mask_examples"], ["as-trained"])
    tests = config.masks.tests
    figure.suptitle(
        f"SC-experiments of {tests.sequence_length} steps in the training apartment, new situations:\n"
        "moved at the 10th, 50th and 90th percentile of overlap, then the first tuple of each other outcome",
        fontsize=8.5,
    )
    return figure
