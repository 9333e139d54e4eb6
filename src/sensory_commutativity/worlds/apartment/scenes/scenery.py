"""What PyBullet makes of a scene: bodies for the fixtures, a body for every movable object, a floor.

No body, and no link of a body, has more than one collision shape: of two things that touch at several shapes, Bullet treats the contacts in an order
that depends on what happened before, and a replay would not be exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pybullet

from ....errors import UserError
from .. import frames as fr
from .scene import Movable, Scene, Solid
from .shapes import shape_file

FRICTION = 0.6  # of two things; chosen: wood on wood is 0.25 to 0.5, rubber and cardboard are more. PyBullet multiplies the values of both
ROLLING_FRICTION = 0.005  # metres; chosen: a ball that is pushed comes to rest within seconds
SPINNING_FRICTION = 0.002  # metres; chosen: two thirds of the radius of a contact patch of 3 mm
WEIGHTLESS = 1e-4
"""Kilograms of a link that only carries a collision shape; chosen: nothing beside whatever it is part of."""


@dataclass(frozen=True)
class Scenery:
    """PyBullet's numbers of the bodies of a scene."""

    floor: int | None
    fixtures: dict[int, int]  # body -> index of the fixture; a fixture has as many bodies as solids
    movables: tuple[int, ...]


def build_scenery(client: int, scene: Scene) -> Scenery:
    """Put the floor, the fixtures and the movable objects of `scene` into PyBullet's world `client`. Raises UserError."""
    # Without a visual shape PyBullet makes one from the collision shape, as large as that; none is ever drawn.
    unseen = pybullet.createVisualShape(pybullet.GEOM_SPHERE, radius=1e-3, physicsClientId=client)

    def static(shape: int) -> int:
        # A rigid body that sleeps costs little, and what sleeps on it less. Movable objects are multibodies: as such bodies, replays were not exact.
        body = pybullet.createMultiBody(
            0, shape, unseen, useMaximalCoordinates=True, physicsClientId=client
        )
        pybullet.changeDynamics(
            body,
            -1,
            lateralFriction=FRICTION**0.5,
            activationState=pybullet.ACTIVATION_STATE_SLEEP,
            physicsClientId=client,
        )
        return body

    floor = (
        static(pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client))
        if scene.solid_floor
        else None
    )
    fixtures = {
        static(_shape(client, solid)): i
        for i, fixture in enumerate(scene.fixtures)
        for solid in fixture.solids
    }
    return Scenery(
        floor,
        fixtures,
        tuple(_movable(client, scene, movable, unseen) for movable in scene.movables),
    )


def _movable(client: int, scene: Scene, movable: Movable, unseen: int) -> int:
    if not movable.solids or any(solid.kind == "mesh" for solid in movable.solids):
        raise UserError(
            f"scene {scene.name!r}: the movable object {movable.name!r} must have a solid, "
            "and none that is a mesh; use boxes, cylinders, spheres or hulls"
        )
    shapes = [_shape(client, solid) for solid in movable.solids]
    further = len(shapes) - 1
    body = pybullet.createMultiBody(
        movable.mass, shapes[0], unseen, movable.position, movable.rotation,
        linkMasses=[WEIGHTLESS] * further, linkCollisionShapeIndices=shapes[1:], linkVisualShapeIndices=[unseen] * further,
        linkPositions=[(0, 0, 0)] * further, linkOrientations=[(0, 0, 0, 1)] * further,
        linkInertialFramePositions=[(0, 0, 0)] * further, linkInertialFrameOrientations=[(0, 0, 0, 1)] * further,
        linkParentIndices=[0] * further, linkJointTypes=[pybullet.JOINT_FIXED] * further, linkJointAxis=[(0, 0, 1)] * further,
        physicsClientId=client,
    )  # fmt: skip
    for link in range(-1, further):
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
    if further:  # PyBullet would take the first shape's inertia for the whole; of a single shape it takes the right one
        corners = np.concatenate([_bounds(solid) for solid in movable.solids])
        x, y, z = (
            np.ptp(corners, axis=0) ** 2 * movable.mass / 12
        )  # of a box as large as the object
        pybullet.changeDynamics(
            body, -1, localInertiaDiagonal=(y + z, x + z, x + y), physicsClientId=client
        )
    return body


def _bounds(solid: Solid) -> np.ndarray:
    """Points that span a solid, in the frame of what it belongs to: float64 (n, 3)."""
    if solid.vertices is not None:
        points = solid.vertices
    else:
        half = (
            {"box": solid.size, "cylinder": (solid.size[0], *solid.size), "sphere": solid.size * 3}[
                solid.kind
            ]
            if solid.size
            else (0.0,) * 3
        )
        points = np.array(
            [
                [x, y, z]
                for x in (-half[0], half[0])
                for y in (-half[1], half[1])
                for z in (-half[2], half[2])
            ]
        )
    return fr.apply(fr.from_quaternion(solid.position, solid.rotation), points)


def _shape(client: int, solid: Solid) -> int:
    """The collision shape of a solid, in the frame of what it belongs to."""
    at: dict[str, Any] = dict(
        collisionFramePosition=solid.position,
        collisionFrameOrientation=solid.rotation,
        physicsClientId=client,
    )
    if solid.kind == "box":
        return pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=solid.size, **at)
    if solid.kind == "cylinder":
        return pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=solid.size[0], height=2 * solid.size[1], **at
        )
    if solid.kind == "sphere":
        return pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=solid.size[0], **at)
    if solid.kind == "hull":
        return pybullet.createCollisionShape(
            pybullet.GEOM_MESH, fileName=str(shape_file(solid.vertices)), **at
        )  # type: ignore[arg-type]
    file = str(shape_file(solid.vertices, solid.faces))  # type: ignore[arg-type]
    return pybullet.createCollisionShape(
        pybullet.GEOM_MESH, fileName=file, flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH, **at
    )
