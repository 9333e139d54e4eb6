"""The physics engines inside Gymnasium environments: where they are, and what touches what.

Known are MuJoCo as gymnasium, gymnasium-robotics and dm_control (through shimmy) hold it, and
PyBullet as panda-gym does.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np


class MujocoSimulator(NamedTuple):
    """A model and its data, ``mujoco.MjModel`` and ``mujoco.MjData``."""

    model: Any
    data: Any


def find_mujoco(env: Any) -> MujocoSimulator | None:
    """The MuJoCo simulation of an environment, or None."""
    mujoco = sys.modules.get("mujoco")  # whoever has such an environment has imported it
    if mujoco is None:
        return None
    inner = env.unwrapped
    physics = getattr(getattr(inner, "_env", None), "physics", None)  # dm_control in shimmy
    if physics is not None:
        return MujocoSimulator(physics.model.ptr, physics.data.ptr)
    # Mazes hold another environment.
    parts = [inner, *(getattr(part, "unwrapped", part) for part in _attributes(inner))]
    for part in parts:
        data = getattr(part, "data", None)
        if isinstance(data, mujoco.MjData):
            return MujocoSimulator(part.model, data)
    return None


def find_bullet(env: Any) -> Any | None:
    """The PyBullet client of an environment, as panda-gym holds it, or None."""
    return getattr(getattr(env.unwrapped, "sim", None), "physics_client", None)


def _attributes(instance: Any) -> Iterator[Any]:
    yield from getattr(instance, "__dict__", {}).values()


class ContactReader:
    """Reads which pairs of bodies touch.

    Attributes
    ----------
    known : bool
        Whether contacts can be read at all.
    """

    def __init__(self, env: Any):
        self._mujoco, self._bullet = find_mujoco(env), find_bullet(env)
        self.known = self._mujoco is not None or self._bullet is not None
        self._geoms: list[list[int]] = []  # of the last call
        self._pairs = frozenset[tuple[int, ...]]()

    def pairs(self) -> frozenset[tuple[int, ...]]:
        """Pairs of geoms (MuJoCo), or of bodies and links (PyBullet), that touch now."""
        if self._mujoco is not None:
            data = self._mujoco.data
            geoms = data.contact.geom.tolist() if data.ncon else []
            if geoms != self._geoms:  # mostly the same contacts last for many steps
                self._geoms = geoms
                self._pairs = frozenset((min(pair), max(pair)) for pair in geoms)
            return self._pairs
        if self._bullet is not None:
            contacts = self._bullet.getContactPoints() or ()
            return frozenset(tuple(contact[1:5]) for contact in contacts)
        return frozenset()


class MotionReader:
    """Reads where things are that are no part of the agent, by joints without an actuator.

    Attributes
    ----------
    known : bool
        Whether the engine tells (MuJoCo).
    """

    def __init__(self, env: Any):
        simulator = find_mujoco(env)
        self.known = simulator is not None
        if simulator is None:
            return
        self._data = simulator.data
        self._free = free_object_positions(simulator.model)

    def positions(self) -> np.ndarray:
        """Positions of the free bodies, float (3 * bodies,), metres; empty if there is none."""
        return self._data.qpos[self._free].copy() if self.known else np.zeros(0)


def free_object_positions(model: Any) -> np.ndarray:
    """Indices in qpos of the positions of objects: free joints other than the root of an agent, and
    slides and hinges that no actuator drives and that belong to a body without actuated joints."""
    import mujoco

    actuated = set()
    for i in range(model.nu):
        if model.actuator_trntype[i] == mujoco.mjtTrn.mjTRN_JOINT:
            actuated.add(int(model.actuator_trnid[i, 0]))
    roots = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in actuated}
    for i in range(model.neq):  # a body that is welded to a mocap body, as Fetch's gripper is
        if model.eq_type[i] == mujoco.mjtEq.mjEQ_WELD:
            pair = [int(model.eq_obj1id[i]), int(model.eq_obj2id[i])]
            if any(model.body_mocapid[body] >= 0 for body in pair):
                roots |= {int(model.body_rootid[body]) for body in pair}
    indices: list[int] = []
    for joint in range(model.njnt):
        root = int(model.body_rootid[model.jnt_bodyid[joint]])
        if root in roots:
            continue  # a part of the agent
        address = int(model.jnt_qposadr[joint])
        free = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE
        indices.extend(range(address, address + (3 if free else 1)))
    return np.array(indices, int)
