"""SCPs with an imagined order beside the true ones, and how well it finds what does not commute."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ...config import Config
from ...declarations import figure
from ...plotting import BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILION
from ..builders import imagined_runs

COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE)


@figure(
    title="SC-experiments with an imagined order",
    inputs=["reset_free_imagined", "reset_free_imagined_agreement",
            "reset_free_imagined_experiments"],
    settings=lambda config: [run.threshold for run in imagined_runs(config).values()],
)  # fmt: skip
def reset_free_imagined(tables: dict[str, pd.DataFrame], config: Config) -> Figure:
    """Mean distances per action, and ROC curves over all experiments of an environment."""
    drawn, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6))
    per_action = tables["reset_free_imagined"]
    agreement = tables["reset_free_imagined_agreement"].set_index("environment")
    experiments = tables["reset_free_imagined_experiments"]
    for k, (name, settings) in enumerate(imagined_runs(config).items()):
        colour = COLOURS[k % len(COLOURS)]
        rows = per_action[per_action["environment"] == name]
        rho = agreement.loc[name, "spearman_distance"]
        left.plot(rows["mean_true"], rows["mean_imagined"], "o", color=colour,
                  label=f"{name}, rank correlation {rho:.2f}")  # fmt: skip
        one = experiments[experiments["environment"] == name]
        events = (one["true"] > settings.threshold).to_numpy()
        if 0 < events.sum() < len(events):
            order = np.argsort(-one["imagined"].to_numpy(), kind="stable")
            hits = np.concatenate([[0], np.cumsum(events[order]) / events.sum()])
            false = np.concatenate([[0], np.cumsum(~events[order]) / (~events).sum()])
            right.plot(false, hits, color=colour,
                       label=f"{name}, area {agreement.loc[name, 'auc']:.2f}")  # fmt: skip
    left.set_xscale("log")
    left.set_yscale("log")
    left.set_xlabel("mean distance of both orders, played")
    left.set_ylabel("mean distance of both orders, imagined")
    left.legend()
    right.plot([0, 1], [0, 1], color=GREY, linestyle=":", linewidth=0.8)
    right.set_xlabel("false positive rate")
    right.set_ylabel("true positive rate")
    right.set_title("orders that do not commute, found by imagined distance")
    right.legend(loc="lower right")
    return drawn
