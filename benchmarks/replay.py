"""Is a replay in the apartment exact, do results depend on what ran before, does memory grow?

Run by ``make replay``, which takes a quarter of an hour. Every SC-experiment plays each of its two
orders twice from the same snapshot: the state of the robot and of all objects and the images must
be equal bit for bit, and memory must not grow. Then a second world plays all experiments once more,
the last start situation first, and must end every time as the first world did.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"

import argparse
import hashlib
import resource
from collections.abc import Iterator

import numpy as np

from sensory_commutativity.scp.experiment import orders_per_dof, play_order
from sensory_commutativity.scp.world import Snapshot
from sensory_commutativity.seeding import generator, seed_for
from sensory_commutativity.studies.apartment.builders import build_run_world
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.apartment.world import ApartmentWorld

GROWTH = 1.05
"""Memory at the end relative to that after a tenth of the experiments, at most; chosen: a leak
grows by more."""


def play_experiments(
    world: ApartmentWorld, i: int, length: int, repeats: int
) -> Iterator[tuple[str, int, list[bytes]]]:
    """Play the experiments of start situation `i`, each order `repeats` times.

    Yields
    ------
    dof : str
    order : int
        0 or 1.
    ends : list of bytes
        A hash of how each repeat ended.
    """
    seed = seed_for(1, "replay", i)
    world.reset(generator(seed, "situation"))
    start = world.snapshot()
    for dof, *sequences in orders_per_dof(world, seed, length):
        for order, sequence in enumerate(sequences):
            yield dof, order, [hash_end(world, start, sequence) for _ in range(repeats)]


def hash_end(world: ApartmentWorld, start: Snapshot, sequence: np.ndarray) -> bytes:
    """A hash of everything at the end of an order: images, contacts, joints and poses."""
    play_order(world, start, sequence)
    content = hashlib.sha256(world.observe().tobytes())
    for value in (*world.happened(), world.simulation.poses()):
        content.update(np.asarray(value).tobytes())
    return content.digest()


def resident_memory() -> float:
    """Resident memory of this process, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--experiments",
        type=int,
        default=1_000,
        help="least number of experiments, of all degrees of freedom together",
    )
    parser.add_argument("--robot", default="fetch", help="a key of apartment.robots")
    arguments = parser.parse_args()
    config = load("config/config.yaml")
    run = next(
        run
        for run in config.apartment.runs()
        if run.robot == arguments.robot and run.start == "anywhere"
    )
    world, second_world = build_run_world(config, run), build_run_world(config, run)
    starts = -(-arguments.experiments // len(world.dofs))
    ends, unequal, memory = {}, 0, []
    for i in range(starts):
        for dof, order, (end, repeated) in play_experiments(world, i, run.length, 2):
            ends[i, dof, order] = end
            unequal += end != repeated
        memory.append(resident_memory())
    print(
        f"{run.robot} in {run.scene}: {starts * len(world.dofs)} experiments, "
        f"{unequal} of {len(ends)} orders ended differently when played again"
    )
    tenth = starts // 10
    print(
        f"memory after {tenth + 1} start situations {memory[tenth]:.0f} MB, "
        f"at the end {memory[-1]:.0f} MB"
    )
    different = sum(
        ends[i, dof, order] != end
        for i in reversed(range(starts))
        for dof, order, (end,) in play_experiments(second_world, i, run.length, 1)
    )
    print(f"in another world, in reverse order: {different} ended differently")
    grows = memory[-1] > GROWTH * memory[tenth]
    raise SystemExit(bool(unequal or different or grows))


if __name__ == "__main__":
    main()
