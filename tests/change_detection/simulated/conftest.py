"""Small scenes for Fetch."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from sensory_commutativity.change_detection.simulated.scene_sampler import SceneSampler
from sensory_commutativity.worlds.apartment import geometry
from sensory_commutativity.worlds.apartment.rendering.camera import Camera
from sensory_commutativity.worlds.apartment.robots.loading import load_robot, set_fixed_joints
from sensory_commutativity.worlds.apartment.scenes.scene import Area, Fixture, Part, Scene, Solid
from sensory_commutativity.worlds.apartment.scenes.scenefile import load_scene
from sensory_commutativity.worlds.apartment.world import ApartmentWorld
from tests.helpers import ROOT

FETCH = ROOT / "config" / "robots" / "fetch.yaml"
APARTMENT = ROOT / "config" / "apartments" / "placida-stand-in.yaml"


def block(name: str, half: tuple[float, float, float], at: tuple[float, float, float]) -> Fixture:
    part = Part(geometry.transform(geometry.box(half), at), (0.7, 0.6, 0.5))
    return Fixture(name, (part,), (Solid("box", half, at),))


@pytest.fixture(scope="session")
def pillar_world():
    """Fetch between a pillar on its left, which its arm hits in a wide sweep, and a low table."""
    pillar = block("pillar", (0.1, 0.1, 1.0), (0.55, 0.45, 1.0))
    table = block("table", (0.3, 0.5, 0.2), (0.8, 0.0, 0.2))
    scene = Scene("two", (pillar, table), (), (Area("room", (-1.0, 1.0), (-1.0, 1.0)),))
    world = ApartmentWorld(scene, load_robot(FETCH), (Camera(64, 64, 90.0, 1),))
    yield world
    world.simulation.close()


@pytest.fixture(scope="session")
def make_sampler() -> Callable[..., SceneSampler]:
    """Factory of scene samplers with 16 objects in an apartment; Fetch looks down."""
    scene = load_scene(APARTMENT)
    robot = set_fixed_joints(load_robot(FETCH), {"head_tilt_joint": 0.5}, "test")

    def make(seed: int, views: tuple[float, ...] = (45.0,), randomize=True) -> SceneSampler:
        cameras = [Camera(128, 128, view, 1) for view in views]
        rng = np.random.default_rng(seed)
        return SceneSampler(scene, robot, cameras, "training", rng, 16, randomize)

    return make
