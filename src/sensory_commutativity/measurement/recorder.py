"""Recording a robot that moves by the return protocol, step by step.

:mod:`.logs` says what the file holds, and measures it.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import ArgumentError
from ..scp.world import Observation, SteppableWorld
from ..storage.atomic import atomic_write
from ..storage.provenance import environment
from .logs import BETWEEN, METADATA

FORWARDED = (
    "reset", "snapshot", "restore", "limit", "has_inverse", "distance", "unit", "choices",
    "observes_images", "knows_contacts", "reaches_stop", "reseed",
)  # fmt: skip
"""What a recorder offers where the world within does."""


class Recorder:
    """A world whose steps are recorded; otherwise it is the world within.

    Parameters
    ----------
    world : SteppableWorld
    clock : callable, optional
        Returns the time in seconds; by default that of the computer.
    """

    def __init__(self, world: SteppableWorld, clock: Callable[[], float] = time.monotonic):
        self.world, self.dofs, self._clock = world, tuple(world.dofs), clock
        self.name = getattr(world, "name", type(world).__name__)
        self.rows: list[tuple[int, int, float, int, int, np.ndarray, np.ndarray]] = []
        self._episode, self._trials, self._step, self._leg, self._dof = BETWEEN, 0, 0, 0, BETWEEN
        self._began: float | None = None
        for name in FORWARDED:
            if hasattr(world, name):
                setattr(self, name, getattr(world, name))
        if hasattr(world, "rest"):
            self.rest = self._rest

    def begin_trial(self, dof: int) -> None:
        self._episode, self._step, self._leg, self._dof = self._trials, 0, 0, dof
        self._trials += 1
        self._record(np.zeros(len(self.dofs)))

    def end_trial(self) -> None:
        self._episode, self._step, self._leg, self._dof = BETWEEN, 0, 0, BETWEEN

    def step(self, action: np.ndarray) -> None:
        self.world.step(action)
        self._record(np.asarray(action, np.float64))

    def play(self, actions: np.ndarray) -> None:
        """Play a leg, step by step; a leg begins with each call."""
        self._leg += 1
        for action in actions:
            self.step(action)

    def observe(self) -> Observation:
        return self.world.observe()

    def _rest(self, most: int) -> None:
        """Rest as the world within does; what it does meanwhile is recorded as one step."""
        self.world.rest(most)  # type: ignore[attr-defined]
        self._record(np.zeros(len(self.dofs)))

    def _record(self, action: np.ndarray) -> None:
        now = self._clock()
        self._began = now if self._began is None else self._began
        view = np.array(self.world.observe())
        self.rows.append(
            (self._episode, self._step, now - self._began, self._leg, self._dof, action, view)
        )
        self._step += 1


def write_log(path: str | Path, recorder: Recorder, distance: str = "mse") -> Path:
    """Write what was recorded; the file says how to measure it.

    Raises
    ------
    ArgumentError
        If nothing was recorded.
    """
    path = Path(path)
    if not recorder.rows:
        raise ArgumentError(f"{path}: nothing was recorded; measure with protocol='return' first")
    episode, step, seconds, leg, dof, actions, views = zip(*recorder.rows, strict=True)
    described: dict[str, Any] = dict(
        world=recorder.name, dofs=[asdict(dof) for dof in recorder.dofs], distance=distance,
        shape=list(views[0].shape), dtype=str(views[0].dtype),
    )  # fmt: skip
    if distance == "scaled":
        scaled: Any = recorder.world
        units = np.ravel(scaled.unit)
        described["unit"] = [float(unit) if np.isfinite(unit) else None for unit in units]
    flat = [np.ravel(view) for view in views]
    table = pa.table(
        dict(
            episode=pa.array(episode, pa.int64()), step=pa.array(step, pa.int64()),
            time=pa.array(seconds, pa.float64()), leg=pa.array(leg, pa.int64()),
            dof=pa.array(dof, pa.int64()),
            action=pa.array(list(actions), pa.list_(pa.float64())),
            observation=pa.array(flat, pa.list_(pa.from_numpy_dtype(flat[0].dtype))),
        )
    )  # fmt: skip
    metadata = {METADATA: json.dumps(described), **environment()}
    with atomic_write(path) as temporary:
        pq.write_table(table.replace_schema_metadata(metadata), temporary, compression="zstd")
    return path
