"""Collision bodies of a scene in PyBullet: a floor, the fixtures and the movable objects.

No body, and no link of a body, has more than one collision shape. When two bodies touch at several
shapes, Bullet processes the contacts in an order that depends on its history, and a replay would
not be exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ....errors import UserError
from .. import frames as fr
from ..bullet import pybullet
from .scene import Movable, Scene, Solid
from .shapes import write_shape

FRICTION = 0.6
"""Friction coefficient between two bodies; chosen: wood on wood has 0.25 to 0.5, rubber and
cardboard more. PyBullet multiplies the values of both bodies."""
ROLLING_FRICTION = 0.005
"""Metres; chosen: a ball that is pushed comes to rest within seconds."""
SPINNING_FRICTION = 0.002
"""Metres; chosen: two thirds of the radius of a contact patch of 3 mm."""
WEIGHTLESS = 1e-4
"""Kilograms: mass of a link that only carries a collision shape; chosen: negligible beside the
body that it belongs to."""


@dataclass(frozen=True)
class Scenery:
    """PyBullet body ids of a scene.

    Attributes
    ----------
    floor : int or None
    fixtures : dict
        Body id -> index of the fixture. A fixture has one body for each of its solids.
    movables : tuple of int
        One body for each movable object, in the order of the scene.
    """

    floor: int | None
    fixtures: dict[int, int]
    movables: tuple[int, ...]


def build_scenery(client: int, scene: Scene) -> Scenery:
    """Add the bodies of a scene to a PyBullet world.

    Parameters
    ----------
    client : int
        PyBullet's physics client id.
    scene : Scene

    Raises
    ------
    UserError
        A movable object has no solid, or a solid that cannot move.
    """
    # Without a visual shape PyBullet derives one from the collision shape. None is ever rendered.
    dummy = pybullet.createVisualShape(pybullet.GEOM_SPHERE, radius=1e-3, physicsClientId=client)
    floor = None
    if scene.solid_floor:
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
        floor = _add_static(client, plane, dummy)
    fixtures = {
        _add_static(client, _create_shape(client, solid), dummy): i
        for i, fixture in enumerate(scene.fixtures)
        for solid in fixture.solids
    }
    movables = tuple(_add_movable(client, scene, movable, dummy) for movable in scene.movables)
    return Scenery(floor, fixtures, movables)


def _add_static(client: int, shape: int, visual: int) -> int:
    # A sleeping rigid body is cheap, and so is what sleeps on it. Movable objects are multibodies
    # instead: replays with movable rigid bodies were not exact.
    body = pybullet.createMultiBody(
        0, shape, visual, useMaximalCoordinates=True, physicsClientId=client
    )
    pybullet.changeDynamics(
        body,
        -1,
        lateralFriction=FRICTION**0.5,
        activationState=pybullet.ACTIVATION_STATE_SLEEP,
        physicsClientId=client,
    )
    return body


def _add_movable(client: int, scene: Scene, movable: Movable, visual: int) -> int:
    if not movable.solids or any(solid.kind == "mesh" for solid in movable.solids):
        raise UserError(
            f"scene {scene.name!r}: the movable object {movable.name!r} must have a solid, "
            "and none that is a mesh; use boxes, cylinders, spheres or hulls"
        )
    shapes = [_create_shape(client, solid) for solid in movable.solids]
    n = len(shapes) - 1  # the base has the first shape, every further shape has a fixed link
    body = pybullet.createMultiBody(
        movable.mass,
        shapes[0],
        visual,
        movable.position,
        movable.rotation,
        linkMasses=[WEIGHTLESS] * n,
        linkCollisionShapeIndices=shapes[1:],
        linkVisualShapeIndices=[visual] * n,
        linkPositions=[(0, 0, 0)] * n,
        linkOrientations=[(0, 0, 0, 1)] * n,
        linkInertialFramePositions=[(0, 0, 0)] * n,
        linkInertialFrameOrientations=[(0, 0, 0, 1)] * n,
        linkParentIndices=[0] * n,
        linkJointTypes=[pybullet.JOINT_FIXED] * n,
        linkJointAxis=[(0, 0, 1)] * n,
        physicsClientId=client,
    )
    for link in range(-1, n):
        pybullet.changeDynamics(
            body,
            link,
            lateralFriction=FRICTION**0.5,
            rollingFriction=ROLLING_FRICTION,
            spinningFriction=SPINNING_FRICTION,
            physicsClientId=client,
        )
    pybullet.changeDynamics(
        body, -1, activationState=pybullet.ACTIVATION_STATE_ENABLE_SLEEPING, physicsClientId=client
    )
    if n:  # PyBullet would give the whole body the inertia of its first shape
        points = np.concatenate([_span_points(solid) for solid in movable.solids])
        x, y, z = np.ptp(points, axis=0) ** 2 * movable.mass / 12  # of the bounding box
        inertia = (y + z, x + z, x + y)
        pybullet.changeDynamics(body, -1, localInertiaDiagonal=inertia, physicsClientId=client)
    return body


def _span_points(solid: Solid) -> np.ndarray:
    """Points whose bounding box is that of the solid, in the frame of its owner: float64 (n, 3)."""
    if solid.vertices is not None:
        points = solid.vertices
    else:
        size = solid.size
        half: tuple[float, ...] = (0.0,) * 3
        if size and solid.kind == "box":
            half = size
        elif size:
            half = {"cylinder": (size[0], *size), "sphere": size * 3}[solid.kind]
        points = np.array(list(product(*((-extent, extent) for extent in half))))
    return fr.apply(fr.from_quaternion(solid.position, solid.rotation), points)


def _create_shape(client: int, solid: Solid) -> int:
    """Create the collision shape of a solid, in the frame of its owner."""
    options: dict[str, Any] = dict(
        collisionFramePosition=solid.position,
        collisionFrameOrientation=solid.rotation,
        physicsClientId=client,
    )
    if solid.kind == "box":
        return pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=solid.size, **options)
    if solid.kind == "cylinder":
        radius, half_height = solid.size
        return pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=radius, height=2 * half_height, **options
        )
    if solid.kind == "sphere":
        return pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=solid.size[0], **options)
    assert solid.vertices is not None
    if solid.kind == "hull":
        file = write_shape(solid.vertices)
    else:
        file = write_shape(solid.vertices, solid.faces)
        options["flags"] = pybullet.GEOM_FORCE_CONCAVE_TRIMESH
    return pybullet.createCollisionShape(pybullet.GEOM_MESH, fileName=str(file), **options)
