"""Policies that are trained to navigate with each action space (paper, section IV-B)."""

from __future__ import annotations

import json

import pandas as pd

from ....storage.provenance import package_versions
from ...config import Config
from ...declarations import TrainingOutput, model
from ..builders import measured_scp, scales_of_run, training_run
from ..runs import TRAINING, training_runs


@model(
    title="Policies trained with every action space",
    path="models/navigation/{run}.policy",
    curve="navigation_curves",
    inputs=["navigation_scp"],
    shards=TRAINING,
)
def navigation_policy(scp: pd.DataFrame, config: Config, run: str, output: TrainingOutput) -> None:
    """Train one run, or resume where training was killed; write the policy and its curve."""
    from ....navigation.training import train  # imports torch
    from ....storage.checkpoints import Checkpoint, save_state

    action_space, seed = training_runs(config)[run]
    scales = scales_of_run(config, measured_scp(config, scp), action_space, seed)
    training = training_run(config, action_space, seed, scales)
    versions = json.dumps(package_versions())
    checkpoint = Checkpoint(output.curve, f"{training.settings} {versions}")
    curve, trained = train(training, checkpoint)
    save_state(output.model, {**trained, "about": dict(output.metadata)})
    output.write_curve(curve.assign(action_space=action_space, seed=seed))
    checkpoint.remove()
