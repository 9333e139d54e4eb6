"""What several test files build: worlds, situations, sequences."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from sensory_commutativity.studies.config import Config
from sensory_commutativity.studies.flatland.builders import flatland_world
from sensory_commutativity.studies.loading import load
from sensory_commutativity.worlds.corridor import Corridor
from sensory_commutativity.worlds.flatland.agent import Polyphemus
from sensory_commutativity.worlds.flatland.room import FIXED, MAX_CORNERS, Room, Situation
from sensory_commutativity.worlds.flatland.world import FlatlandWorld

ROOT = Path(__file__).resolve().parents[1]
DEFAULT = ROOT / "config" / "default.yaml"

DOFS = [dof.name for dof in Polyphemus().dofs]
FREE_SPACE = Room(things=0, walls=False)
EMPTY = Room(things=0)

_flatland = load(DEFAULT).flatland
_runs = [(run.world, run.agent) for run in _flatland.runs()] + [
    (world, _flatland.reference.agent) for world in _flatland.commutation_worlds()
]
FLATLAND_PAIRS = list(dict.fromkeys(_runs))
"""Every (world, agent) that config/default.yaml uses."""

WALLED_PAIRS = [pair for pair in FLATLAND_PAIRS if _flatland.worlds[pair[0]].walls]

WORLDS = {
    "corridor": lambda: Corridor(),
    "corridor-wall": lambda: Corridor(wall=4),
    "corridor-box": lambda: Corridor(box=2),
    "corridor-box-wall": lambda: Corridor(wall=5, box=2),
    **{
        f"{world}/{agent}": lambda world=world, agent=agent: flatland_world(_flatland, world, agent)
        for world, agent in FLATLAND_PAIRS
    },
}
"""Name -> factory of every world and agent."""


def flatland(pair: tuple[str, str]) -> FlatlandWorld:
    return flatland_world(_flatland, *pair)


def started(world, seed: int = 0):
    """The same world, in the start situation of `seed`."""
    world.reset(np.random.default_rng(seed))
    return world


def drive(dof: str, value: float, steps: int) -> np.ndarray:
    """The same action on one degree of freedom of Flatland, `steps` times."""
    actions = np.zeros((steps, len(DOFS)))
    actions[:, DOFS.index(dof)] = value
    return actions


def full_speed(rng: np.random.Generator, steps: int, n_dofs: int) -> np.ndarray:
    """Commands that mean it: held for ten steps each, so that the agent runs into things."""
    held = np.sign(rng.uniform(-1, 1, (math.ceil(steps / 10), n_dofs)))
    return np.repeat(held, 10, axis=0)[:steps]


def standing(agent: Polyphemus, x: float, y: float, heading: float, things=()) -> Situation:
    """The agent at a place of our choice among `things`, each a dict of vertices, radius, pose, colour and perhaps kind."""
    n = len(things)
    return Situation(
        links=agent.link_poses(x, y, heading),
        kind=np.array([thing.get("kind", FIXED) for thing in things], np.int64).reshape(n),
        vertices=np.array([thing["vertices"] for thing in things], np.int64).reshape(n),
        radius=np.array([thing["radius"] for thing in things], float).reshape(n),
        pose=np.array([thing["pose"] for thing in things], float).reshape(n, 3),
        colour=np.array([thing["colour"] for thing in things], np.uint8).reshape(n, 3),
        corners=np.zeros(n, np.int64),
        path=np.zeros((n, MAX_CORNERS, 2)),
        phase=np.zeros(n),
    )


def enter(
    room: Room, x: float, y: float, heading: float, things=(), agent: Polyphemus | None = None
) -> FlatlandWorld:
    """A world in that situation."""
    agent = agent or Polyphemus()
    world = FlatlandWorld(replace(room, things=len(things)), agent)
    world.enter(standing(agent, x, y, heading, things))
    return world


def linkage(agent: Polyphemus, x: float, y: float, heading: float, joints) -> np.ndarray:
    """Forward kinematics, written anew: (x, y, angle) of base, left upper arm and forearm, right upper arm and forearm."""
    poses = [(x, y, heading)]
    for side, angles in ((1, joints[:2]), (-1, joints[2:])):
        at = np.array([x, y]) + side * agent.base_radius * np.array(
            [-math.sin(heading), math.cos(heading)]
        )
        direction = heading
        for angle in angles:
            direction = direction + angle
            segment = agent.arm_length * np.array([math.cos(direction), math.sin(direction)])
            poses.append((*(at + segment / 2), direction))
            at = at + segment
    return np.array(poses)


def changed(config: Config, **flatland) -> Config:
    """`config` with some values of its section flatland replaced, checked again."""
    from sensory_commutativity.studies.loading import merge, validate

    return validate(merge(config.model_dump(mode="json"), {"flatland": flatland}))
