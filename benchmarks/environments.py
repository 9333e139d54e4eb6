"""Cost of measuring a Gymnasium environment: prints a table. Run by ``make bench``.

For each environment: processor seconds for 200 starts on one core, the share of time beside the
simulator's own steps, and how many times as fast two processes are.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"

import statistics
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from sensory_commutativity import from_gymnasium, make_environment, measure
from sensory_commutativity.adapters.gymnasium import GymnasiumWorld
from sensory_commutativity.measurement.controls import play_with_controls
from sensory_commutativity.seeding import seed_for

REPEATS = 3


class Setting(NamedTuple):
    """An environment, the length of sequences, most steps of rest, and starts that are timed."""

    env_id: str
    length: int
    rest_steps: int
    starts: int


SETTINGS = (Setting("Pusher-v5", 30, 100, 20), Setting("FetchPush-v4", 20, 10, 8))


def play(world: GymnasiumWorld, setting: Setting, i: int) -> float:
    """Play the experiments of start `i`; returns processor seconds."""
    begun = time.process_time()
    seed = seed_for(0, "bench", i)
    play_with_controls(world, seed, setting.length, world.distance, setting.rest_steps, i)
    return time.process_time() - begun


def replay(world: GymnasiumWorld, setting: Setting, i: int) -> float:
    """Processor seconds of the environment's own steps alone, in the experiments of start `i`."""
    snapshots: Any = world._local.snapshots
    log: list[tuple[Callable[[Any], Any], Any]] = []
    step, restore = snapshots.step, snapshots.restore

    def record(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
        def call(argument: Any) -> Any:
            log.append((function, argument))
            return function(argument)

        return call

    snapshots.step, snapshots.restore = record(step), record(restore)
    try:
        play(world, setting, i)
    finally:
        snapshots.step, snapshots.restore = step, restore
    own, elapsed, at = world.env.step, 0.0, 0
    while at < len(log):
        function, argument = log[at]
        if function is restore:
            restore(argument)
            at += 1
            continue
        until = at
        while until < len(log) and log[until][0] is step:
            until += 1
        actions = [action for _, action in log[at:until]]
        begun = time.process_time()
        for action in actions:
            own(action)
        elapsed += time.process_time() - begun
        at = until
    return elapsed


def measure_overhead(setting: Setting) -> tuple[float, float]:
    """Processor seconds for a start, and the share of time beside the simulator's own steps."""
    world = from_gymnasium(make_environment(setting.env_id))
    play(world, setting, 1000)  # warm-up
    total = own = 0.0
    for i in range(setting.starts):
        # The first starts play more controls than the others do.
        total += play(world, setting, 1000 + i)
        own += replay(world, setting, 1000 + i)
    world.close()
    return total / setting.starts, (total - own) / own


def measure_speedup(setting: Setting) -> float:
    """Wall time with one process over that with two."""
    times = []
    for workers in (1, 2):
        world = from_gymnasium(make_environment(setting.env_id))
        begun = time.perf_counter()
        measure(
            world, 4 * setting.starts, setting.length, rest_steps=setting.rest_steps,
            workers=workers, check=False, progress=False,
        )  # fmt: skip
        times.append(time.perf_counter() - begun)
        world.close()
    return times[0] / times[1]


def main() -> None:
    print(f"{'environment':14} {'200 starts, s':>14} {'overhead':>9} {'2 workers':>10}")
    for setting in SETTINGS:
        overheads = [measure_overhead(setting) for _ in range(REPEATS)]
        seconds = statistics.median(one for one, _ in overheads)
        overhead = statistics.median(share for _, share in overheads)
        speedup = statistics.median(measure_speedup(setting) for _ in range(REPEATS))
        print(
            f"{setting.env_id:14} {200 * seconds:14.0f} {overhead:9.0%} {speedup:9.2f}x", flush=True
        )


if __name__ == "__main__":
    main()
