"""Running experiments in this process or in several, in any order; the distances are the same."""

from __future__ import annotations

import ctypes
import multiprocessing
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.reduction import ForkingPickler
from typing import Any, NamedTuple

import numpy as np

from ..errors import UserError
from ..scp.distances import Distance
from ..scp.experiment import distances_per_dof
from ..scp.world import World
from ..seeding import seed_for
from .controls import has_controls, play_with_controls

CHUNKS_PER_WORKER = 64
"""Chunks into which the experiments of a worker are cut, so that all end at about the same time.
Chosen."""
LARGEST_CHUNK = 50
"""Experiments that a chunk has at most, so that progress is seen and little is lost. Chosen."""


class Protocol(NamedTuple):
    """How an experiment is played.

    Attributes
    ----------
    seed : int
        Root seed; experiment i has a seed of its own, whatever the others are.
    length : int
        Actions in a sequence.
    rest_steps : int
    distance : callable
    """

    seed: int
    length: int
    rest_steps: int
    distance: Distance


def experiment_seed(seed: int, i: int) -> int:
    """Seed of experiment `i`."""
    return seed_for(seed, "experiment", i)


def play_experiments(
    world: World, protocol: Protocol, experiments: Sequence[int]
) -> Iterator[tuple[int, np.ndarray]]:
    """Yield the number of each experiment and its row: float64 (n_dofs, columns).

    The first column is the distance; a world with controls has all of :data:`.controls.COLUMNS`.
    """
    _, length, rest_steps, distance = protocol
    for i in experiments:
        seed = experiment_seed(protocol.seed, i)
        if has_controls(world):
            controlled: Any = world
            yield i, play_with_controls(controlled, seed, length, distance, rest_steps, i)
        else:
            row = distances_per_dof(world, seed, length, distance, rest_steps)
            yield i, np.array(list(row.values()), np.float64)[:, None]


def play_in_parallel(
    make_world: Callable[[], World],
    protocol: Protocol,
    experiments: Sequence[int],
    workers: int,
) -> Iterator[tuple[int, np.ndarray]]:
    """As :func:`play_experiments`, in `workers` processes, in the order in which they end.

    Where the platform can fork, each process starts with a copy of the parent's memory, so that
    worlds need not be picklable; elsewhere `make_world` is pickled.

    Raises
    ------
    UserError
        If a process was killed, or if `make_world` cannot be pickled where it must be.
    """
    can_fork = sys.platform == "linux"  # elsewhere the system's own libraries may not survive it
    context = multiprocessing.get_context("fork" if can_fork else "spawn")
    if not can_fork:
        _require_sendable((make_world, protocol))
    size = min(max(len(experiments) // (CHUNKS_PER_WORKER * workers), 1), LARGEST_CHUNK)
    chunks = [experiments[i : i + size] for i in range(0, len(experiments), size)]
    pool = ProcessPoolExecutor(workers, context, _start_worker, (make_world, protocol))
    try:
        waiting = {pool.submit(_play_chunk, chunk) for chunk in chunks}
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield from future.result()
    except BrokenProcessPool:
        raise UserError(
            "workers: a process was killed, perhaps for want of memory; measure with fewer workers"
        ) from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _require_sendable(arguments: tuple[Callable[[], World], Protocol]) -> None:
    try:
        ForkingPickler.dumps(arguments)
    except Exception as error:  # whatever the world's own parts raise
        raise UserError(
            f"workers: the world or the distance cannot be sent to another process ({error}); give "
            "a function at the top level of a module that returns the world, or workers=1"
        ) from None


_worker: tuple[World, Protocol]
"""World and protocol of this process, if it is a worker."""


PR_SET_PDEATHSIG = 1
"""From linux/prctl.h."""


def _end_with_parent() -> None:
    """Let the system end this process when its parent is killed, which cannot do so itself."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def _start_worker(make_world: Callable[[], Any], protocol: Protocol) -> None:
    global _worker
    _end_with_parent()
    if "torch" in sys.modules:  # threads do not survive a fork
        sys.modules["torch"].set_num_threads(1)
    world: Any = make_world()
    if hasattr(world, "enter_process"):
        world.enter_process()
    _worker = world, protocol


def _play_chunk(experiments: Sequence[int]) -> list[tuple[int, np.ndarray]]:
    return list(play_experiments(*_worker, experiments))


def missing_experiments(distances: np.ndarray) -> list[int]:
    """Rows of `distances`, float (n, n_dofs), that hold no result yet (NaN)."""
    return np.flatnonzero(np.isnan(distances).any(axis=1)).tolist()
