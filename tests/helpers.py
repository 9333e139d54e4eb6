"""Worlds, situations and sequences that several test modules build."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sensory_commutativity.scp.world import World
from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.builders import flatland_world
from sensory_commutativity.studies.loading import load, merge, validate
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import FIXED, MAX_CORNERS, Room, Situation
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

ROOT = Path(__file__).resolve().parents[1]
DEFAULT = ROOT / "config" / "config.yaml"

DOFS = [dof.name for dof in Polyphemus().dofs]
FREE_SPACE = Room(objects=0, walls=False)
EMPTY = Room(objects=0)

_config = load(DEFAULT).flatland
_pairs = [(run.world, run.agent) for run in _config.runs()]
_pairs += [(world, _config.reference.agent) for world in _config.commutation_worlds()]
FLATLAND_PAIRS = list(dict.fromkeys(_pairs))
"""Every (world, agent) that config/config.yaml uses."""


def make_flatland(pair: tuple[str, str]) -> FlatlandWorld:
    """Build the world of a (world, agent) of config/config.yaml."""
    return flatland_world(_config, *pair)


WALLED_PAIRS = [pair for pair in FLATLAND_PAIRS if _config.worlds[pair[0]].walls]

WORLDS = {
    "corridor": lambda: Corridor(),
    "corridor-wall": lambda: Corridor(wall=4),
    "corridor-box": lambda: Corridor(box=2),
    "corridor-box-wall": lambda: Corridor(wall=5, box=2),
    **{"/".join(pair): lambda pair=pair: make_flatland(pair) for pair in FLATLAND_PAIRS},
}
"""Name -> factory of every world and agent."""


def reset_world(world: World, seed: int = 0) -> Any:
    """Reset the world with `seed` and return it."""
    world.reset(np.random.default_rng(seed))
    return world


def drive(dof: str, value: float, steps: int) -> np.ndarray:
    """The same action on one degree of freedom of Flatland, `steps` times."""
    actions = np.zeros((steps, len(DOFS)))
    actions[:, DOFS.index(dof)] = value
    return actions


def sample_held_commands(rng: np.random.Generator, steps: int, n_dofs: int) -> np.ndarray:
    """Commands at full speed, each held for ten steps: the agent runs into objects."""
    held = np.sign(rng.uniform(-1, 1, (math.ceil(steps / 10), n_dofs)))
    return np.repeat(held, 10, axis=0)[:steps]


def make_situation(
    agent: Polyphemus, x: float, y: float, heading: float, objects: Sequence[dict[str, Any]] = ()
) -> Situation:
    """Place the agent among `objects`: dicts of vertices, radius, pose, colour and maybe kind."""
    n = len(objects)
    return Situation(
        links=agent.link_poses(x, y, heading),
        kind=np.array([o.get("kind", FIXED) for o in objects], np.int64).reshape(n),
        vertices=np.array([o["vertices"] for o in objects], np.int64).reshape(n),
        radius=np.array([o["radius"] for o in objects], float).reshape(n),
        pose=np.array([o["pose"] for o in objects], float).reshape(n, 3),
        colour=np.array([o["colour"] for o in objects], np.uint8).reshape(n, 3),
        corners=np.zeros(n, np.int64),
        path=np.zeros((n, MAX_CORNERS, 2)),
        phase=np.zeros(n),
    )


def make_world(
    room: Room,
    x: float,
    y: float,
    heading: float,
    objects: Sequence[dict[str, Any]] = (),
    agent: Polyphemus | None = None,
) -> FlatlandWorld:
    """Build a world in the situation of :func:`make_situation`."""
    agent = agent or Polyphemus()
    world = FlatlandWorld(replace(room, objects=len(objects)), agent)
    world.enter(make_situation(agent, x, y, heading, objects))
    return world


def forward_kinematics(
    agent: Polyphemus, x: float, y: float, heading: float, joints: Sequence[float] | np.ndarray
) -> np.ndarray:
    """Poses of the links for given joint angles, independent of the implementation: (5, 3)."""
    poses = [(x, y, heading)]
    for side, angles in ((1, joints[:2]), (-1, joints[2:])):
        normal = np.array([-math.sin(heading), math.cos(heading)])
        joint = np.array([x, y]) + side * agent.base_radius * normal
        direction = heading
        for angle in angles:
            direction = direction + angle
            segment = agent.arm_length * np.array([math.cos(direction), math.sin(direction)])
            poses.append((*(joint + segment / 2), direction))
            joint = joint + segment
    return np.array(poses)


def update_flatland(config: Config, **flatland: Any) -> Config:
    """Replace some values of the section flatland and validate the configuration again."""
    return validate(merge(config.model_dump(mode="json"), {"flatland": flatland}))
