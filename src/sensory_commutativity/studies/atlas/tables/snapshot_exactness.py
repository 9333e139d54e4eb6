"""How often each way to restore the state of an environment is exact, and what it costs."""

from __future__ import annotations

import time
from typing import Any

import pandas as pd

from ....storage.columns import FLOAT, INT, TEXT, Column
from ...config import Config
from ...declarations import Expected, Shards, table
from ..builders import atlas, environments
from ..columns import ENVIRONMENT, ID
from ..config import EnvironmentConfig

WAYS = ("native", "replay", "fork", "set_state", "deepcopy")
REPEATS = 10
"""Snapshots that are timed. Chosen."""


def _expected(config: Config) -> Expected:
    rows = {(name,): len(WAYS) for name in environments(config)}
    return Expected(("environment",), rows)


def _settings(config: Config, run: str) -> object:
    environment = environments(config)[run]
    return [environment.env_id, atlas(config).exactness_tries]


@table(
    title="Exactness of snapshots",
    columns=(
        ENVIRONMENT,
        ID,
        Column("way", TEXT, "", "how the state is restored", key=True),
        Column("tries", INT, "1", "tries"),
        Column("exact", INT, "1", "tries in which every observation was bit-identical"),
        Column("keep_ms", FLOAT, "ms", "time of a snapshot", nullable=True),
        Column("restore_ms", FLOAT, "ms", "time of a restore", nullable=True),
        Column("error", TEXT, "", "why the way could not be tried; empty if it was"),
    ),
    shards=Shards(
        runs=lambda config: dict.fromkeys(environments(config), 1),
        settings=_settings,
    ),
    expected=_expected,
    expected_shard=lambda config, shard: Expected(("environment",), {(shard.run,): None}),
)
def snapshot_exactness(config: Config, run: str) -> pd.DataFrame:
    """Try every way in one environment."""
    from ....adapters.snapshots import WAYS as EXACT_WAYS
    from ....adapters.snapshots import measure_exactness
    from ..ways import DeepcopySnapshots, SetStateSnapshots

    others = {"set_state": SetStateSnapshots, "deepcopy": DeepcopySnapshots}
    settings, rows = environments(config)[run], []
    for way in WAYS:
        make: Any = EXACT_WAYS[way] if way in EXACT_WAYS else others[way]
        result = measure_exactness(_make(settings), make, atlas(config).exactness_tries)
        keep, restore = (None, None) if result.error else _measure_times(_make(settings), make)
        rows.append((run, settings.env_id, way, result.tries, result.exact, keep, restore,
                     result.error))  # fmt: skip
    frame = pd.DataFrame(rows, columns=snapshot_exactness.column_names)
    return frame.astype({"keep_ms": float, "restore_ms": float})


def _make(settings: EnvironmentConfig) -> Any:
    from ....adapters.registry import make_environment

    return make_environment(settings.env_id)


def _measure_times(env: Any, make: Any) -> tuple[float, float]:
    """Mean milliseconds of a snapshot and of a restore, 20 steps after a reset."""
    snapshots, taken = make(env), {"keep": 0.0, "restore": 0.0}
    try:
        snapshots.reset(0)
        for _ in range(20):
            snapshots.step(env.action_space.sample())
        for _ in range(REPEATS):
            begun = time.perf_counter()
            kept = snapshots.snapshot()
            taken["keep"] += time.perf_counter() - begun
            snapshots.step(env.action_space.sample())
            begun = time.perf_counter()
            snapshots.restore(kept)
            taken["restore"] += time.perf_counter() - begun
    finally:
        snapshots.close()
    return 1e3 * taken["keep"] / REPEATS, 1e3 * taken["restore"] / REPEATS
