"""Speed of the worlds, on one core of this machine: prints a table. Run by ``make bench``.

Every measure is repeated REPEATS times after a warm-up, and given as minimum, median and maximum.
Machines are noisy: quote the median.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"

import platform
import statistics
import time
from collections.abc import Callable
from functools import cache
from itertools import count
from typing import Any

import numpy as np

from sensory_commutativity.scp.experiment import distances_per_dof
from sensory_commutativity.seeding import generator, seed_for
from sensory_commutativity.studies.flatland.builders import flatland_world
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import Room
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

REPEATS = 7


def rollout_steps() -> float:
    """Steps with observations per second, 250 random actions from each of 40 start situations."""
    world, rng, elapsed = FlatlandWorld(Room(objects=10)), generator(1, "bench"), 0.0
    for _ in range(40):
        world.reset(rng)
        actions = rng.uniform(-1, 1, (250, 8))
        start = time.perf_counter()
        world.rollout(actions)
        elapsed += time.perf_counter() - start
    return 40 * 250 / elapsed


def single_steps() -> float:
    """The same with a Python call of ``step`` and one of ``observe`` for each action."""
    world, rng = FlatlandWorld(Room(objects=10)), generator(1, "bench")
    world.reset(rng)
    actions = rng.uniform(-1, 1, (2000, 8))
    start = time.perf_counter()
    for action in actions:
        world.step(action)
        world.observe()
    return 2000 / (time.perf_counter() - start)


def vector_steps() -> float:
    """Environment steps per second of 32 rooms over two episodes each, resets included."""
    environment, rng = FlatlandVectorEnv(32), np.random.default_rng(1)
    n = 2 * environment.max_episode_steps
    actions = rng.uniform(-1, 1, (n, 32, 8)).astype(np.float32)
    start = time.perf_counter()
    environment.reset(seed=1)
    for action in actions:
        environment.step(action)
    return n * 32 / (time.perf_counter() - start)


def resets() -> float:
    """Random start situations per second."""
    world, rng = FlatlandWorld(Room(objects=10)), generator(1, "bench")
    start = time.perf_counter()
    for _ in range(300):
        world.reset(rng)
    return 300 / (time.perf_counter() - start)


def flatland_experiments() -> float:
    """SC-experiments of 50 actions per second, start situations and distances included."""
    config = load("config/config.yaml")
    run = config.flatland.runs()[0]
    start = time.perf_counter()
    world = flatland_world(config.flatland, run.world, run.agent)
    for i in range(40):
        distances_per_dof(world, seed_for(1, "bench", i), run.length)
    return 40 * len(world.dofs) / (time.perf_counter() - start)


def training_steps() -> float:
    """Environment steps per second of a training run, learning included: three rollouts of a new
    learner in 32 rooms, all degrees of freedom."""
    import torch

    from sensory_commutativity.navigation.training import learner_of_run
    from sensory_commutativity.studies.navigation.builders import training_run

    torch.set_num_threads(1)
    config = load("config/config.yaml")
    scales = {dof.name: 1.0 for dof in Polyphemus().dofs}
    learner = learner_of_run(training_run(config, "full", 1000, scales))
    assert learner.env is not None
    learner.env.seed(1)
    n = 3 * config.navigation.learner.rollout
    start = time.perf_counter()
    learner.learn(n)
    return n / (time.perf_counter() - start)


@cache
def _apartment() -> tuple[Any, ...]:
    """Fetch in the stand-in for Rs, the VGG16 features, and a counter of start situations."""
    import torch

    from sensory_commutativity.studies.apartment.builders import (
        build_run_world,
        perceptual_features,
    )

    torch.set_num_threads(1)
    config = load("config/config.yaml")
    world = build_run_world(config, config.apartment.runs()[0])
    return config, world, perceptual_features(config), count()


def camera_frames() -> float:
    """Images of 128 x 128 pixels, with 2 x 2 samples and segmentation ids, per second, from random
    start situations of Fetch in the stand-in for Rs."""
    from sensory_commutativity.worlds.apartment.rendering.camera import Camera

    _, world, _, _ = _apartment()
    camera, rng, elapsed = Camera(128, 128, 90.0, 2), generator(1, "bench"), 0.0
    for _ in range(10):
        world.reset(rng)
        eye, poses = world.simulation.camera_pose(), world.simulation.poses()
        start = time.perf_counter()
        for _ in range(30):
            world.renderer.render(camera, eye, poses)
        elapsed += time.perf_counter() - start
    return 300 / elapsed


def apartment_experiments() -> float:
    """SC-experiments of Fetch in the stand-in for Rs per second; start situations, both fields of
    view and features included."""
    from sensory_commutativity.studies.apartment.tables.apartment_experiments import (
        run_experiments,
    )

    config, world, features, numbers = _apartment()
    first = 2 * next(numbers)
    start = time.perf_counter()
    run_experiments(config, config.apartment.runs()[0], world, features, first, first + 2)
    return 2 * len(world.dofs) / (time.perf_counter() - start)


MEASURES: tuple[tuple[str, Callable[[], float], float | None], ...] = (
    ("world: steps with observation / s (10 objects)", rollout_steps, 30_000),
    ("world: the same from single Python calls / s", single_steps, None),
    ("vector environment: steps / s (32 rooms, resets)", vector_steps, 30_000),
    ("world: resets / s (10 objects)", resets, None),
    ("SC-experiments / s (furnished room, 50 actions)", flatland_experiments, None),
    ("camera: frames / s (apartment, 128 x 128, 2 x 2 samples)", camera_frames, 700),
    ("SC-experiments / s (Fetch, apartment, features)", apartment_experiments, 2_000 / 720),
    ("training run: steps / s, learning included (32 rooms)", training_steps, 5_000),
)
"""Title, function that measures, and the least value that is wanted."""


def main() -> None:
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}; "
        f"one core used, {REPEATS} repeats\n"
    )
    print(f"{'measure':58s} {'min':>9s} {'median':>9s} {'max':>9s} {'wanted':>9s}")
    for title, measure, wanted in MEASURES:
        measure()  # warm-up: compiles, fills caches
        values = sorted(measure() for _ in range(REPEATS))
        columns = [values[0], statistics.median(values), values[-1]]
        columns += [wanted] if wanted is not None else []
        cells = (f"{value:9,.0f}" if value >= 100 else f"{value:9.2f}" for value in columns)
        print(f"{title:58s} {' '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
