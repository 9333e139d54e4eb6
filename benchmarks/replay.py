"""Is a replay in the apartment exact, do results depend on what ran before, does memory grow? Run by `make replay`, which takes half an hour.

Every SC-experiment plays each of its two orders twice from the same snapshot: everything about the robot and all objects, and the pictures, must be
equal bit for bit, and memory must not grow. Then a second world plays the experiments once more, the last start situation first, and must end
everywhere as the first world did.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"

import argparse
import hashlib
import resource
from collections.abc import Iterator

import numpy as np

from sensory_commutativity.scp.experiment import ending, orders_per_dof
from sensory_commutativity.seeding import generator, seed_for
from sensory_commutativity.studies.apartment.builders import world_of_run
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment.world import ApartmentWorld

GROWTH = 1.05
"""Memory at the end may be so many times that after a tenth of the experiments; chosen: what is not flat grows by more."""


def ends(
    world: ApartmentWorld, i: int, length: int, plays: int
) -> Iterator[tuple[str, int, list[bytes]]]:
    """Of start situation `i`: degree of freedom, which order, and what each play of it ended in, as hashes."""
    seed = seed_for(1, "replay", i)
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    for dof, first, second in orders_per_dof(world, seed, length):
        for k, order in enumerate((first, second)):
            yield dof, k, [end_of(world, start, order) for _ in range(plays)]


def end_of(world: ApartmentWorld, start, order: np.ndarray) -> bytes:
    end = ending(world, start, order)
    content = hashlib.sha256(end.observation.tobytes())
    for value in (*end.happened, world.simulation.poses()):
        content.update(np.asarray(value).tobytes())
    return content.digest()


def resident() -> float:
    """Memory in use, megabytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--experiments",
        type=int,
        default=1_000,
        help="at least so many, of all degrees of freedom together",
    )
    parser.add_argument("--robot", default="fetch", help="a key of apartment.robots")
    arguments = parser.parse_args()
    config = load("config/default.yaml")
    run = next(
        run
        for run in config.apartment.runs()
        if run.robot == arguments.robot and run.start == "anywhere"
    )
    world, again = world_of_run(config, run), world_of_run(config, run)
    starts = -(-arguments.experiments // len(world.dofs))
    found, unequal, memory = {}, 0, []
    for i in range(starts):
        for dof, k, (one, other) in ends(world, i, run.length, 2):
            found[i, dof, k] = one
            unequal += one != other
        memory.append(resident())
    print(
        f"{run.robot} in {run.scene}: {starts * len(world.dofs)} experiments, {unequal} of {len(found)} orders ended differently when played again"
    )
    print(
        f"memory after {starts // 10 + 1} start situations {memory[starts // 10]:.0f} MB, at the end {memory[-1]:.0f} MB"
    )
    differs = sum(
        found[i, dof, k] != end
        for i in reversed(range(starts))
        for dof, k, (end,) in ends(again, i, run.length, 1)
    )
    print(f"in another world, the other way round: {differs} ended differently")
    grew = memory[-1] > GROWTH * memory[starts // 10]
    raise SystemExit(bool(unequal or differs or grew))


if __name__ == "__main__":
    main()
