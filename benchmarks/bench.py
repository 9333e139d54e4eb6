"""How fast the worlds are, on one core of this machine: prints a table. Run by `make bench`.

Each figure is measured REPEATS times after a warm-up and given as minimum, median and maximum: machines are noisy, quote the median.
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

import numpy as np

from sensory_commutativity.seeding import generator
from sensory_commutativity.studies.flatland.tables.flatland_experiments import run_experiments
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import Room
from sensory_commutativity.worlds.flatland.vector import FlatlandVectorEnv
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

REPEATS = 7


def world_steps() -> float:
    """Steps with an observation each, per second: 40 random start situations with 10 things, 250 random actions of all degrees of freedom in each."""
    world, rng, elapsed = FlatlandWorld(Room(objects=10)), generator(1, "bench"), 0.0
    for _ in range(40):
        world.reset(rng)
        actions = rng.uniform(-1, 1, (250, 8))
        begin = time.perf_counter()
        world.rollout(actions)
        elapsed += time.perf_counter() - begin
    return 40 * 250 / elapsed


def single_steps() -> float:
    """The same, one Python call of step() and one of observe() for each action."""
    world, rng = FlatlandWorld(Room(objects=10)), generator(1, "bench")
    world.reset(rng)
    actions = rng.uniform(-1, 1, (2000, 8))
    begin = time.perf_counter()
    for action in actions:
        world.step(action)
        world.observe()
    return 2000 / (time.perf_counter() - begin)


def vector_steps() -> float:
    """Environment steps per second of 32 rooms over two episodes each, resets included."""
    environment, rng = FlatlandVectorEnv(32), np.random.default_rng(1)
    n = 2 * environment.max_episode_steps
    actions = rng.uniform(-1, 1, (n, 32, 8)).astype(np.float32)
    begin = time.perf_counter()
    environment.reset(seed=1)
    for action in actions:
        environment.step(action)
    return n * 32 / (time.perf_counter() - begin)


def resets() -> float:
    """Random start situations drawn and built, per second."""
    world, rng = FlatlandWorld(Room(objects=10)), generator(1, "bench")
    begin = time.perf_counter()
    for _ in range(300):
        world.reset(rng)
    return 300 / (time.perf_counter() - begin)


def sc_experiments() -> float:
    """SC-experiments of 50 actions per second, start situations and distances included."""
    config = load("config/default.yaml")
    run = config.flatland.runs()[0]
    begin = time.perf_counter()
    run_experiments(config, run, 0, 40)
    return 40 * 8 / (time.perf_counter() - begin)


def learning_steps() -> float:
    """Environment steps per second of a training run, learning included: 32 rooms, all degrees of freedom, three rollouts of a fresh learner."""
    import torch

    from sensory_commutativity.navigation.training import learner_of_run
    from sensory_commutativity.studies.navigation.builders import training_run

    torch.set_num_threads(1)
    config = load("config/default.yaml")
    scales = {dof.name: 1.0 for dof in Polyphemus().dofs}
    learner = learner_of_run(training_run(config, "full", 1000, scales))
    learner.env.seed(1)
    n = 3 * config.navigation.learner.rollout
    begin = time.perf_counter()
    learner.learn(n)
    return n / (time.perf_counter() - begin)


@cache
def _apartment():
    """Fetch in the stand-in for Rs, the features, and a counter of start situations."""
    import torch

    from sensory_commutativity.studies.apartment.builders import perceptual_features, world_of_run

    torch.set_num_threads(1)
    config = load("config/default.yaml")
    return (
        config,
        world_of_run(config, config.apartment.runs()[0]),
        perceptual_features(config),
        count(),
    )


def camera_frames() -> float:
    """Pictures of 128 x 128 pixels with 2 x 2 samples and object ids per second, from random start situations of Fetch in the stand-in for Rs."""
    from sensory_commutativity.worlds.apartment.rendering.camera import Camera

    _, world, _, _ = _apartment()
    camera, rng, elapsed = Camera(128, 128, 90.0, 2), generator(1, "bench"), 0.0
    for _ in range(10):
        world.reset(rng)
        eye, poses = world.simulation.camera_pose(), world.simulation.poses()
        begin = time.perf_counter()
        for _ in range(30):
            world.renderer.render(camera, eye, poses)
        elapsed += time.perf_counter() - begin
    return 300 / elapsed


def apartment_experiments() -> float:
    """SC-experiments of Fetch in the stand-in for Rs per second, all degrees of freedom; starts, both fields of view and features included."""
    from sensory_commutativity.studies.apartment.tables.apartment_experiments import (
        run_experiments as run_apartment,
    )

    config, world, features, numbers = _apartment()
    start = 2 * next(numbers)
    begin = time.perf_counter()
    run_apartment(config, config.apartment.runs()[0], world, features, start, start + 2)
    return 2 * len(world.dofs) / (time.perf_counter() - begin)


MEASURES: tuple[tuple[str, Callable[[], float], float | None], ...] = (
    ("world: steps with observation / s (10 things)", world_steps, 30_000),
    ("world: the same from single Python calls / s", single_steps, None),
    ("vectorised environment: steps / s (32 rooms, resets)", vector_steps, 30_000),
    ("world: resets / s (10 things)", resets, None),
    ("SC-experiments / s (furnished room, 50 actions)", sc_experiments, None),
    ("camera: frames / s (apartment, 128 x 128, 2 x 2 samples)", camera_frames, 700),
    ("SC-experiments / s (Fetch, apartment, features)", apartment_experiments, 2_000 / 720),
    ("training run: steps / s, learning included (32 rooms)", learning_steps, 5_000),
)


def main() -> None:
    print(
        f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}; one core used, {REPEATS} repeats\n"
    )
    print(f"{'measure':58s} {'min':>9s} {'median':>9s} {'max':>9s} {'at least':>9s}")
    for name, measure, wanted in MEASURES:
        measure()  # warm-up: compile, fill caches
        values = sorted(measure() for _ in range(REPEATS))
        shown = [values[0], statistics.median(values), values[-1], *([wanted] if wanted else [])]
        print(
            f"{name:58s} "
            + " ".join(f"{value:9,.0f}" if value >= 100 else f"{value:9.2f}" for value in shown),
            flush=True,
        )


if __name__ == "__main__":
    main()
