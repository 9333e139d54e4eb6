"""The paper's two alternatives to the SCP, for every degree of freedom (appendix A): how much the
sensors change, and how hard that is to predict."""

from __future__ import annotations

import pandas as pd

from ....seeding import seed_for
from ....storage.columns import FLOAT, INT, Column
from ...config import Config
from ...declarations import Batched, Expected, Shards, table
from ..builders import DOFS
from ..columns import DOF
from ..naive_change import mean_and_standard_error, squared_change
from ..transitions import collect_transitions

COLOUR = "squared 8-bit colour"


def _settings(config: Config, dof: str) -> object:
    flatland = config.flatland
    world, agent = flatland.reference.world, flatland.reference.agent
    return [world, flatland.worlds[world], agent, flatland.agents[agent],
            flatland.sequence_length, flatland.baselines]  # fmt: skip


def _excess_error(baselines: pd.DataFrame) -> pd.DataFrame:
    """Prediction error above the smallest of all degrees of freedom (paper, appendix A)."""
    error = baselines["prediction_mse"]
    return baselines.assign(excess_error=error - error.min())


@table(
    title="Naive change and prediction error of every degree of freedom",
    columns=(
        DOF,
        Column(
            "naive_mse", FLOAT, COLOUR, "mean squared change of the observation in a transition",
            low=0,
        ),
        Column("naive_se", FLOAT, COLOUR, "standard error of naive_mse, sequences as units", low=0),
        Column(
            "prediction_mse", FLOAT, COLOUR,
            "mean squared error of the predicted next observation, test transitions", low=0,
        ),
        Column("prediction_se", FLOAT, COLOUR,
               "standard error of prediction_mse, sequences as units", low=0),
        Column(
            "excess_error", FLOAT, COLOUR,
            "prediction_mse less the smallest of all degrees of freedom", nullable=True,
        ),
        Column("n_transitions", INT, "1", "transitions"),
        Column("n_test", INT, "1", "transitions that tested the prediction"),
    ),
    shards=Shards(runs=lambda config: dict.fromkeys(DOFS, 1), settings=_settings),
    gather=_excess_error,
    expected=lambda config: Expected(("dof",), {(dof,): 1 for dof in DOFS}),
    expected_shard=lambda config, shard: Expected(("dof",), {(shard.run,): 1}),
)  # fmt: skip
def flatland_baselines(config: Config, dof: str) -> Batched:
    """Measure both alternatives for one degree of freedom; the excess error needs all of them."""

    def compute(start: int, stop: int) -> pd.DataFrame:
        from ..prediction import prediction_error  # imports torch

        settings = config.flatland.baselines
        transitions = collect_transitions(config, dof)
        naive, naive_se = mean_and_standard_error(squared_change(transitions))
        seed = seed_for(config.seed, "prediction", dof) % 2**32
        errors = prediction_error(transitions, settings, seed)
        predicted, predicted_se = mean_and_standard_error(errors)
        row = dict(
            dof=dof, naive_mse=naive, naive_se=naive_se, prediction_mse=predicted,
            prediction_se=predicted_se, excess_error=float("nan"),
            n_transitions=settings.transitions, n_test=errors.size * transitions.actions.shape[1],
        )  # fmt: skip
        return pd.DataFrame([row])

    return Batched(compute)
