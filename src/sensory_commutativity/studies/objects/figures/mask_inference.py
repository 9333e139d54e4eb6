"""SC-experiments in the training apartment, and what RAFT predicts (paper, Fig. "dataset", lower
half)."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ..pictures import draw_examples, read_examples


@figure(
    title="Predicted masks for SC-experiments in the training apartment",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_inference(files: dict[str, list[Path]], config: Config) -> Figure:
    """A row of examples."""
    figure = draw_examples(read_examples(files["mask_examples"]), ["as-trained"])
    figure.suptitle(
        f"SC-experiments of {config.masks.tests.sequence_length} steps in the training apartment, "
        "new situations:\nmoved at the 10th, 50th and 90th percentile of overlap, then the first "
        "tuple of each other outcome",
        fontsize=8.5,
    )
    return figure
