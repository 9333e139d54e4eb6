"""SC-experiments with objects, apartments and a field of view that no model was trained with
(paper, Fig. "generalisation")."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ..pictures import draw_examples, read_examples


@figure(
    title="Predicted masks for new objects, apartments and fields of view",
    inputs=["mask_examples"],
    settings=lambda config: config.masks,
)
def mask_generalisation(files: dict[str, list[Path]], config: Config) -> Figure:
    """A row of examples per test set, except the one as trained."""
    examples = read_examples(files["mask_examples"])
    test_sets = dict.fromkeys(examples.test_sets)
    figure = draw_examples(examples, [name for name in test_sets if name != "as-trained"])
    figure.suptitle(
        "Moved at the 10th, 50th and 90th percentile of overlap, then the first tuple of each "
        "other outcome",
        fontsize=9,
    )
    return figure
