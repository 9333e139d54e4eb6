"""Policies that are trained to navigate with each action space (paper, section IV-B)."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd

from ....storage.provenance import package_versions
from ...config import Config
from ...declarations import model
from ..builders import measured_scp, scales_of_run, training_run
from ..runs import TRAINING, training_runs
from ..tables.navigation_curves import navigation_curves


@model(
    title="Policies trained with every action space",
    path="models/navigation/{run}.policy",
    curve="navigation_curves",
    inputs=["navigation_scp"],
    shards=TRAINING,
)
def navigation_policy(scp: pd.DataFrame, config: Config, run: str, outputs: list[Path]) -> None:
    """Train one run, or resume where training was killed; write the policy and its curve."""
    from ....navigation.training import train  # imports torch
    from ....storage.checkpoints import Checkpoint, save_state
    from ...runner import model_metadata, write_shard

    policy, curve = outputs
    action_space, seed = training_runs(config)[run]
    scales = scales_of_run(config, measured_scp(config, scp), action_space, seed)
    training = training_run(config, action_space, seed, scales)
    checkpoint = Checkpoint(curve, f"{training.settings} {json.dumps(package_versions())}")
    rows, trained = train(training, checkpoint)
    save_state(policy, {**trained, "about": model_metadata(navigation_policy, config, run)})
    rows = rows.assign(action_space=action_space, seed=seed)
    write_shard(navigation_curves, config, run, rows, curve)
    checkpoint.remove()
