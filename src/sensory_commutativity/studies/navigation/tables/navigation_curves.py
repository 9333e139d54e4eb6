"""Training runs, and their learning curves put together (paper, section IV-B)."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd

from ....errors import TableError
from ....storage.provenance import package_versions, provenance
from ....storage.tables import read_table, write_table
from ...config import Config

TABLE = "navigation_curves"


def write_run(
    config: Config, action_space: str, seed: int, navigation_scp: Path, out: Path, model: Path
) -> None:
    """Train one run, or go on with it where it was killed, and write its curve and its model."""
    from ....navigation.training import settings_of_run, train
    from ....storage.checkpoints import Checkpoint, save_state
    from ..builders import measured_scp, scales_of_run

    scales = scales_of_run(
        config,
        measured_scp(config, read_table("navigation_scp", navigation_scp)),
        action_space,
        seed,
    )
    checkpoint = Checkpoint(
        out, f"{settings_of_run(config, scales)} {json.dumps(package_versions())}"
    )
    curve, trained = train(config, action_space, seed, scales, checkpoint)
    save_state(model, {**trained, "about": provenance(config)})
    write_table(TABLE, curve.assign(action_space=action_space, seed=seed), out, config)
    checkpoint.forget()


def gather_curves(parts: list[Path], out: Path, config: Config) -> None:
    """Put the runs together. Raises TableError unless every run of the configuration is there once, with every evaluation."""
    frame = pd.concat([read_table(TABLE, part) for part in parts], ignore_index=True)
    check_runs(frame, config, str(out))
    order = {action_space: i for i, action_space in enumerate(config.navigation.action_spaces)}
    frame = frame.sort_values(
        ["action_space", "seed", "step"],
        key=lambda column: column.map(order) if column.name == "action_space" else column,
    )
    write_table(TABLE, frame, out, config)


def check_runs(curves: pd.DataFrame, config: Config, where: str) -> None:
    """Raise TableError, naming them, where runs are missing, repeated, unknown or evaluated otherwise: no run may silently be dropped."""
    navigation = config.navigation
    segment = navigation.steps // navigation.checkpoints
    wanted = [segment * (k + 1) for k in range(navigation.checkpoints)]
    check_names(curves[["action_space", "seed", "step"]], config, where)
    runs = curves.groupby(["action_space", "seed"])
    steps = runs["step"].agg(sorted)
    _refuse(
        "incomplete, or evaluated after other steps",
        set(steps.index[[found != wanted for found in steps]]),
        config,
        where,
    )
    other = runs["episodes"].agg(lambda found: (found != navigation.evaluation_episodes).any())
    _refuse("evaluated with another number of episodes", set(other.index[other]), config, where)
    returns = runs["episode_return"].agg(lambda found: not np.isfinite(found).all())
    _refuse("with returns that are no numbers", set(returns.index[returns]), config, where)


def check_names(names: pd.DataFrame, config: Config, where: str) -> None:
    """Raise TableError unless the rows (action_space, seed, and what else tells rows apart) are of the configuration's runs, all of them, once."""
    found, wanted = (
        set(zip(names["action_space"], names["seed"], strict=True)),
        set(config.navigation.runs),
    )
    _refuse("missing", wanted - found, config, where)
    _refuse("not asked for", found - wanted, config, where)
    twice = names[names.duplicated()]
    _refuse("repeated", set(zip(twice["action_space"], twice["seed"], strict=True)), config, where)


def _refuse(problem: str, runs: set[tuple[str, int]], config: Config, where: str) -> None:
    if runs:
        names = ", ".join(f"{action_space} {seed}" for action_space, seed in sorted(runs)[:5])
        more = f" and {len(runs) - 5} more" if len(runs) > 5 else ""
        n = len(config.navigation.runs)
        raise TableError(
            f"{where}: {len(runs)} of {n} training runs {problem} ({names}{more}); nothing was written: run them again"
        )
