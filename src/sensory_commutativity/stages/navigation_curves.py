"""Training runs, and their learning curves put together (paper, section IV-B)."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd

from ..config import Config
from ..errors import TableError
from ..provenance import package_versions
from ..tables import read_table, write_table

TABLE = "navigation_curves"


def write_run(config: Config, action_space: str, seed: int, navigation_scp: Path, out: Path, model: Path) -> None:
    """Train one run, or go on with it where it was killed, and write its curve and its model."""
    from ..navigation.checkpoints import Checkpoint, save_state
    from ..navigation.from_config import measured_scp, scales_of_run
    from ..navigation.training import settings_of_run, train

    scales = scales_of_run(config, measured_scp(config, read_table("navigation_scp", navigation_scp)), action_space, seed)
    checkpoint = Checkpoint(out, f"{settings_of_run(config, scales)} {json.dumps(package_versions())}")
    curve, trained = train(config, action_space, seed, scales, checkpoint)
    save_state(model, trained)
    write_table(TABLE, curve.assign(action_space=action_space, seed=seed), out, config)
    checkpoint.forget()


def gather_curves(parts: list[Path], out: Path, config: Config) -> None:
    """Put the runs together. Raises TableError unless every run of the configuration is there once, with every evaluation."""
    frame = pd.concat([read_table(TABLE, part) for part in parts], ignore_index=True)
    check_runs(frame, config, str(out))
    order = {action_space: i for i, action_space in enumerate(config.navigation.action_spaces)}
    frame = frame.sort_values(["action_space", "seed", "step"], key=lambda column: column.map(order) if column.name == "action_space" else column)
    write_table(TABLE, frame, out, config)


def check_runs(curves: pd.DataFrame, config: Config, where: str) -> None:
    """Raise TableError, naming them, where runs are missing, repeated, unknown or incomplete: no run may silently be dropped."""
    navigation = config.navigation
    evaluations = curves.groupby(["action_space", "seed"])["step"].agg(["size", "nunique"])
    found, wanted = set(evaluations.index), set(navigation.runs)
    for problem, runs in (
        ("missing", wanted - found),
        ("not asked for", found - wanted),
        ("repeated", set(evaluations.index[evaluations["size"] > evaluations["nunique"]])),
        ("incomplete", set(evaluations.index[evaluations["nunique"] < navigation.checkpoints])),
    ):
        if runs:
            names = ", ".join(f"{action_space} {seed}" for action_space, seed in sorted(runs)[:5])
            more = f" and {len(runs) - 5} more" if len(runs) > 5 else ""
            raise TableError(f"{where}: {len(runs)} of {len(wanted)} training runs {problem} ({names}{more}); nothing was written: run them again")
